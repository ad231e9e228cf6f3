// Chains: the runs of mirrors and glass that camera rays follow to the first non-specular
// vertex (src/reuse/estimators.md, section 10).
#ifndef REFRAME_REUSE_CHAINS_CHAINS_H
#define REFRAME_REUSE_CHAINS_CHAINS_H

#include "path/wavefront.h"
#include "reuse/harvest/records.h"

// Light of chains in a light group, by slot.
typedef struct RfChainGroup
{
    RF_ALIGN float light[3][RF_LANES];
    float found[3][RF_LANES];
} RfChainGroup;

// What chains find beyond the emission of their first vertices, by their first event: that of ways that have one, by slot.
typedef struct RfChainPasses
{
    RF_ALIGN float reflection[3][RF_LANES], transmission[3][RF_LANES];
    float met[3][RF_LANES]; // workspace
} RfChainPasses;

typedef struct RfChains
{
    RfVertexLanes hits; // what becomes records: non-specular first hits and ends of chains, sorted by model
    RfVertexLanes ends; // of chains, in the order they were found
    RfVertexLanes at;   // the vertices where chains are now
    // by slot
    RF_ALIGN float throughput[3][RF_LANES]; // of the chain; 1 without one
    RF_ALIGN float light[3][RF_LANES];      // that the chain itself brings, for its own pixel
    int32_t length[RF_LANES];               // vertices before the hit; 0: the camera ray found it
    uint8_t view[RF_LANES];
    uint8_t pane[RF_LANES];      // 1: is at a thin pane
    uint8_t straight[RF_LANES];  // panes among its vertices that it passed, which do not count in max_depth
    uint8_t split[RF_LANES];     // 1: lights reflected here are counted already
    uint8_t counted[RF_LANES];   // 1: reflected where it was split
    uint8_t reflected[RF_LANES]; // 1: the last event was a reflection
    uint8_t event[RF_LANES];     // RF_EVENT_: the first
    float lobe_weight[RF_LANES]; // 1 over the probability of drawing the lobe of a coat
    bool clamped;                // `light` is that of the first vertices alone,
    float found[3][RF_LANES];    // and what chains find beyond them is here; else this is not set
    uint32_t* triangle;          // that the chain ends on, RF_MISS without a chain; NULL: not asked for
    RfChainPasses* by_event;     // NULL without passes
    RfChainGroup* groups;        // with RfPathSettings.grouped: both by base part (light/light.h) from 1 on
    // by end
    uint8_t kind[RF_LANES]; // RfBsdfKind
} RfChains;

// Light that chains bring of a base part of light groups, and with `clamped` what they find beyond their first vertices.
static inline float ( *rf_chain_light( RfChains* chains, int part ) )[RF_LANES]
{
    return part == 0 ? chains->light : chains->groups[part - 1].light;
}
static inline float ( *rf_chain_found( RfChains* chains, int part ) )[RF_LANES]
{
    return part == 0 ? chains->found : chains->groups[part - 1].found;
}

// True if chains start at some of these vertices.
bool rf_has_chains( const RfVertexLanes* first );

// True if specular vertex i is a thin pane, seen at this angle (src/reuse/estimators.md, section 11).
bool rf_is_at_pane( const RfTracer* tracer, const RfVertexLanes* v, int i );

// Follows the chains that start at some vertices of `first`, and fills everything.
// Uses the wavefront, whose keys must be set, and with `grouped` room for light of base parts. Without `lit`, leaves light sampling out.
void rf_follow_chains( const RfPathSettings* path, const RfVertexLanes* first, const RfRayLanes* camera_rays, bool lit,
                       RfWavefront* wavefront, RfChains* chains );

// Splits tiles: hits with different keys do not share. `key` and `tile_of` are by slot.
void rf_split_tiles( const RfVertexLanes* hits, const int32_t* key, int32_t* tile_of, int* tile_count );

#endif
