// Path reuse inside tiles (Bekaert, Sbert, Halton, EGWR 2002; estimators.md
// E4, E5). The paths of a tile, one per pixel, with first hits x^i and second
// vertices y^j: what y^j sends on is made use of at every x^i that sees it.
//
// Pairs are kept by turn s: in turn s hit i looks at the vertex that its s-th
// mate found, counted round the tile; turn 0 is its own path. So every array of
// a turn has a lane per hit, or a lane per second vertex, and no pair is alone
// in a loop.
//
// The density per area with which path k would have found y is R^k(y) = p G V,
// with G = cos_y / r². It only comes in quotients, ρ_k = R^k(y) / G_own: free of
// units, and 1/p·ρ = 1 for a path that is alone.
#ifndef REFRAME_REUSE_TILE_REUSE_H
#define REFRAME_REUSE_TILE_REUSE_H

#include "path/wavefront.h"
#include "reframe/render.h"

// One turn.
typedef struct RfPairingLanes
{
    // lanes: hits
    RF_ALIGN float wi[3][RF_LANES]; // unit, to the mate's second vertex
    float weight[RF_LANES];         // ρ, later the balance weight ρ / Σ_k ρ_k; 0: not seen, or no vertex; negative:
                                    // of that size, but left out of Σ
    int32_t mate[RF_LANES];         // the second vertex looked at; where there is none 0, with weight 0
    // lanes: second vertices with a shiny surface
    float f[3][RF_LANES];
    float light[3][RF_LANES]; // sent to the hit; of turn 0 also what diffuse vertices send to all
} RfPairingLanes;

typedef struct RfTileReuse
{
    RF_ALIGN int32_t tile_of[RF_LANES]; // by slot
    int tile_count;
    // hits, tile after tile
    int32_t member[RF_LANES];
    // by hit
    int32_t begin[RF_LANES], size[RF_LANES], rank[RF_LANES]; // of its tile in member[], and its own place there
    int32_t found[RF_LANES];                                 // second vertex of its path; −1: none to share
    // second vertices
    RfVertexLanes second;
    RF_ALIGN float lifted[3][RF_LANES]; // of the hits: where segments to them end
    int32_t owner[RF_LANES];            // hit whose path found it; −1: not shared
    float throughput[3][RF_LANES];      // of the ray that found it
    float own_distance2_cos[RF_LANES];  // 1 / G_own
    float sum[RF_LANES];                // Σ ρ
    float late[RF_LANES];               // density that counts, where its own path does not; else 0
    float wi[3][RF_LANES];              // where its path goes on
    float pdf[RF_LANES];
    float wo[3][RF_LANES]; // to the hits of a turn
    float mixture[RF_LANES];
    float a[3][RF_LANES], b[3][RF_LANES], light_pdf[RF_LANES];
    RfArrivals found_light; // by slot: what the scattered rays of the hits found
    RfArrivals beyond;      // by slot: what arrives at the second vertices along wi
    RfLightLanes* direct;   // light samples at the second vertices, K of them
    RfPairingLanes* turns;  // as many as a tile has pixels
} RfTileReuse;

typedef struct RfTileReuseSettings
{
    const RfPathSettings* walk;
    int tile_pixels; // of a whole tile
    bool roulette;   // on connections of little weight
} RfTileReuseSettings;

size_t rf_tile_reuse_bytes( int light_samples, int tile_pixels );
RfTileReuse* rf_lay_out_tile_reuse( int light_samples, int tile_pixels, void* memory );

// What rf_trace_tails does for the rays that left the hits, with what their
// second vertices send shared in the tiles share->tile_of: walk->arrivals as from there,
// rest being the balanced part of turn 0, and the turns from 1 on in
// share->turns. Returns the segments tested.
uint64_t rf_trace_tile_tails( const RfTileReuseSettings* settings, const RfVertexLanes* hits, float* const scattered[3],
                              RfWavefront* walk, RfTileReuse* share );

// The steps of that which have files of their own.
uint64_t rf_weight_pairings( const RfTileReuseSettings* settings, const RfVertexLanes* hits, float* const scattered[3],
                             RfWavefront* walk, RfTileReuse* share );
void rf_light_pairings( const RfTileReuseSettings* settings, RfWavefront* walk, RfTileReuse* share );

// The hit that looks at shared vertex a in a turn.
static inline int rf_receiver( const RfTileReuse* share, int a, int turn )
{
    int i = share->owner[a], at = share->rank[i] - turn;
    return share->member[share->begin[i] + at + ( at < 0 ? share->size[i] : 0 )];
}

// Light that a turn from 1 on brings to hits [first, end) times its cosine
// there: (E5) without the weight over the eyes.
void rf_gather_tile_light( const RfTileReuse* share, int turn, const RfVertexLanes* hits, int first, int end,
                           float borrowed[3][RF_LANES] );

// Sum over these turns for diffuse hits [0, count), divided by the density of
// its direction; f cos / density is the albedo.
void rf_gather_diffuse_tile_light( const RfTileReuse* share, int turns, int count, float sum[3][RF_LANES] );

#endif
