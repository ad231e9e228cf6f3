// Path reuse inside tiles (Bekaert, Sbert, Halton, EGWR 2002; src/reuse/estimators.md,
// E4 and E5). The paths of a tile, one per pixel, have first hits x^i and second
// vertices y^j. The light that y^j scatters is used at every x^i that sees it.
//
// Hits and vertices are combined in pairings: pairing s connects every hit to the
// second vertex of its s-th neighbour path, counted cyclically through the tile;
// pairing 0 is the hit's own path. So the arrays of a pairing have a lane per hit
// or a lane per second vertex, and all loops run over many lanes.
//
// The density per area with which path k would have sampled y is R^k(y) = p G V,
// with G = cos_y / r². Only quotients matter: ρ_k = R^k(y) / G_own has no unit,
// and the weight of a path on its own is 1.
#ifndef REFRAME_REUSE_TILE_TILE_REUSE_H
#define REFRAME_REUSE_TILE_TILE_REUSE_H

#include "base/layout.h"
#include "path/wavefront.h"
#include "reuse/layer.h"

// By path slot.
typedef struct RfTileSlots
{
    float pane_probability[RF_LANES]; // q of the panes on the way to the second vertex; not set without panes
    RfChainLight chain_light;         // of the paths; all 0 unless it is shared
    RfArrivals at_hits;               // what has arrived at the hits, while paths are traced beyond second vertices
} RfTileSlots;

// By hit: the non-specular lanes of the first vertices.
typedef struct RfTileHits
{
    const RfVertexLanes* lanes;
    RF_ALIGN float lifted[3][RF_LANES];                      // off their surface: the ends of connections
    int32_t begin[RF_LANES], size[RF_LANES], rank[RF_LANES]; // of its tile in member[], and its own index there
    int32_t second[RF_LANES];                                // second vertex of its path; −1: none that is reused
    int32_t member[RF_LANES];                                // all hits, sorted by tile
} RfTileHits;

// By second vertex.
typedef struct RfSecondVertices
{
    RfVertexLanes lanes;
    int32_t hit[RF_LANES];                  // the hit before it on its path; −1: a specular one
    int32_t owner[RF_LANES];                // the same where the vertex is reused, else −1. Specular vertices are reused for
                                            // light at the end of a chain alone (reuse/tile/tile_chains.h)
    int shared;                             // the first `shared` scatter the same light to all receivers
    RfLightLanes* direct;                   // light samples, K of them, and one of the connector
    RF_ALIGN float throughput[3][RF_LANES]; // of the ray that hit it
    float own_distance2_cos[RF_LANES];      // 1 / G_own
    float sum[RF_LANES];                    // Σ ρ
    float connection_area[RF_LANES];        // of the connector's sample (rf_own_weight)
    float wi[3][RF_LANES];                  // scattered direction of its path, and its density
    float pdf[RF_LANES];
    float wo[3][RF_LANES];  // to the receivers of one pairing
    RfArrivalLanes arrival; // from one direction, and its mixture density P
    float mixture[RF_LANES];
    bool dark[RF_LANES];     // no light arrives there: it is not connected
    bool parallel[RF_LANES]; // the chain that begins there is followed in the same direction (reuse/tile/tile_chains.h)
} RfSecondVertices;

// Light that second vertices scatter to the receivers of a pairing, of a part.
typedef struct RfPairingLight
{
    RF_ALIGN float light[3][RF_LANES];
} RfPairingLight;

// One pairing: hits connected to second vertices of neighbour paths.
typedef struct RfPairingLanes
{
    // by hit
    RF_ALIGN float wi[3][RF_LANES];   // unit, to the second vertex
    float weight[RF_LANES];           // ρ, later the balance weight ρ / Σ_k ρ_k; 0: occluded, or no vertex
    float guided[RF_LANES];           // with a guide, of diffuse hits: the cosine's density over that of the direction
    int32_t vertex[RF_LANES];         // second vertex of the neighbour path; 0, with weight 0, if it has none
    float ( *pane_weight )[RF_LANES]; // κ of the thin dielectrics between (section 11), by channel; NULL: the scene has none
    // by second vertex
    RF_ALIGN float f[3][RF_LANES]; // of glossy ones
    RfPairingLight* of_part;       // scattered to the receiver, by part; that of `shared` ones is in pairing 0 alone
    // with RfTileReuse.split; else NULL or not set
    bool any_touched;    // some connection is
    uint8_t* touched;    // by hit: what moves touches the connection
    RfPairingLight* own; // by base part: like of_part, by paths that it touches beyond the second vertex
} RfPairingLanes;

// Light of a base part that holds in its own frame alone.
typedef struct RfTileOwnGroup
{
    bool any;              // some arrives at second vertices
    uint8_t lit[RF_LANES]; // by second vertex, 1: some does there
} RfTileOwnGroup;

