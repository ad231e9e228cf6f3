// How cameras map points to pixels: by perspective (scene/pinhole.h), in parallel or as a panorama
// (src/reuse/estimators.md, section 15). Loops over lanes of perspective cameras use the pinhole itself.
//
// One projection more is a value of RfProjectionKind (reframe/camera.h), a row here, and a case in every switch that the compiler
// then names: none over RfProjectionKind has a default. All other code asks for a column of the table, or whether a camera is in
// perspective, for a faster way beside one that suits all cameras.
#ifndef REFRAME_SCENE_PROJECTION_H
#define REFRAME_SCENE_PROJECTION_H

#include "base/built_in.h"
#include "scene/pinhole.h"

// How the rays of a camera run.
typedef enum RfEyeRays
{
    RF_RAYS_FROM_ORIGIN, // all from eye->origin, in different directions
    RF_RAYS_PARALLEL,    // in one direction, from different points: rf_eye_start
} RfEyeRays;

// What says how much of the scene a camera shows.
typedef enum RfExtent
{
    RF_EXTENT_FOV,  // "fov", a vertical angle
    RF_EXTENT_YMAG, // "ymag", half the height of the picture, m
    RF_EXTENT_ALL,  // nothing: it shows all directions
} RfExtent;

// X( kind, name, rays, extent, what it has in place of a field of view, whether it takes a shift and an aspect of the pixels,
//    whether it takes a lens, whether glTF has it: others are perspective there, with "projection" in their extras )
// clang-format off
#define RF_PROJECTIONS( X ) \
    X( RF_PERSPECTIVE, "perspective", RF_RAYS_FROM_ORIGIN, RF_EXTENT_FOV, "", true, true, true ) \
    X( RF_ORTHOGRAPHIC, "orthographic", RF_RAYS_PARALLEL, RF_EXTENT_YMAG, "an orthographic one has ymag", true, true, true ) \
    X( RF_PANORAMIC, "panoramic", RF_RAYS_FROM_ORIGIN, RF_EXTENT_ALL, "a panorama shows all directions", false, false, false )
// clang-format on

typedef struct RfProjectionTraits
{
    const char* name;
    RfEyeRays rays;
    RfExtent extent;
    const char* instead_of_fov;
    bool takes_shift, takes_lens, in_gltf;
} RfProjectionTraits;

#define RF_PROJECTION_ONE( ... ) +1
enum
{
    RF_PROJECTION_COUNT = 0 RF_PROJECTIONS( RF_PROJECTION_ONE )
};

const RfProjectionTraits* rf_projection_traits( RfProjectionKind kind );

// The names in the order of RfProjectionKind, and NULL.
extern const char* const g_rf_projection_names[];

static inline RfProjectionKind rf_projection_of( const RfEye* eye ) { return (RfProjectionKind)eye->projection; }

static inline bool rf_is_perspective( const RfEye* eye )
{
    return !rf_calls_for( eye->projection != RF_PERSPECTIVE, RF_EFFECT_OTHER_PROJECTION );
}

// All rays have the same direction, and start where the film is.
static inline bool rf_is_parallel( const RfEye* eye )
{
#define RF_PROJECTION_RAYS( kind, name, rays, ... )                                                                              \
    case kind: return rays == RF_RAYS_PARALLEL;
    switch ( rf_projection_of( eye ) )
    {
        RF_PROJECTIONS( RF_PROJECTION_RAYS )
    }
    return false;
}

// The direction of all rays of a parallel camera, 1 m along `forward`.
static inline RfVec3 rf_parallel_direction( const RfEye* eye )
{
    return rf_madd( rf_madd( eye->forward, eye->right, eye->shear_x ), eye->up, eye->shear_y );
}

// Where the ray that reaches x starts.
static inline RfVec3 rf_eye_start( const RfEye* eye, RfVec3 x )
{
    switch ( rf_projection_of( eye ) )
    {
        case RF_ORTHOGRAPHIC: return rf_madd( x, rf_parallel_direction( eye ), -rf_pinhole_depth( eye, x ) );
        case RF_PERSPECTIVE:
        case RF_PANORAMIC: break;
    }
    return eye->origin;
}

// From there to x.
static inline RfVec3 rf_eye_way( const RfEye* eye, RfVec3 x )
{
    switch ( rf_projection_of( eye ) )
    {
        case RF_ORTHOGRAPHIC: return rf_scale( rf_parallel_direction( eye ), rf_pinhole_depth( eye, x ) );
        case RF_PERSPECTIVE:
        case RF_PANORAMIC: break;
    }
    return rf_sub( x, eye->origin );
}

// No coordinate of the points where rays start is larger.
float rf_eye_reach( const RfEye* eye );

// Distance of x along the view, m; of a panorama from the camera.
static inline float rf_eye_depth( const RfEye* eye, RfVec3 x )
{
    switch ( rf_projection_of( eye ) )
    {
        case RF_PANORAMIC: return rf_length( rf_sub( x, eye->origin ) );
        case RF_PERSPECTIVE:
        case RF_ORTHOGRAPHIC: break;
    }
    return rf_pinhole_depth( eye, x );
}

// Origin and unit direction of the ray through film position (column + u, row + v); `inverse` as for rf_pinhole_ray.
void rf_eye_ray( const RfEye* eye, const float inverse[2], int column, int row, float u, float v, RfVec3* o, RfVec3* d );

// Where a point, or with `infinite` what lies in a direction, is seen: pixels from the film's centre, +x right, +y up. False
// for what is not before the camera; a parallel camera sees nothing that is infinitely far.
bool rf_eye_position( const RfEye* eye, RfVec3 point, bool infinite, float at[2] );

// rf_project for cameras that are no pinholes.
RfProjection rf_project_otherwise( const RfEye* eye, RfVec3 x, RfVec3 ng );

// rf_project for any eye.
static inline RfProjection rf_project_any( const RfEye* eye, RfVec3 x, RfVec3 ng )
{
    return rf_is_perspective( eye ) ? rf_project( eye, x, ng ) : rf_project_otherwise( eye, x, ng );
}

// What a camera calls a difference of film positions along x: the shorter way round a panorama.
static inline float rf_film_difference( const RfEye* eye, float dx )
{
    float width = (float)eye->width;
    switch ( rf_projection_of( eye ) )
    {
        case RF_PANORAMIC: return dx - width * floorf( dx / width + 0.5f );
        case RF_PERSPECTIVE:
        case RF_ORTHOGRAPHIC: break;
    }
    return dx;
}

#endif
