// Harvested batches of hit records as a row of bytes, for holding many of them:
// without loss, and without what can be had back from the rest.
#ifndef REFRAME_REUSE_SERIALISE_H
#define REFRAME_REUSE_SERIALISE_H

#include "reuse/records.h"

// Packs a batch into `memory` and returns the bytes; with NULL it only counts
// them, for which normals, pixels and the numbers of the hits are enough.
size_t rf_serialise_batch( const RfBatchShape* shape, const RfHitBatch* batch, void* memory );

// Back into a batch laid out by rf_lay_out_batch with the shape, or with one of more eyes.
void rf_deserialise_batch( const RfBatchShape* shape, const void* memory, RfHitBatch* batch );

#endif
