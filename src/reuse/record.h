// Hit records: what the harvest passes to accumulation. A batch holds the hits of one patch of one frame in one
// pass, as structures of arrays. Diffuse hits come first and store no directions.
#ifndef REFRAME_REUSE_RECORD_H
#define REFRAME_REUSE_RECORD_H

#include "base/layout.h"
#include "film/covering.h"
#include "path/lanes.h"
#include "reuse/layer.h"
#include "scene/lens.h"

// A direction that lights glossy hits.
typedef struct RfDirectionLanes
{
    float* wi[3];
} RfDirectionLanes;

// What comes by it in a layer, weighted over the cameras. Its contribution to
// camera t is C_t = r_t f_t(x, wi) Q, with r_t = J_t V_t / Σ J_l V_l and
// Q = |cos| (A / (K p_L + P) + B / P), where P = Σ r_l p_l is the mixture density of
// the cameras (E1, E3), A radiance that light sampling could have found too, B the rest.
typedef struct RfWeightedLanes
{
    float* q[3];
    bool dark; // q is 0, and not looked at
} RfWeightedLanes;

// The light of a layer, at scale 1 (light/light.h).
typedef struct RfLayerLight
{
    bool dark;       // it brings nothing, and the next are not looked at
    float* radiance; // 4 per hit: r g b, and 1 in the first layer, else 0. Diffuse: towards any camera; glossy: emission only.
                     // Behind them misses and glints, of base parts. NULL where the layer has none
    int first_direction, end_direction; // that the layer has
    RfWeightedLanes* by;                // by direction, from first_direction on: use rf_weighted
} RfLayerLight;

typedef struct RfHitBatch
{
    int eye;                           // index in the group of the frame whose pixels these are
    RfLensSample lens;                 // of all its camera rays; only where some camera of the path has a lens or shutter
    int count;                         // hits
    int miss_count;                    // own-frame samples: rays that missed, hits of specular models, and
                                       // chains that end without a hit
    int sky_count;                     // the first of them: camera rays that missed
    int glint_count;                   // light that chains find on the way to a hit, and light at hits that holds in their own
                                       // frame alone: for their own pixel
    int first[RF_BSDF_KIND_COUNT + 1]; // hits [first[k], first[k+1]) scatter by model k
    float* p[3];
    float* ng[3];
    float* density_sum;     // Σ_l J_l V_l over the cameras of the group
    uint32_t* seen;         // visibility: word w of hit i is seen[w·RF_LANES + i], bit l%32 of word l/32 for camera l
    float* densities;       // J_l V_l of camera l and hit i at l·RF_LANES + i; NULL unless V may be between 0 and 1
    float* panes[3];        // κ of the panes on the straight way to camera l, in the same places; NULL without panes
    int32_t* pixel;         // y·width + x in its own frame
    float* offset[2];       // where in that pixel, to the right and down, 0 to 1; NULL with the plain pixel filter
    uint8_t* view;          // how the hit was found, RF_VIEW_...; NULL unless the shape has chains
    uint32_t* surface;      // what the camera rays of hits, and then of misses, hit first (film/covering.h); NULL: not asked for
    uint32_t* surface_seen; // what camera l sees first on its way to hit i, at l·RF_LANES + i, where that is not the batch's own;
                            // NULL: as above from all
    bool has_views;         // some hit was not found directly, or may be seen through panes; else view does not matter
    int32_t* rows;          // 2 per camera: first and last row of its film that hits land in; first > last: none
    // glossy hits only, at lane i − first[RF_BSDF_FIRST_GLOSSY]
    float* n[3];
    float* wo[3];                 // back along the camera ray
    float* param[RF_PARAM_COUNT]; // NULL where the glossy models of the scene lack it
    RfDirectionLanes* directions; // numbered as by rf_first_pairing
    uint8_t* event;               // by hit: RF_EVENT_, the first of the chain to it; NULL unless layers are by kind
    RfLayerSet layers;
    int part_count;      // of the light, up to layers.parts
    RfLayerLight* light; // by layer (layer.h)
} RfHitBatch;

