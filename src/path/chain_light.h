// Light that a path finds by a chain, a run of mirrors and smooth glass from its first hit to emission. Other hits may follow
// the same chain (src/reuse/tile_chains.h).
#ifndef REFRAME_PATH_CHAIN_LIGHT_H
#define REFRAME_PATH_CHAIN_LIGHT_H

#include "path/lanes.h"

#define RF_MAX_CHAIN_LIGHT 16 // vertices of such a chain

// By slot.
typedef struct RfChainLight
{
    RF_ALIGN float light[3][RF_LANES]; // that leaves the chain's first vertex towards the hit; 0: none
    uint16_t transmitted[RF_LANES];    // bit v: transmission at vertex v of the chain, from 0; else reflection
    uint8_t length[RF_LANES];          // its vertices
    bool open[RF_LANES];               // the path has only seen such vertices since its hit, and no emission yet
} RfChainLight;

// Whether a lane scattered along a ray of density `pdf` as a mirror or smooth glass does. Thin panes are none: rays that pass
// them by chance do not stop there.
static inline bool rf_is_chain_event( const RfVertexLanes* v, int i, float pdf )
{
    return i >= rf_record_count( v ) && pdf == RF_DELTA_PDF && v->param[RF_PARAM_SHAPE][i] == 0.0f &&
           v->param[RF_PARAM_IOR][i] >= 0.0f;
}

// Notes what happened at the path's `vertex`-th vertices, from which it goes on to wi. The first of them begins it.
void rf_note_chain_events( RfChainLight* chain_light, const RfVertexLanes* vertices, int vertex, const float* const wi[3],
                           const float* pdf_solid_angle );

// Takes the emission that the path of a slot has hit, with its throughput, if it came there by a chain.
static inline bool rf_take_chain_light( RfChainLight* chain_light, int slot, const float light[3] )
{
    bool taken = chain_light->open[slot] && chain_light->length[slot] > 0 && light[0] + light[1] + light[2] > 0.0f;
    for ( int c = 0; c < 3 && taken; ++c )
        chain_light->light[c][slot] = light[c];
    chain_light->open[slot] = chain_light->open[slot] && !taken;
    return taken;
}

// A path that hits emission without a chain has no chain light.
static inline void rf_close_chain( RfChainLight* chain_light, int slot, const float light[3] )
{
    if ( chain_light != NULL && light[0] + light[1] + light[2] > 0.0f )
        chain_light->open[slot] = false;
}

#endif
