// The range of the MIS weights that renders use, for tests of their stability.
#ifndef REFRAME_REUSE_WEIGHT_RANGE_H
#define REFRAME_REUSE_WEIGHT_RANGE_H

#include <stdint.h>

// Of the weights over eyes (E1) and over the paths of a tile (E5), for a technique of one sample.
typedef struct RfWeightRange
{
    float least, most;
    uint64_t count; // of the weights above 0
    uint64_t nans;
} RfWeightRange;

// Collects the range of the weights of all renders from now on; NULL: of none. Renders must have one thread then.
void rf_watch_weights( RfWeightRange* range );

// Notes weights that are multiplied by `scale`.
void rf_note_weights( const float* weight, int count, float scale );

#endif