// Light that holds in its own frame alone (path/own_light.h).
typedef struct RfTileOwn
{
    RfTileOwnGroup* groups;   // by base part
    RfOwnLight beyond;        // of the paths from their second vertices on
    RfArrivalLanes arrival;   // as in RfSecondVertices
    uint8_t moving[RF_LANES]; // by slot: the second vertex itself moves
} RfTileOwn;

typedef struct RfTileReuse
{
    int thinned, kept; // paths before and after roulette; 0 without it
    RfTileSlots slots;
    RfTileHits hits;
    RfSecondVertices second;
    RfPairingLanes* pairings; // one per pixel of a tile
    RfTileOwn* own;
    bool split;            // light is split into what the frames share and `own`
    RfArrivals* at_second; // by part of the light: what arrives along the rays scattered at the second vertices
    int part_count;        // of the light of paths traced
    int base_parts;        // of them those of light groups
} RfTileReuse;

typedef struct RfTileReuseSettings
{
    const RfPathSettings* path;
    int tile_pixels;        // of a whole tile
    const int32_t* tile_of; // by slot: the tile of each path, from 0
    int tile_count;
    bool path_roulette;    // on paths that bring little light (reuse/tile/tile_paths.h)
    bool chain_light;      // is shared (reuse/tile/tile_chains.h)
    const int32_t* source; // of the paths (reuse/tile/tile_paths.h); NULL: each hit has its own
} RfTileReuseSettings;

// `light_lanes`: light samples of a vertex, with those of a connector (rf_light_lanes_count).
// `own`: with room for light that holds in its own frame alone; `layers`: whose parts have room.
// NULL for tiles of one pixel.
RfTileReuse* rf_place_tile_reuse( int light_lanes, int tile_pixels, bool panes, bool own, const RfLayerSet* layers,
                                  RfLayout* layout );

// Like rf_trace_tails for the rays scattered at the hits, but second vertices are reused inside their tiles.
// wavefront->arrivals is as returned there, with the weighted light of pairing 0 in `rest`; pairings from 1 on are in
// reuse->pairings. With path->own its light is split in the same way. Returns the number of connections tested.
uint64_t rf_trace_tile_tails( const RfTileReuseSettings* settings, const RfVertexLanes* hits, float* const scattered[3],
                              RfWavefront* wavefront, RfTileReuse* reuse );

// Finds the balance weights of all pairings, tests visibility, and returns the number of connections tested. A step of
// rf_trace_tile_tails, like the next.
uint64_t rf_weight_pairings( const RfTileReuseSettings* settings, const RfVertexLanes* hits, float* const scattered[3],
                             RfWavefront* wavefront, RfTileReuse* reuse );

// The light that second vertices scatter to the receivers of all pairings, of all parts. Light that holds in its own frame alone is
// as in that frame in pairing 0, and in the others still to be scaled for it. A step of rf_trace_tile_tails.
void rf_light_pairings( const RfTileReuseSettings* settings, RfWavefront* wavefront, RfTileReuse* reuse );

// Luminance of the light that each second vertex scatters back along its own path, weighted as without tiles; and whether
// any light arrives at it.
void rf_light_own_paths( const RfPathSettings* path, RfWavefront* wavefront, RfTileReuse* reuse, float* luminance, bool* lit );

// The light of a part that a pairing from 1 on brings to hits [first, end), times the cosine there: (E5) before the weights over the
// cameras. `own`: that of their own frame alone, else what frames share.
void rf_gather_tile_light( const RfTileReuse* reuse, int part, int pairing, int first, int end, bool own,
                           float light[3][RF_LANES] );

// Its sum over pairings [first, end), from 1 on, at all diffuse hits, divided by the density of the directions: multiply by the
// albedo, which is f cos / density. Light that comes by chains has the weight `chain_weight` at the hits in `weighted` (NULL:
// none).
void rf_gather_diffuse_tile_light( const RfTileReuse* reuse, int part, int first, int end, bool own, const bool* weighted,
                                   float chain_weight, float sum[3][RF_LANES] );

// True if the scattered light of second vertex a is reused.
static inline bool rf_scatters_to_tile( const RfTileReuse* reuse, int a )
{
    return a < rf_record_count( &reuse->second.lanes ) && reuse->second.owner[a] >= 0;
}

// The hit that receives the light of second vertex a in a pairing.
static inline int rf_receiver( const RfTileReuse* reuse, int a, int pairing )
{
    const RfTileHits* hits = &reuse->hits;
    int i = reuse->second.owner[a], at = hits->rank[i] - pairing;
    return hits->member[hits->begin[i] + at + ( at < 0 ? hits->size[i] : 0 )];
}

// Whether a hit receives light by a chain in a pairing.
static inline bool rf_receives_chain_light( const RfTileReuse* reuse, int pairing, int hit )
{
    const RfPairingLanes* t = reuse->pairings + pairing;
    return t->weight[hit] > 0.0f && t->vertex[hit] >= rf_record_count( &reuse->second.lanes );
}

#endif
