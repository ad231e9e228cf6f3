#include "scene/camera.h"

#include "scene/animation.h"
#include "scene/camera_path/camera_track.h"
#include "scene/eye.h"
#include "scene/json/json_document.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_FRAMES 1000000
#define NAMES_LISTED 12

// Beyond this coordinate a float has no precision left for a camera.
#define MAX_COORDINATE 1e15

static void list_names( const RfScene* scene, char* text, size_t size )
{
    size_t used = 0;
    int listed = scene->camera_count < NAMES_LISTED ? scene->camera_count : NAMES_LISTED;
    for ( int i = 0; i < listed && used < size; ++i )
    {
        int n = snprintf( text + used, size - used, "%s'%.40s'", i > 0 ? ", " : "", scene->cameras[i].name );
        used += n > 0 ? (size_t)n : 0;
    }
    if ( listed < scene->camera_count && used < size )
        snprintf( text + used, size - used, " and %d more", scene->camera_count - listed );
}

static int default_camera( const RfScene* scene )
{
    if ( scene->chosen_camera > 0 )
        return scene->chosen_camera - 1;
    for ( int i = 0; i < scene->camera_count; ++i )
    {
        if ( scene->cameras[i].animated )
            return i;
    }
    return 0;
}

RfResult rf_find_camera( const RfScene* scene, const char* name, int* index, RfError* error )
{
    const char* path = scene->path != NULL ? scene->path : "scene";
    *index = -1;
    if ( scene->camera_count == 0 )
        return rf_fail( error, RF_ERROR_SCENE, "%s: has no camera: add one in the modelling program and export cameras", path );
    if ( name == NULL )
    {
        *index = default_camera( scene );
        return RF_OK;
    }
    for ( int i = 0; i < scene->camera_count; ++i )
    {
        if ( strcmp( scene->cameras[i].name, name ) == 0 )
        {
            *index = i;
            return RF_OK;
        }
    }
    char names[640];
    list_names( scene, names, sizeof names );
    return rf_fail( error, RF_ERROR_USAGE, "%s: has no camera '%.60s': choose one of %s", path, name, names );
}

// Blames the file: most often its times are wrong.
static RfResult fail_too_long( const RfCamera* camera, double fps, RfError* error )
{
    double seconds = camera->end - camera->start;
    if ( camera->track != NULL )
        return rf_fail( error, RF_ERROR_SCENE,
                        "%s: %g s at %g frames/s are more than %d frames: shorten it or lower the frames per second",
                        camera->track->clock, seconds, fps, MAX_FRAMES );
    return rf_fail(
        error, RF_ERROR_SCENE,
        "camera '%.60s': its animation of %g s at %g frames/s is more than %d frames: shorten it or lower the frames per second",
        camera->name, seconds, fps, MAX_FRAMES );
}

RfResult rf_camera_frame_count( const RfCamera* camera, double fps, int* count, RfError* error )
{
    *count = 0;
    if ( isfinite( fps ) == 0 || fps <= 0.0 )
        return rf_fail( error, RF_ERROR_USAGE, "camera '%.60s': frames per second must be above 0, got %g", camera->name, fps );
    *count = 1;
    if ( camera->animated == false )
        return RF_OK;
    // key times written as floats miss their frame slightly
    double rate = camera->track != NULL && camera->track->in_frames ? 1.0 / camera->track->step : fps;
    double frames = floor( ( camera->end - camera->start ) * rate + 1e-3 ) + 1.0;
    if ( ( frames <= (double)MAX_FRAMES ) == false )
    {
        *count = 0;
        return fail_too_long( camera, fps, error );
    }
    *count = frames > 1.0 ? (int)frames : 1;
    return RF_OK;
}

RfResult rf_scene_frame_count( const RfScene* scene, const RfCamera* camera, double fps, int* count, RfError* error )
{
    RfError fault = { 0 };
    RfResult result = rf_camera_frame_count( camera, fps, count, &fault );
    if ( result == RF_OK )
        return RF_OK;
    if ( result == RF_ERROR_SCENE && camera->track == NULL )
        return rf_fail( error, result, "%s: %s", scene->path, fault.text );
    return rf_fail( error, result, "%s", fault.text );
}

