// Shared by the files of chains: their steps.
#ifndef REFRAME_REUSE_CHAIN_STEPS_H
#define REFRAME_REUSE_CHAIN_STEPS_H

#include "reuse/chains.h"

// So many vertices of a chain have their reflections split, and panes for vertices.
#define RF_MOST_SPLIT 4

static inline RfVec3 rf_throughput_of( const RfChains* chains, int slot )
{
    return rf_vec3( chains->throughput[0][slot], chains->throughput[1][slot], chains->throughput[2][slot] );
}

static inline void rf_set_throughput( RfChains* chains, int slot, RfVec3 t )
{
    chains->throughput[0][slot] = t.x;
    chains->throughput[1][slot] = t.y;
    chains->throughput[2][slot] = t.z;
}

// Fills view, throughput and split, and makes the first vertices of chains those where they are. With `lit`, adds
// what their reflections see of lights to wavefront->arrivals.
void rf_start_chains( const RfPathSettings* path, const RfVertexLanes* first, const RfRayLanes* camera_rays, bool lit,
                      RfWavefront* wavefront, RfChains* chains );

// What reflections at the chains' `vertex`-th vertices see of lights, added to wavefront->arrivals; notes them in
// chains->split. With `coats`, smooth coats among these first vertices as well; NULL: later ones.
void rf_split_reflections( const RfPathSettings* path, int vertex, const RfVertexLanes* coats, RfWavefront* wavefront,
                           RfChains* chains );

// Makes the specular lanes of `found` the vertices where chains are.
void rf_go_to( const RfVertexLanes* found, RfVertexLanes* at );

// Adds light samples at vertices of chains, for their lobes that are no deltas, to wavefront->arrivals.
void rf_light_chains( const RfPathSettings* path, int vertex, const RfVertexLanes* v, RfWavefront* wavefront,
                      const RfChains* chains );

// Scatters vertices of chains: wavefront->rays gets the rays, with the throughput of their chains, first those to which panes
// may be vertices. Returns how many these are. How many vertices they were `followed` over decides about roulette.
int rf_scatter_chains( const RfPathSettings* path, int vertex, int followed, const RfVertexLanes* v, RfWavefront* wavefront,
                       RfChains* chains );

#endif
