// Effects: what a scene, its camera's path and the render settings call for. Code that a scene does not call for is not run.
// An effect can be forced, which leaves the picture as it is, or be left out.
//
//     uint64_t left_out;
//     if ( rf_parse_effects( "textures,panes", &left_out, &error ) == RF_OK &&
//          rf_choose_effects( scene, 0, left_out, &error ) == RF_OK )
//         ... // before rf_create_camera_path and rf_create_tracer
//
//     RfEffect effects[RF_EFFECT_COUNT];
//     int count = rf_list_render_effects( scene, path.eyes, path.count, &settings, effects );
#ifndef REFRAME_EFFECTS_H
#define REFRAME_EFFECTS_H

#include "reframe/error.h"
#include "reframe/types.h"

RF_API_BEGIN

// What a picture is without an effect.
typedef enum RfWithout
{
    RF_WITHOUT_OTHER_PICTURE, // another picture: that of a scene without the effect
    RF_WITHOUT_OTHER_NOISE,   // the same picture in the mean: it takes other time and has other noise
    RF_WITHOUT_IMPOSSIBLE,    // cannot be left out of a scene: settings decide, or everything is made of it
} RfWithout;

// The list of effects, from which all others are made: X( constant, name, what the picture is without it, whether it can
// be forced, what that means ).
#define RF_EFFECT_LIST( X )                                                                                                      \
    X( DIFFUSE, "diffuse", IMPOSSIBLE, false, "all materials are made of it" )                                                   \
    X( PHONG, "phong", OTHER_PICTURE, true, "materials keep their diffuse part" )                                                \
    X( GGX, "ggx", OTHER_PICTURE, true, "materials keep their diffuse part: metals are black, nothing has a coat" )              \
    X( AREA_LIGHTS, "area-lights", OTHER_PICTURE, false, "no material emits" )                                                   \
    X( TWO_SIDED_EMISSION, "two-sided-emission", OTHER_PICTURE, false, "materials emit from the front only" )                    \
    X( INTERPOLATED_NORMALS, "interpolated-normals", OTHER_PICTURE, false, "triangles are shaded flat" )                         \
    X( CAMERA_ANIMATION, "camera-animation", IMPOSSIBLE, false, "one frame renders as a still" )                                 \
    X( MOVING, "moving", IMPOSSIBLE, false, "the scene as it is in its first frame" )                                            \
    X( DEPTH_OF_FIELD, "depth-of-field", OTHER_PICTURE, true, "the camera is a pinhole" )                                        \
    X( MOTION_BLUR, "motion-blur", OTHER_PICTURE, true, "the shutter time is zero" )                                             \
    X( CLEARCOAT, "clearcoat", OTHER_PICTURE, true, "materials keep what is under their clear coat" )                            \
    X( SHEEN, "sheen", OTHER_PICTURE, true, "materials keep what is under their sheen" )                                         \
    X( DIFFUSE_TRANSMISSION, "diffuse-transmission", OTHER_PICTURE, true,                                                        \
       "materials keep what their base scatters on the side that light comes from" )                                             \
    X( ANISOTROPY, "anisotropy", OTHER_PICTURE, true, "highlights are not stretched" )                                           \
    X( IRIDESCENCE, "iridescence", OTHER_PICTURE, true, "surfaces are without their thin films" )                                \
    X( MIRRORS, "mirrors", OTHER_PICTURE, true, "perfect mirrors are black" )                                                    \
    X( FLAT_MIRRORS, "flat-mirrors", OTHER_NOISE, true, "what is seen in flat mirrors is not reused in other frames" )           \
    X( TRANSMISSION, "transmission", OTHER_PICTURE, true, "glass is opaque, of its own colour, and reflects" )                   \
    X( DISPERSION, "dispersion", OTHER_PICTURE, false, "glass refracts all colours as green" )                                   \
    X( PANES, "panes", OTHER_PICTURE, true,                                                                                      \
       "light finds its way through thin glass by chance alone: that of punctual lights does not, and each pane counts in the "  \
       "depth of paths" )                                                                                                        \
    X( ABSORPTION, "absorption", OTHER_PICTURE, false, "glass is clear inside" )                                                 \
    X( PUNCTUAL_LIGHTS, "punctual-lights", OTHER_PICTURE, false, "punctual lights are off" )                                     \
    X( ENVIRONMENT, "environment", OTHER_PICTURE, false, "the sky is black" )                                                    \
    X( TEXTURES, "textures", OTHER_PICTURE, true, "materials keep only their factors" )                                          \
    X( MIP_LEVELS, "mip-levels", OTHER_PICTURE, false, "cameras see the finest texels, however far" )                            \
    X( VERTEX_COLORS, "vertex-colors", OTHER_PICTURE, false, "vertex colours are white" )                                        \
    X( ALPHA_BLEND, "alpha-blend", OTHER_PICTURE, true, "blended surfaces are opaque" )                                          \
    X( ALPHA_MASK, "alpha-mask", OTHER_PICTURE, true, "masked surfaces are opaque" )                                             \
    X( NORMAL_MAPS, "normal-maps", OTHER_PICTURE, false, "normal textures are flat" )                                            \
    X( SMOOTH_GLOSS, "smooth-gloss", IMPOSSIBLE, true, "it goes with chains: leave those out" )                                  \
    X( CAUSTICS, "caustics", OTHER_PICTURE, false,                                                                               \
       "light that mirrors, glass and smooth metals throw on other surfaces is missing, and counted as removed" )                \
    X( LIGHT_TREE, "light-tree", OTHER_NOISE, false, "lights are sampled by power" )                                             \
    X( CHAINS, "chains", OTHER_NOISE, true, "what mirrors and glass show is not reused, neither in tiles nor in other frames" )  \
    X( LIGHT_PATHS, "light-paths", IMPOSSIBLE, false, "settings without it" )                                                    \
    X( FRAME_GROUPS, "frame-groups", IMPOSSIBLE, false, "groups of one frame" )                                                  \
    X( TILE_CONNECTIONS, "tile-connections", IMPOSSIBLE, false, "tiles of one pixel" )                                           \
    X( ADAPTIVE, "adaptive", IMPOSSIBLE, false, "settings without it" )                                                          \
    X( STOP_RULE, "stop-rule", IMPOSSIBLE, false, "settings without a noise, a flicker or a time to stop at" )                   \
    X( PIXEL_FILTER, "pixel-filter", IMPOSSIBLE, false, "the box of one pixel" )                                                 \
    X( OTHER_PROJECTION, "other-projection", IMPOSSIBLE, false, "a camera in perspective" )                                      \
    X( GRADIENTS, "gradients", IMPOSSIBLE, false, "another estimator" )

