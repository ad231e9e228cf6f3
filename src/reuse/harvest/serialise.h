// Batches of hit records as byte strings, to hold many of them in memory: lossless,
// and without what can be derived from the rest.
#ifndef REFRAME_REUSE_HARVEST_SERIALISE_H
#define REFRAME_REUSE_HARVEST_SERIALISE_H

#include "reuse/harvest/records.h"

// Writes a batch to `memory` and returns its size in bytes. With NULL it only counts,
// for which normals, pixels and the number of hits per model are enough.
size_t rf_serialise_batch( const RfBatchShape* shape, const RfHitBatch* batch, void* memory );

// Reads it back into a batch laid out with the same shape, or one of more eyes.
void rf_deserialise_batch( const RfBatchShape* shape, const void* memory, RfHitBatch* batch );

#endif
