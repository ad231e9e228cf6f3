// How eyes map points to pixels: by perspective (scene/pinhole.h), in parallel or as a panorama
// (src/reuse/estimators.md, section 15). Loops over lanes of perspective eyes use the pinhole itself.
#ifndef REFRAME_SCENE_PROJECTION_H
#define REFRAME_SCENE_PROJECTION_H

#include "base/built_in.h"
#include "scene/pinhole.h"

static inline bool rf_is_perspective( const RfEye* eye )
{
    return !rf_calls_for( eye->projection != RF_PERSPECTIVE, RF_EFFECT_OTHER_PROJECTION );
}
static inline bool rf_is_parallel( const RfEye* eye ) { return eye->projection == RF_ORTHOGRAPHIC; }

// The direction of all rays of a parallel eye, 1 m along `forward`.
static inline RfVec3 rf_parallel_direction( const RfEye* eye )
{
    return rf_madd( rf_madd( eye->forward, eye->right, eye->shear_x ), eye->up, eye->shear_y );
}

// Where the ray that reaches x starts.
static inline RfVec3 rf_eye_start( const RfEye* eye, RfVec3 x )
{
    return rf_is_parallel( eye ) ? rf_madd( x, rf_parallel_direction( eye ), -rf_pinhole_depth( eye, x ) ) : eye->origin;
}

// From there to x.
static inline RfVec3 rf_eye_way( const RfEye* eye, RfVec3 x )
{
    return rf_is_parallel( eye ) ? rf_scale( rf_parallel_direction( eye ), rf_pinhole_depth( eye, x ) )
                                 : rf_sub( x, eye->origin );
}

// No coordinate of the points where rays start is larger.
float rf_eye_reach( const RfEye* eye );

// Distance of x along the view, m; of a panorama from the eye.
static inline float rf_eye_depth( const RfEye* eye, RfVec3 x )
{
    return eye->projection == RF_PANORAMIC ? rf_length( rf_sub( x, eye->origin ) ) : rf_pinhole_depth( eye, x );
}

// Origin and unit direction of the ray through film position (column + u, row + v); `inverse` as for rf_pinhole_ray.
void rf_eye_ray( const RfEye* eye, const float inverse[2], int column, int row, float u, float v, RfVec3* o, RfVec3* d );

// Where a point, or with `infinite` what lies in a direction, is seen: pixels from the film's centre, +x right, +y up. False
// for what is not before the eye; a parallel eye sees nothing that is infinitely far.
bool rf_eye_position( const RfEye* eye, RfVec3 point, bool infinite, float at[2] );

// rf_project for eyes that are no pinholes.
RfProjection rf_project_otherwise( const RfEye* eye, RfVec3 x, RfVec3 ng );

// rf_project for any eye.
static inline RfProjection rf_project_any( const RfEye* eye, RfVec3 x, RfVec3 ng )
{
    return rf_is_perspective( eye ) ? rf_project( eye, x, ng ) : rf_project_otherwise( eye, x, ng );
}

// What an eye calls a difference of film positions along x: the shorter way round a panorama.
static inline float rf_film_difference( const RfEye* eye, float dx )
{
    float width = (float)eye->width;
    return eye->projection == RF_PANORAMIC ? dx - width * floorf( dx / width + 0.5f ) : dx;
}

#endif