// RF_EFFECT_DIFFUSE and so on, in the order of the list.
typedef enum RfEffectId
{
#define RF_EFFECT_CONSTANT( constant, name, without, forced, what ) RF_EFFECT_##constant,
    RF_EFFECT_LIST( RF_EFFECT_CONSTANT )
#undef RF_EFFECT_CONSTANT
        RF_EFFECT_COUNT
} RfEffectId;

#define RF_EFFECT_BIT( effect ) ( (uint64_t)1 << ( effect ) )
#define RF_MAX_EFFECTS 64

// An effect, and whether it is called for.
typedef struct RfEffect
{
    const char* name; // a stable word, such as "phong"
    RfEffectId id;
    bool on;        // called for, and not left out
    bool left_out;  // by rf_choose_effects
    bool forced;    // likewise: its code runs although nothing calls for it
    bool by_render; // settings decide, alone or together with the scene
    char why[160];  // the material, lamp, camera or setting that calls for it, or why nothing does
} RfEffect;

struct RfScene; // not typedefs: C99 has each once
struct RfEye;
struct RfRenderSettings;
struct RfShot;

// Fills `effects` in the order of the list with those that a scene alone decides; returns their number, on or off.
int rf_list_effects( const struct RfScene* scene, RfEffect effects[RF_MAX_EFFECTS] );

// Fills `effects` with all of the list; returns their number, on or off. The cameras of the path decide on camera effects; without
// any (eye_count 0) all cameras of the scene do.
int rf_list_render_effects( const struct RfScene* scene, const struct RfEye* eyes, int eye_count,
                            const struct RfRenderSettings* settings, RfEffect effects[RF_MAX_EFFECTS] );

// The name of an effect, such as "panes".
const char* rf_effect_name( RfEffectId effect );

// What a picture is without it.
RfWithout rf_effect_without( RfEffectId effect );

// The same in words, such as "the sky is black".
const char* rf_effect_without_text( RfEffectId effect );

// The effects that can be forced: a set of RF_EFFECT_BITs.
uint64_t rf_forcible_effects( void );

// The effects that this build of the library does not have.
uint64_t rf_effects_not_built( void );

// "panes,textures" to a set of RF_EFFECT_BITs; NULL is none. Fails with RF_ERROR_USAGE for a word that is no effect (naming
// the nearest) or comes twice.
RfResult rf_parse_effects( const char* text, uint64_t* effects, RfError* error );

// A set of RF_EFFECT_BITs to "panes,textures", in the order of the list. RF_EFFECTS_TEXT_SIZE bytes are always enough.
void rf_format_effects( uint64_t effects, char* text, size_t size );

#define RF_EFFECTS_TEXT_SIZE 1024

// The names of those that a render of the shot calls for, whichever its frames, for RfOutput.calls_for.
void rf_name_effects( const struct RfShot* shot, const struct RfRenderSettings* settings, char text[RF_EFFECTS_TEXT_SIZE] );

// Leaves effects out of a scene, and runs the code of others whether or not something calls for them. Once, before the scene
// has a path or a tracer. Fails with RF_ERROR_USAGE for effects that cannot be left out or forced.
RfResult rf_choose_effects( struct RfScene* scene, uint64_t forced, uint64_t left_out, RfError* error );

RF_API_END

#endif