// Determines the layout of a batch.
typedef struct RfBatchShape
{
    int eyes;               // in a group
    int light_samples;      // K, at first hits
    int light_frames;       // in each of so many frames, where light may have parts by frame; else 1
    int tile_pixels;        // N, 1 without tiles
    RfBsdfParams params;    // of the glossy models in the scene (rf_glossy_params); 0: it has none
    bool frosted;           // frames share hits on rough glass
    bool blended;           // visibility may be between 0 and 1
    bool panes;             // connections and, with chains, the cameras' rays may pass thin panes
    bool own_frame_light;   // misses may be lit: the scene has a sky or specular materials
    bool blurred;           // batches have their points of the lens and moments of the shutter
    bool moments;           // what moves in the scene is then as at that moment
    uint32_t moving_lights; // lights that go with it; 0: none of them moves
    bool filtered;          // samples need their place in the pixel
    bool chains;            // camera rays are followed through mirrors and glass
    int chain_samples;      // per hit behind a chain (path/chain_samples.h); one direction more unless 0
    bool own_light;         // some light of paths may be kept apart (path/own_light.h)
    bool caustics;          // all of that is caustics, which are removed
    bool surfaces;          // which surfaces camera rays hit is kept: motion follows what moves, or for covering
    bool features;          // camera rays have features for denoisers (path/features.h)
    bool connections;       // hits have connections to light paths: one direction more
    bool clamped;           // the light that the clamp removes is kept
    int groups;             // light groups; 0: none
    RfLayerSet layers;
    // What is told apart of the surfaces that hits are on (film/covering.h).
    RfSurfaceKinds covering;
} RfBatchShape;

// How a hit was found.
enum
{
    RF_VIEW_DIRECT,
    RF_VIEW_FIRST_MIRROR,
    RF_VIEW_FROSTED = 253, // directly: rough glass, which is a vertex of chains to cameras that see it through panes
    RF_VIEW_BASE,          // directly: the base below a smooth coat
    RF_VIEW_CHAIN,         // by a chain that no other camera can follow
};

// The first event of a chain that is not to pass a pane straight.
enum
{
    RF_EVENT_NONE,
    RF_EVENT_REFLECTION,
    RF_EVENT_TRANSMISSION,
    RF_EVENTS,
};

#define RF_MOST_LISTED ( 2 * RF_LANES ) // hits, misses and glints of a batch

static inline int rf_listed( const RfHitBatch* batch ) { return batch->count + batch->miss_count + batch->glint_count; }

static inline RfLayerLight* rf_layer_light( const RfHitBatch* batch, int part, RfLayerKind kind )
{
    return batch->light + rf_layer( &batch->layers, part, kind );
}

static inline RfLayerLight* rf_removed_light( const RfHitBatch* batch, int part )
{
    return batch->light + rf_removed_layer( &batch->layers, part );
}

// What comes by a direction, which the layer must have.
static inline RfWeightedLanes* rf_weighted( const RfLayerLight* light, int direction )
{
    return light->by + ( direction - light->first_direction );
}

static inline bool rf_has_direction( const RfLayerLight* light, int direction )
{
    return direction >= light->first_direction && direction < light->end_direction;
}

// Misses follow the hits in the arrays that both have.
static inline int32_t* rf_miss_pixel( const RfHitBatch* batch ) { return batch->pixel + batch->count; }
// Glints follow the misses; in radiance the fourth of a miss is 1, that of a glint 0.
static inline int32_t* rf_glint_pixel( const RfHitBatch* batch ) { return rf_miss_pixel( batch ) + batch->miss_count; }

// True if V may be between 0 and 1.
static inline bool rf_is_partial( const RfBatchShape* shape )
{
    return rf_calls_for( shape->blended, RF_EFFECT_ALPHA_BLEND ) ||
           rf_calls_for( shape->panes && shape->chains, RF_EFFECT_PANES );
}

// True if batches have points of the lens and moments of the shutter.
static inline bool rf_is_blurred_shape( const RfBatchShape* shape )
{
    return rf_calls_for( shape->blurred, RF_EFFECT_DEPTH_OF_FIELD ) || rf_calls_for( shape->blurred, RF_EFFECT_MOTION_BLUR );
}

// Whether it matters how the batch's hits were found.
static inline bool rf_has_views( const RfHitBatch* batch ) { return rf_calls_for( batch->has_views, RF_EFFECT_CHAINS ); }

static inline bool rf_has_covering( const RfBatchShape* shape ) { return shape->covering.objects || shape->covering.materials; }

// Directions are numbered: the light samples, what chain samples found, the scattered one and those of the neighbour paths of
// the tile, the connections.
static inline int rf_light_directions( const RfBatchShape* shape ) { return shape->light_samples * shape->light_frames; }
static inline int rf_first_pairing( const RfBatchShape* shape )
{
    return rf_light_directions( shape ) + ( shape->chain_samples > 0 );
}
static inline int rf_direction_count( const RfBatchShape* shape )
{
    return rf_first_pairing( shape ) + shape->tile_pixels + shape->connections;
}
static inline int rf_seen_words( int eyes ) { return ( eyes + 31 ) / 32; }

// The parameters of the glossy models among `kinds`, a bit per RfBsdfKind.
RfBsdfParams rf_glossy_params( unsigned kinds );

// The directions of a layer, [first, end), by their numbers.
void rf_find_layer_directions( const RfBatchShape* shape, const RfLayerSet* set, int layer, int* first, int* end );

// A batch serves shapes of fewer cameras, too, whose parts and directions may be fewer.
RfHitBatch* rf_place_batch( const RfBatchShape* shape, RfLayout* layout );

#endif
