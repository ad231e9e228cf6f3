// Light that comes by specular chains, in tiles. A path has gone from its hit by mirrors and smooth glass to emission. The
// other hits of its tile follow the same chain, with the same reflections and transmissions, in one of two ways
// (src/reuse/estimators.md, section 10): they aim at its first vertex, or, if that is near, start in the same direction.
#ifndef REFRAME_REUSE_TILE_TILE_CHAINS_H
#define REFRAME_REUSE_TILE_TILE_CHAINS_H

#include "reuse/tile/tile_reuse.h"

// Whether second vertex a begins a chain that leads its path to emission.
static inline bool rf_has_chain_light( const RfTileReuseSettings* settings, const RfTileReuse* reuse, int a )
{
    int slot = reuse->second.lanes.slot[a];
    const RfChainLight* found = &reuse->slots.chain_light;
    return settings->chain_light && found->light[0][slot] + found->light[1][slot] + found->light[2][slot] > 0.0f;
}

// Whether second vertex a begins a chain that the others start for in the same direction.
static inline bool rf_is_parallel_chain( const RfTileReuse* reuse, int a )
{
    return a >= rf_record_count( &reuse->second.lanes ) && reuse->second.parallel[a];
}

// Decides that for all chains: reuse->second.parallel.
void rf_sort_chains( RfTileReuse* reuse );

// Sets directions, and ρ but for BSDF density and visibility, where the vertex of pairing s ≥ 1 begins a chain. Hits that aim
// at it keep what connections to any vertex have.
void rf_aim_at_chains( float* const scattered[3], int s, RfTileReuse* reuse );

// Follows the chains from all hits that are paired with them. Pairings get the light, and their weights are multiplied by the
// probability of the events, 0 where the chain leads elsewhere. Returns the number of rays.
uint64_t rf_follow_chain_light( const RfTileReuseSettings* settings, RfWavefront* wavefront, RfTileReuse* reuse );

// Weights reuse->slots.chain_light: what arrives at the hits whose paths found it.
void rf_weight_chain_light( const RfPathSettings* path, RfTileReuse* reuse );

#endif
