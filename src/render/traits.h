// What a scene and its camera's path call for, found once per render: memory is laid out by it.
#ifndef REFRAME_RENDER_TRAITS_H
#define REFRAME_RENDER_TRAITS_H

#include "reframe/render.h"

// The flags of a scene's traits, each with the effect of which it is the reason: X( flag, EFFECT ).
#define RF_TRAIT_LIST( X )                                                                                                       \
    X( blended, ALPHA_BLEND )  /* some surface lets part of the light straight through (alpha blending) */                       \
    X( panes, PANES )          /* some may be a thin pane (bsdf/bsdf.h) */                                                       \
    X( sky, ENVIRONMENT )      /* an environment that is not black */                                                            \
    X( chains, CHAINS )        /* camera rays may go on: mirrors, glass, smooth metals */                                        \
    X( mirrors, FLAT_MIRRORS ) /* flat mirrors */                                                                                \
    X( smooth, SMOOTH_GLOSS )  /* GGX coats or metals that may be nearly as smooth as mirrors */                                 \
    X( lens, DEPTH_OF_FIELD )  /* some camera of the path has a lens */                                                          \
    X( shutter, MOTION_BLUR )  /* some camera of the path, or what it sees, moves while its shutter is open */

typedef struct RfSceneTraits
{
    unsigned kinds; // bit k: a triangle scatters by RfBsdfKind k
#define RF_TRAIT_FLAG( flag, effect ) bool flag;
    RF_TRAIT_LIST( RF_TRAIT_FLAG )
#undef RF_TRAIT_FLAG
    // what is a matter of the scene alone, whatever is forced
    bool moves;               // something in it moves or changes
    int dimmable;             // lamps that may be dimmed, at most RF_DIMMED_MOST
    int light_groups;         // that light is split by; 0: it is not
    int lamps_alone;          // lamps and skies that may do more; 0 where anything else does
    bool sharp;               // some surface may mirror a lamp (rf_may_be_sharp)
    bool unlit;               // some surface is: mirrors and glass show it by chains alone
    bool grouped_chains;      // other frames can use what chains find
    int blur_steps;           // the most of the cameras' (RfEye.blur_steps); 0: what moves is not blurred
    bool scattered;           // the pixels of a batch lie apart: its one point of the lens is not to be seen
    bool without_caustics;    // they are left out of a scene that has surfaces to throw them
    uint32_t chain_triangles; // that light paths can follow (rf_is_chain_surface)
    uint32_t plate_triangles; // that those of lamps without size can (rf_is_plate); 0 where there are no such lamps
    uint32_t most_lights;     // triangles that emit, punctual lights, the sky
    bool moving_lights;       // some triangles that emit move
} RfSceneTraits;

// Whether batches have points of the lens and moments of the shutter.
static inline bool rf_is_blurred( const RfSceneTraits* traits ) { return traits->lens || traits->shutter; }

// Whether camera rays go on through mirrors and glass: where the pixels of a tile, or other frames, can use what they find, and to
// show what is unlit.
bool rf_wants_chains( const RfSceneTraits* traits, const RfRenderSettings* settings, int tile_pixels );

// Whether the light that mirrors and glass send on comes by light paths. Not through thin panes and partly transparent
// surfaces, which rays pass by chance.
bool rf_wants_light_paths( const RfSceneTraits* traits, const RfRenderSettings* settings );
bool rf_may_move( const RfScene* scene );

// Where something moves, groups of several frames share only what holds in all of them, which some settings cannot tell: fails for
// those with RF_ERROR_USAGE.
RfResult rf_check_moving( const RfSceneTraits* traits, const RfRenderSettings* settings, RfError* error );

// Fails likewise for settings that cannot split light by groups.
RfResult rf_check_light_groups( const RfScene* scene, const RfRenderSettings* settings, RfError* error );

// Fails likewise for settings that cannot leave caustics out, where they are.
RfResult rf_check_caustics( const RfSceneTraits* traits, const RfRenderSettings* settings, RfError* error );

// Scans the triangles and the environment of a scene, and the cameras of a path. Emitters are divided where the settings make
// light paths depend on it.
RfSceneTraits rf_scene_traits( const RfScene* scene, const RfEye* eyes, int eye_count, const RfRenderSettings* settings );

// What runs where a scene calls for these: without what is left out of it, and with what is forced.
RfSceneTraits rf_running_traits( const RfScene* scene, RfSceneTraits called );

// Refuses, by name, what a render calls for and the build has been made without.
RfResult rf_check_built( const RfShot* shot, const RfRenderSettings* settings, RfError* error );

#endif