void rf_node_world_matrix( const RfScene* scene, int node, double time, RfMat4* matrix )
{
    *matrix = rf_mat4_identity();
    for ( ; node >= 0; node = scene->nodes[node].parent )
    {
        RfMat4 local;
        rf_node_local_matrix( scene, node, time, &local );
        *matrix = rf_mat4_mul( &local, matrix );
    }
}

// Normalises in double, so that no scale overflows or underflows a float.
static bool unit_axis( const double* column, double sign, double axis[3] )
{
    double largest = fmax( fabs( column[0] ), fmax( fabs( column[1] ), fabs( column[2] ) ) );
    if ( isfinite( column[0] + column[1] + column[2] ) == 0 || ( largest > 0.0 ) == false )
        return false;
    double sum = 0.0;
    for ( int i = 0; i < 3; ++i )
    {
        axis[i] = sign * ( column[i] / largest );
        sum += axis[i] * axis[i];
    }
    for ( int i = 0; i < 3; ++i )
        axis[i] /= sqrt( sum );
    return true;
}

static RfVec3 to_vec3( const double v[3] ) { return rf_vec3( (float)v[0], (float)v[1], (float)v[2] ); }

static RfVec3 in_scene( const RfScene* scene, const double v[3] )
{
    return rf_vec3( (float)( v[0] - scene->origin[0] ), (float)( v[1] - scene->origin[1] ), (float)( v[2] - scene->origin[2] ) );
}

static bool in_range( const double* origin )
{
    for ( int i = 0; i < 3; ++i )
    {
        // written so that NaN fails
        if ( ( fabs( origin[i] ) <= MAX_COORDINATE ) == false )
            return false;
    }
    return true;
}

// Makes a fresh eye orthographic or panoramic.
static void project_otherwise( RfEye* eye, RfProjectionKind projection, double ymag )
{
    if ( projection == RF_ORTHOGRAPHIC )
        *eye = rf_make_orthographic_eye( eye->origin, eye->forward, eye->up, ymag, eye->width, eye->height );
    if ( projection == RF_PANORAMIC )
        *eye = rf_make_panoramic_eye( eye->origin, eye->forward, eye->up, eye->width, eye->height );
}

static RfResult node_eye( const RfScene* scene, const RfCamera* self, double time, int width, int height, RfEye* eye,
                          RfError* error )
{
    RfMat4 world;
    rf_node_world_matrix( scene, self->node, time, &world );
    double forward[3], up[3];
    bool sound = unit_axis( world.m + 8, -1.0, forward ) && unit_axis( world.m + 4, 1.0, up );
    if ( sound )
    {
        double cosine = forward[0] * up[0] + forward[1] * up[1] + forward[2] * up[2];
        sound = fabs( cosine ) < 1.0 - 1e-9;
    }
    if ( sound == false || in_range( world.m + 12 ) == false )
        return rf_fail( error, RF_ERROR_SCENE,
                        "%s: camera '%.60s' at %g s: its transform is degenerate or not finite: "
                        "remove zero scales from it and from its parents",
                        scene->path != NULL ? scene->path : "scene", self->name, time );
    *eye = rf_make_eye_inline( in_scene( scene, world.m + 12 ), to_vec3( forward ), to_vec3( up ),
                               self->projection == RF_PERSPECTIVE ? self->yfov : 1.0, width, height );
    project_otherwise( eye, (RfProjectionKind)self->projection, self->ymag );
    return RF_OK;
}

static RfResult track_eye( const RfScene* scene, const RfCamera* self, double time, int width, int height, RfEye* eye,
                           RfError* error )
{
    RfView view;
    RfResult result = rf_sample_camera_track( self->track, time, &view, error );
    if ( result == RF_OK && !in_range( view.position ) )
        return rf_fail( error, RF_ERROR_SCENE, "%s: leads beyond %g: scale it down", self->track->name, MAX_COORDINATE );
    if ( result != RF_OK )
        return result;
    *eye = rf_make_eye_inline( in_scene( scene, view.position ), to_vec3( view.forward ), to_vec3( view.up ),
                               view.projection == RF_PERSPECTIVE ? view.fov : 1.0, width, height );
    project_otherwise( eye, view.projection, view.fov );
    if ( view.aspect != 1.0 || view.shift[0] != 0.0 || view.shift[1] != 0.0 )
        rf_shift_eye( eye, view.aspect, view.shift[0], view.shift[1] );
    return RF_OK;
}

