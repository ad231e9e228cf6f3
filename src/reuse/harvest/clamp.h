// The clamp: bounds what one path brings to a hit, and keeps what it removes, so that picture and removed light together are
// the estimate without bias (src/reuse/estimators.md, E15). Emission that is seen, but for that at the end of chains, and direct light at
// first hits are not clamped.
#ifndef REFRAME_REUSE_HARVEST_CLAMP_H
#define REFRAME_REUSE_HARVEST_CLAMP_H

#include "math/vec3.h"
#include "render/clamp_threshold.h"
#include "reuse/harvest/harvest.h"

#include <math.h>

// Of a batch.
typedef struct RfClampHits
{
    float threshold[RF_CLAMP_KINDS]; // c, luminance
    RfClampWatch* watch;             // is told of all that paths bring; NULL: nobody
    RF_ALIGN float dimmed[RF_LANES]; // by hit: luminance of the throughput of the chain that leads there, 1 without
} RfClampHits;

// κ = min(1, c / Q) of a path that brings `value` to a hit, or to a miss behind the hits.
static inline float rf_clamp_share( const RfClampHits* clamp, RfClampKind kind, const RfHitBatch* batch, int listed,
                                    const float value[3] )
{
    float q = rf_luminance( rf_vec3( value[0], value[1], value[2] ) ) * ( listed < batch->count ? clamp->dimmed[listed] : 1.0f );
    if ( clamp->watch != NULL )
        rf_watch_path( clamp->watch, kind, batch->pixel[listed], q );
    return q > clamp->threshold[kind] ? clamp->threshold[kind] / q : 1.0f;
}

// Adds what is left of a value to `picture`, and what is removed to `removed`; returns whether anything is.
static inline bool rf_add_clamped( const RfClampHits* clamp, RfClampKind kind, const RfHitBatch* batch, int listed,
                                   const float value[3], float* picture, float* removed )
{
    float share = rf_clamp_share( clamp, kind, batch, listed, value );
    for ( int c = 0; c < 3; ++c )
    {
        float kept = share * value[c];
        picture[c] += kept;
        removed[c] += value[c] - kept;
    }
    return share < 1.0f;
}

#endif
