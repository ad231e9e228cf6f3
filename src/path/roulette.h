// Russian roulette: paths of low throughput end at random, and survivors are divided by their survival probability, so the
// estimate stays unbiased (Arvo, Kirk, Particle Transport and Image Synthesis, SIGGRAPH 1990). Its thresholds are here alone.
#ifndef REFRAME_PATH_ROULETTE_H
#define REFRAME_PATH_ROULETTE_H

#include "math/vec3.h"

// The first vertex of a path with roulette.
#define RF_ROULETTE_VERTEX 3

// Chains of camera rays have it beyond this vertex. Up to there they may have passed panes straight, and what a camera sees
// straight is weighted by the panes' q alone (reuse/harvest/visibility.c).
#define RF_CHAIN_ROULETTE_BEYOND 4

// Survival probability at a vertex by the largest channel of the throughput. It falls below 1 late: by the third vertex paths
// have cost most of their rays, and ending them sooner adds more noise than it saves time.
// Where nothing absorbs, throughput never falls. So beyond the 64th vertex at most 1 - 2 / vertex survive: (64 / v)^2 of the
// paths reach vertex v, twice 64 vertices in the mean. A power of v, since survivors that weigh (v / 64)^2 keep the variance
// finite at any albedo below 1; a constant probability q does not from the square root of q on.
static inline float rf_survival( float carried, int vertex )
{
    const float certain = 0.25f;
    const int endless = 64;
    return rf_minf( carried / certain, vertex > endless ? 1.0f - 2.0f / (float)vertex : 1.0f );
}

// A factor of the throughput, for roulette, at vertices that other cameras may see: it has a floor, since the path may be nearly
// invisible to its own camera alone.
static inline float rf_shared_factor( float factor )
{
    const float least = 0.1f;
    return rf_maxf( factor, least );
}

// Survival probability of a path in the reuse by its tile, by its luminance and the mean luminance of the tile's paths
// (Bauszat, Petitjean, Eisemann, Gradient-Domain Path Reusing, 2017).
static inline float rf_reuse_survival( float luminance, float tile_mean )
{
    const float least = 0.1f;
    float certain = 0.1f * tile_mean;
    return luminance < certain && certain > 0.0f ? rf_maxf( luminance / certain, least ) : 1.0f;
}

#endif
