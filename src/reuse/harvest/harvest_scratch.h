// The workspace in which a batch is traced, and what is asked of it.
#ifndef REFRAME_REUSE_HARVEST_HARVEST_SCRATCH_H
#define REFRAME_REUSE_HARVEST_HARVEST_SCRATCH_H

#include "path/chain_samples.h"
#include "path/features.h"
#include "reuse/project.h"
#include "reuse/chains/chains.h"
#include "reuse/harvest/clamp.h"
#include "reuse/harvest/harvest.h"
#include "reuse/tile/tile_reuse.h"

// Towards the hits' own camera, by hit: 4 each.
typedef struct RfOwnLanes
{
    RF_ALIGN float light[4 * RF_LANES];
} RfOwnLanes;

// Light that is kept apart (path/own_light.h).
typedef struct RfOwnHits
{
    RfOwnLight paths;
    RfArrivalLanes arrival;   // from one direction
    bool by_kind;             // as in RfLayerSet
    RfOwnLanes* layers;       // by base part and kind of hits: use rf_own_at
    RfOwnLanes* removed;      // by base part: what of it is removed; NULL where nothing is
    uint8_t moving[RF_LANES]; // by slot: the first hit is on what moves, so other cameras do not see it
    float part[RF_LANES];     // with RfHarvest.first_hits_only: share of the hit's light that is own-frame, estimated
} RfOwnHits;

struct RfHarvestScratch
{
    RfWavefront wavefront;
    RfOccluders occluders; // learned from the thread's shadow rays
    RfRayLanes camera_rays;
    RfVertexLanes first;                // hits of the camera rays
    RfSurfaceLanes* surfaces;           // that these hit; NULL unless the shape has them
    RfFeatures* features;               // of the camera rays; NULL unless the shape has them
    RfChains* chains;                   // NULL unless the shape has chains
    RfVertexLanes* hits;                // what becomes records, and specular hits behind: `first`, or chains->hits
    RF_ALIGN int32_t pixel[RF_LANES];   // by slot
    RF_ALIGN int32_t tile_of[RF_LANES]; // by slot, of tile_count
    int tile_count;
    RF_ALIGN int32_t miss_slot[RF_LANES]; // of the misses: rays that found nothing, then chains without a hit
    int ray_miss_count;                   // of the former
    int32_t glint_slot[RF_LANES];
    RF_ALIGN float scattered[3][RF_LANES]; // direction drawn at each hit
    int32_t spent[RF_LANES];               // without chains: −1 for paths that begin by passing a pane
    RF_ALIGN float specular_pdf[RF_LANES]; // of the direction drawn at specular hits, from 0
    RF_ALIGN float wo[3][RF_LANES];
    RfArrivalLanes arrival;
    RF_ALIGN int32_t landed_pixel[RF_LANES]; // pixel of each hit on the film of a camera
    RF_ALIGN float lifted[3][RF_LANES];      // the hits, off their surface
    RfEye* eyes;                             // of the group, at the batch's point of the lens and moment of the shutter
    const RfTracer** tracers;                // of the group likewise; NULL where nothing moves while the shutter is open
    char* at_moment;                         // where they are
    uint32_t* first_seen;                    // the pane or mirror on the way of a camera to each hit; NULL unless asked for
    float* place[2];                         // of each camera ray in its pixel, by slot; NULL with the plain pixel filter
    RfLightLanes* direct;                    // light samples at the hits, K of them
    float* density;                          // J_l V_l: camera l, hit i at l·RF_LANES + i
    float* mixture;                          // P: direction d, glossy hit i at d·RF_LANES + i
    RfTileReuse* tiles;                      // NULL without tile reuse
    RfConnectionLanes* connections;          // NULL without light paths
    RfChainSamples* chain_samples;           // NULL without
    RfChainLight* chain_light;               // of the paths, where tiles do not share it; NULL without chain samples
    RfOwnHits* own;                          // NULL unless something moves
    RfArrivals* dimmed;                      // by part from 1 on, and of what chains bring by base part and event; may be NULL
    RfClampHits* clamp;                      // NULL without a clamp
};

RfHarvestScratch* rf_place_harvest_scratch( const RfBatchShape* shape, RfLayout* layout );

// What the scene and the settings call for.
static inline bool rf_reuses_tiles( const RfHarvestScratch* scratch )
{
    return rf_calls_for( scratch->tiles != NULL, RF_EFFECT_TILE_CONNECTIONS );
}
static inline bool rf_follows_chains( const RfHarvestScratch* scratch )
{
    return rf_calls_for( scratch->hits != &scratch->first, RF_EFFECT_CHAINS );
}
// Whether light of one frame has parts by frame.
static inline bool rf_looks_at_frames( const RfHarvest* harvest )
{
    return harvest->shape->light_frames > 1 && rf_tracer_lights( harvest->path.tracer )->frame_count > 0;
}

// Whether no light is the same in two frames of the group: then other cameras need not be asked, and each frame is rendered as in a
// group of its own.
static inline bool rf_shares_nothing( const RfHarvest* harvest )
{
    return rf_calls_for( harvest->shape->own_light, RF_EFFECT_MOVING ) && rf_tracer_lights( harvest->path.tracer )->all_own &&
           !rf_looks_at_frames( harvest );
}

// Whether something moves or changes in the group that hits are harvested for, so that some light holds in one of its frames alone.
static inline bool rf_splits_light( const RfHarvest* harvest )
{
    const RfLights* lights = rf_tracer_lights( harvest->path.tracer );
    return rf_calls_for( harvest->shape->own_light, RF_EFFECT_MOVING ) && !rf_shares_nothing( harvest ) &&
           ( ( ( rf_tracer_has_swept( harvest->path.tracer ) || lights->any_own ) && !rf_looks_at_frames( harvest ) ) ||
             ( lights->dimmed_count + lights->frame_count > 0 && harvest->shape->chains ) ); // light of chains has no parts
}
static inline bool rf_is_adaptive( const RfHarvest* harvest )
{
    return rf_calls_for( harvest->group->need != NULL, RF_EFFECT_ADAPTIVE );
}

// The random key of a pass of a frame.
static inline uint64_t rf_harvest_key( const RfHarvest* harvest, int eye, int pass )
{
    return rf_pass_key( harvest->group->settings->seed, (uint32_t)( harvest->group->first_frame + eye ),
                        (uint32_t)harvest->group->number, (uint32_t)pass );
}

// The tracer of one of the group's frames.
static inline const RfTracer* rf_harvest_tracer( const RfHarvest* harvest, int eye )
{
    return harvest->tracers != NULL ? harvest->tracers[eye] : harvest->path.tracer;
}

// Whether the light that is kept apart (RfOwnHits) is clamped; caustics are removed whole.
static inline bool rf_clamps_own( const RfHarvestScratch* scratch )
{
    return scratch->clamp != NULL && scratch->own != NULL && !scratch->own->paths.caustics;
}

// Where the light of a hit that is kept apart is, and what is removed of it: 4 floats. Caustics are removed.
static inline float* rf_own_removed_at( const RfHarvestScratch* scratch, int base, int hit )
{
    return scratch->own->removed[base].light + 4 * (size_t)hit;
}
static inline float* rf_own_at( const RfHarvestScratch* scratch, int base, RfLayerKind kind, int hit )
{
    const RfOwnHits* own = scratch->own;
    if ( own->paths.caustics )
        return rf_own_removed_at( scratch, base, hit );
    return own->layers[own->by_kind ? base * RF_HIT_KINDS + (int)kind : base].light + 4 * (size_t)hit;
}

#endif
