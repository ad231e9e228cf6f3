// Chains: the runs of mirrors and glass that camera rays follow to the first non-specular
// vertex (src/reuse/estimators.md, section 10).
#ifndef REFRAME_REUSE_CHAINS_CHAINS_H
#define REFRAME_REUSE_CHAINS_CHAINS_H

#include "path/wavefront.h"
#include "reuse/record.h"

// Light that chains bring for their own pixel, of a base part and by their first event, by slot.
typedef struct RfChainFinds
{
    RF_ALIGN float light[3][RF_LANES];
    float found[3][RF_LANES]; // with RfChains.clamped: what they find beyond their first vertices; `light` is that of these alone
} RfChainFinds;

typedef struct RfChains
{
    RfVertexLanes hits; // what becomes records: non-specular first hits and ends of chains, sorted by model
    RfVertexLanes ends; // of chains, in the order they were found
    RfVertexLanes at;   // the vertices where chains are now
    // by slot
    RF_ALIGN float throughput[3][RF_LANES]; // of the chain; 1 without one
    int32_t length[RF_LANES];               // vertices before the hit; 0: the camera ray found it
    uint8_t view[RF_LANES];
    uint8_t pane[RF_LANES];      // 1: is at a thin pane
    uint8_t straight[RF_LANES];  // panes among its vertices that it passed, which do not count in max_depth
    uint8_t split[RF_LANES];     // 1: lights reflected here are counted already
    uint8_t counted[RF_LANES];   // 1: reflected where it was split
    uint8_t reflected[RF_LANES]; // 1: the last event was a reflection
    uint8_t event[RF_LANES];     // RF_EVENT_: the first
    float lobe_weight[RF_LANES]; // 1 over the probability of drawing the lobe of a coat
    bool clamped;
    uint32_t* triangle;  // that the chain ends on, RF_MISS without a chain; NULL: not asked for
    int events;          // RF_EVENTS where their light is told apart by event, else 1
    RfChainFinds* finds; // by base part (light/light.h) and event: use rf_chain_finds
    // by end
    uint8_t kind[RF_LANES]; // RfBsdfKind
} RfChains;

static inline RfChainFinds* rf_chain_finds( const RfChains* chains, int base, int event )
{
    return chains->finds + base * chains->events + event;
}

// True if chains start at some of these vertices.
bool rf_has_chains( const RfVertexLanes* first );

// True if specular vertex i is a thin pane, seen at this angle (src/reuse/estimators.md, section 11).
bool rf_is_at_pane( const RfTracer* tracer, const RfVertexLanes* v, int i );

// Follows the chains that start at some vertices of `first`, and fills everything.
// Uses the wavefront, whose keys must be set, with arrivals by base part and event. Without `lit`, leaves light sampling out.
void rf_follow_chains( const RfPathSettings* path, const RfVertexLanes* first, const RfRayLanes* camera_rays, bool lit,
                       RfWavefront* wavefront, RfChains* chains );

// Splits tiles: hits with different keys do not share. `key` and `tile_of` are by slot.
void rf_split_tiles( const RfVertexLanes* hits, const int32_t* key, int32_t* tile_of, int* tile_count );

#endif