static RfResult check_film( const RfCamera* self, int width, int height, RfEye* eye, RfError* error )
{
    *eye = ( RfEye ){ 0 };
    if ( width > 0 && height > 0 )
        return RF_OK;
    return rf_fail( error, RF_ERROR_USAGE, "camera '%.60s': the film must have pixels, got %d × %d", self->name, width, height );
}

RfResult rf_scene_eye( const RfScene* scene, int camera, double time, int width, int height, RfEye* eye, RfError* error )
{
    *eye = ( RfEye ){ 0 };
    if ( camera < 0 || camera >= scene->camera_count )
        return rf_fail( error, RF_ERROR_USAGE, "camera %d: the scene has %d", camera, scene->camera_count );
    const RfCamera* self = scene->cameras + camera;
    RfResult result = check_film( self, width, height, eye, error );
    if ( result == RF_OK && self->track != NULL && self->track->in_frames )
        return rf_fail( error, RF_ERROR_USAGE, "camera '%.60s': its path counts frames, not seconds", self->name );
    if ( result != RF_OK )
        return result;
    return self->track != NULL ? track_eye( scene, self, time, width, height, eye, error )
                               : node_eye( scene, self, time, width, height, eye, error );
}

double rf_camera_time( const RfCamera* camera, double frame, int numerator, int denominator )
{
    if ( camera->track != NULL && camera->track->in_frames )
        return camera->start + frame * camera->track->step;
    // A single division of integers, so that the time of a frame does not depend on how it is
    // computed.
    return camera->start + frame * (double)denominator / (double)numerator;
}

RfResult rf_camera_eye( const RfScene* scene, const RfCamera* camera, double frame, int numerator, int denominator, int width,
                        int height, RfEye* eye, RfError* error )
{
    RfResult result = check_film( camera, width, height, eye, error );
    if ( result != RF_OK )
        return result;
    double time = rf_camera_time( camera, frame, numerator, denominator );
    return camera->track != NULL ? track_eye( scene, camera, time, width, height, eye, error )
                                 : node_eye( scene, camera, time, width, height, eye, error );
}

void rf_camera_numbers( const RfCamera* camera, int* first, int* step )
{
    bool counts = camera->track != NULL && camera->track->in_frames;
    *first = counts && floor( camera->start ) == camera->start ? (int)camera->start + 1 : 1;
    *step = counts ? camera->track->step : 1;
}

// Takes ownership of the track, or frees it on failure.
static RfResult wrap_track( RfCameraTrack* track, const char* name, RfCamera* camera, RfError* error )
{
    *camera = ( RfCamera ){ .name = strdup( name ), .track = malloc( sizeof *camera->track ), .node = -1 };
    if ( camera->name == NULL || camera->track == NULL )
    {
        free( camera->name );
        free( camera->track );
        *camera = ( RfCamera ){ 0 };
        rf_destroy_camera_track( track );
        return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left", name );
    }
    *camera->track = *track;
    camera->animated = track->end > track->start;
    camera->start = track->start;
    camera->end = track->end;
    return RF_OK;
}

RfResult rf_load_camera( const char* path, RfCamera* camera, RfError* error )
{
    RfCameraTrack track;
    *camera = ( RfCamera ){ 0 };
    RfResult result = rf_load_camera_track( path, &track, error );
    return result == RF_OK ? wrap_track( &track, path, camera, error ) : result;
}

RfResult rf_read_camera( const RfField* object, const char* name, RfCamera* camera, RfError* error )
{
    RfCameraTrack track;
    *camera = ( RfCamera ){ 0 };
    RfResult result = rf_read_camera_track( object, &track, error );
    return result == RF_OK ? wrap_track( &track, name, camera, error ) : result;
}
