// Hit records: what the harvest passes to accumulation. A batch holds the hits of one patch of one frame in one
// pass, as structures of arrays. Diffuse hits come first and store no directions.
#ifndef REFRAME_REUSE_HARVEST_RECORDS_H
#define REFRAME_REUSE_HARVEST_RECORDS_H

#include "base/layout.h"
#include "film/covering.h"
#include "path/lanes.h"
#include "scene/lens.h"

// A direction that lights glossy hits, weighted over the cameras. Its contribution to
// camera t is C_t = r_t f_t(x, wi) Q, with r_t = J_t V_t / Σ J_l V_l and
// Q = |cos| (A / (K p_L + P) + B / P), where P = Σ r_l p_l is the mixture density of
// the cameras (E1, E3), A radiance that light sampling could have found too, B the rest.
typedef struct RfDirectionLanes
{
    float* wi[3];
    float* q[3];
    bool dark; // q is 0, and not looked at
} RfDirectionLanes;

// Of hits, with RfBatchShape.passes: their emission, and direct light: of diffuse ones towards any camera, of glossy ones that
// which the scattered direction finds, as Q; light samples bring the rest of it.
typedef struct RfPassLight
{
    float *emission[3], *direct[3], *direct_q[3];
} RfPassLight;

// Light of a part at scale 1 (light/light.h): what a batch has of part 0. Misses and glints have that of base parts alone.
typedef struct RfDimmedLight
{
    float* radiance;                      // with r g b 0
    RfDirectionLanes* directions;         // share wi
    float* removed;                       // NULL without a clamp, as the next
    RfDirectionLanes* removed_directions; // share wi
    bool any_removed;
    RfPassLight* passes; // NULL without, and of base parts
} RfDimmedLight;

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
    float* radiance;        // 4 per hit: r g b 1. Diffuse: towards any camera; glossy: emission only
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
    // what is taken out of the light; NULL where nothing is
    float* removed;                       // like radiance, with r g b 0
    RfDirectionLanes* removed_directions; // like directions, which they share wi with; NULL without a clamp (clamp.h)
    bool any_removed;                     // else neither of the two is set
    // NULL without passes
    RfPassLight* passes; // of all base parts together
    uint8_t* event;      // by hit: RF_EVENT_, the first of the chain to it
    float* others;       // of misses and glints, by RF_OTHER_: 4 each, of which the fourth is 0, with room for hits before them
    int dimmed_count;
    RfDimmedLight* dimmed; // parts of the light from 1 on
} RfHitBatch;

// Determines the layout of a batch.
typedef struct RfBatchShape
{
    int eyes;               // in a group
    int light_samples;      // K, at first hits
    int light_frames;       // in each of so many frames, where light may have parts by frame; else 1
    int tile_pixels;        // N, 1 without tiles
    RfBsdfParams params;    // of the glossy models in the scene (rf_glossy_params); 0: it has none
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
    bool caustics;          // all of that is caustics, which are taken out
    bool surfaces;          // which surfaces camera rays hit is kept: motion follows what moves, or for covering
    bool features;          // camera rays have features for denoisers (path/features.h)
    bool connections;       // hits have connections to light paths: one direction more
    bool clamped;           // what the clamp takes out of the light is kept
    bool passes;            // light is sorted into passes (passes.h)
    int groups;             // light groups; 0: none
    int dimmed;             // parts that light of these groups, and of lamps that are dimmed or move, may have from 1 on
    // What is told apart of the surfaces that hits are on (film/covering.h).
    RfSurfaceKinds covering;
} RfBatchShape;

// How a hit was found.
enum
{
    RF_VIEW_DIRECT,
    RF_VIEW_FIRST_MIRROR,
    RF_VIEW_BASE = 254, // directly: the base below a smooth coat
    RF_VIEW_CHAIN,      // by a chain that no other camera can follow
};

// The first event of a chain that is not to pass a pane straight.
enum
{
    RF_EVENT_NONE,
    RF_EVENT_REFLECTION,
    RF_EVENT_TRANSMISSION,
};

// Passes of misses and glints besides emission.
enum
{
    RF_OTHER_DIRECT,
    RF_OTHER_INDIRECT,
    RF_OTHER_REFLECTION,
    RF_OTHER_TRANSMISSION,
    RF_OTHER_PASSES,
};

#define RF_MOST_LISTED ( 2 * RF_LANES ) // hits, misses and glints of a batch

// By the number of the miss or glint among all that is listed.
static inline float* rf_other_pass( const RfHitBatch* batch, int pass, int item )
{
    return batch->others + 4 * ( (size_t)pass * RF_MOST_LISTED + (size_t)item );
}

// What is left of a sum without its terms, or 0 where that is no more than rounding.
static inline float rf_without_rounding( float left, float sum ) { return fabsf( left ) > 1e-6f * sum ? left : 0.0f; }

// Misses follow the hits in the arrays that both have.
static inline int32_t* rf_miss_pixel( const RfHitBatch* batch ) { return batch->pixel + batch->count; }
// 4 each: r g b 1. Not set without own_frame_light: black.
static inline float* rf_miss_radiance( const RfHitBatch* batch ) { return batch->radiance + 4 * (size_t)batch->count; }
// Glints follow the misses, with r g b 0.
static inline int32_t* rf_glint_pixel( const RfHitBatch* batch ) { return rf_miss_pixel( batch ) + batch->miss_count; }
static inline float* rf_glint_radiance( const RfHitBatch* batch )
{
    return rf_miss_radiance( batch ) + 4 * (size_t)batch->miss_count;
}

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

// The batch with the light of a part in the place of that of part 0. `others`: with misses and glints, which base parts alone have.
RfHitBatch rf_batch_of_part( const RfHitBatch* batch, int part, bool others );

// The parameters of the glossy models among `kinds`, a bit per RfBsdfKind.
RfBsdfParams rf_glossy_params( unsigned kinds );

RfHitBatch* rf_place_batch( const RfBatchShape* shape, RfLayout* layout );

#endif
