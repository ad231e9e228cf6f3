// Light of chains in tiles: a path goes from its hit x by mirrors and smooth glass to emission. The other hits of its tile
// follow that chain with the same events, in one of two ways (src/reuse/estimators.md, section 10): they aim at its first
// vertex, or, where this is near, leave in parallel.
#ifndef REFRAME_REUSE_TILE_TILE_CHAINS_H
#define REFRAME_REUSE_TILE_TILE_CHAINS_H

#include "reuse/tile/tile_reuse.h"

// True if second vertex a begins a chain that leads its path to emission.
static inline bool rf_has_chain_light( const RfTileReuseSettings* settings, const RfTileReuse* reuse, int a )
{
    int slot = reuse->second.lanes.slot[a];
    const RfChainLight* found = &reuse->slots.chain_light;
    return settings->chain_light && found->light[0][slot] + found->light[1][slot] + found->light[2][slot] > 0.0f;
}

// True of a chain that is followed in parallel.
static inline bool rf_is_parallel_chain( const RfTileReuse* reuse, int a )
{
    return a >= rf_record_count( &reuse->second.lanes ) && reuse->second.parallel[a];
}

// Fills reuse->second.parallel.
void rf_sort_chains( RfTileReuse* reuse );

// Directions and weights of the pairs of pairing s from 1 on whose vertex begins a chain, without density; those that are aimed
// have what all pairs have.
void rf_aim_at_chains( float* const scattered[3], int s, RfTileReuse* reuse );

// Follows the chains from all hits that are connected to them: pairings get the light, and their weights the
// probability of the events, or 0 where they lead elsewhere. Returns the rays that it took.
uint64_t rf_follow_chain_light( const RfTileReuseSettings* settings, RfWavefront* wavefront, RfTileReuse* reuse );

// Leaves in reuse->slots.chain_light what of their light arrives at the hits whose paths found it.
void rf_weight_chain_light( RfTileReuse* reuse );

#endif
