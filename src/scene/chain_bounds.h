// Where the mirrors and the glass of a scene are, in a few boxes: most rays pass all of them (path/chain_samples.h).
#ifndef REFRAME_SCENE_CHAIN_BOUNDS_H
#define REFRAME_SCENE_CHAIN_BOUNDS_H

#include "scene/scene.h"

#define RF_MAX_CHAIN_BOUNDS 16

typedef struct RfChainBounds
{
    int count;
    RfVec3 low[RF_MAX_CHAIN_BOUNDS], high[RF_MAX_CHAIN_BOUNDS];
} RfChainBounds;

// Bounds the triangles of mirrors and of glass that is not thin, by boxes that are split where that leaves out space. Fails with
// RF_ERROR_MEMORY only.
RfResult rf_bound_chains( const RfScene* scene, RfChainBounds* bounds, RfError* error );

// Whether `count` rays o + t d, t > 0, of unit d, may meet one of the boxes: 1 or 0.
void rf_meet_chain_bounds( const RfChainBounds* bounds, int count, const float* const o[3], const float* const d[3],
                           float* meets );

#endif
