// The cameras of a whole path, and its cuts.
#include "base/try.h"
#include "scene/movement.h"

#include "base/file.h"
#include "reframe/render.h"
#include "scene/camera.h"
#include "scene/camera_path/camera_track.h"
#include "scene/eye.h"
#include "scene/lens.h"
#include "scene/moments.h"
#include "scene/pose.h"
#include "scene/projection.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

// A camera that steps on more often is animated in steps, as in stop motion.
#define LEAST_HOLD 0.25 // s

// Does the channel jump with key k, after and before a hold?
static bool is_cut( const RfChannel* channel, int k )
{
    size_t n = (size_t)channel->components;
    const double *values = channel->values + (size_t)k * n, *times = channel->times + k;
    return memcmp( values, values - n, n * sizeof *values ) != 0 && times[0] - times[-1] >= LEAST_HOLD &&
           ( k + 1 == channel->count || times[1] - times[0] >= LEAST_HOLD );
}

static RfResult add_cut( double time, RfCamera* camera, RfError* error )
{
    if ( !rf_make_room( &camera->cuts, (size_t)camera->cut_count, sizeof *camera->cuts ) )
        return rf_fail( error, RF_ERROR_MEMORY, "camera '%.60s': out of memory for its cuts", camera->name );
    camera->cuts[camera->cut_count++] = time;
    return RF_OK;
}

static int compare( const void* a, const void* b )
{
    double x = *(const double*)a, y = *(const double*)b;
    return ( x > y ) - ( x < y );
}

static void sort_cuts( RfCamera* camera )
{
    int count = 0;
    if ( camera->cut_count > 0 )
        qsort( camera->cuts, (size_t)camera->cut_count, sizeof *camera->cuts, compare );
    for ( int i = 0; i < camera->cut_count; ++i )
    {
        if ( i == 0 || camera->cuts[i] > camera->cuts[count - 1] )
            camera->cuts[count++] = camera->cuts[i];
    }
    camera->cut_count = count;
}

static RfResult add_cuts( const RfChannel* c, RfCamera* camera, RfError* error )
{
    bool steps = c->interpolation == RF_STEP && c->curve == NULL && c->clock.speed == 0.0;
    for ( int k = 1; steps && k < c->count; ++k )
        RF_TRY( is_cut( c, k ) ? add_cut( c->times[k], camera, error ) : RF_OK );
    return RF_OK;
}

RfResult rf_find_step_cuts( const RfScene* scene, RfCamera* camera, RfError* error )
{
    RfResult result = camera->zoom != NULL ? add_cuts( &camera->zoom->channel, camera, error ) : RF_OK;
    for ( int node = camera->node; node >= 0; node = scene->nodes[node].parent )
    {
        int count;
        const RfChannel* channels = rf_node_channels( scene, node, &count );
        for ( int i = 0; result == RF_OK && i < count; ++i )
        {
            if ( channels[i].path == RF_TRANSLATION || channels[i].path == RF_ROTATION )
                result = add_cuts( channels + i, camera, error );
        }
    }
    sort_cuts( camera );
    return result;
}

#define DEFAULT_WIDTH 960
#define DEFAULT_HEIGHT 540

RfCameraPath rf_empty_camera_path( void ) { return ( RfCameraPath ){ .first = 1, .step = 1 }; }

static bool is_path_file( const char* name )
{
    size_t length = name != NULL ? strlen( name ) : 0;
    return length > 5 && strcmp( name + length - 5, ".json" ) == 0;
}

static uint64_t hash_eye( uint64_t hash, const RfEye* e )
{
    float numbers[13] = { e->origin.x, e->origin.y, e->origin.z,  e->right.x,   e->right.y,   e->right.z, e->up.x,
                          e->up.y,     e->up.z,     e->forward.x, e->forward.y, e->forward.z, e->focal };
    int size[2] = { e->width, e->height };
    hash = rf_hash_bytes( rf_hash_bytes( hash, numbers, sizeof numbers ), size, sizeof size );
    float film[3] = { e->focal_x, e->axis_x, e->axis_y };
    bool plain = film[0] == e->focal && film[1] == 0.5f * (float)e->width && film[2] == 0.5f * (float)e->height;
    hash = plain ? hash : rf_hash_bytes( hash, film, sizeof film ); // square pixels and a centred lens add nothing
    hash = e->time == 0.0 ? hash : rf_hash_bytes( hash, &e->time, sizeof e->time ); // nor does a scene that stands still
    if ( e->blur_steps > 0 )
    {
        const double shutter[2] = { e->opens, e->closes };
        hash = rf_hash_bytes( rf_hash_bytes( hash, shutter, sizeof shutter ), &e->blur_steps, sizeof e->blur_steps );
    }
    hash = e->shot == 0 ? hash : rf_hash_bytes( hash, &e->shot, sizeof e->shot );
    // RfEye has no padding
    return rf_is_sharp( e ) && e->projection == RF_PERSPECTIVE ? hash : rf_hash_bytes( hash, e, offsetof( RfEye, time ) );
}

int rf_frame_number( const RfCameraPath* path, int frame )
{
    return path->step > 0 ? path->first + frame * path->step : frame + 1; // a path of the caller's own may have no numbers
}

// Whether two frames are the same, at all moments of their shutters. RfEye has no padding.
static bool shows_same( const RfScene* scene, const RfEye* a, const RfEye* b )
{
    RfEye at = *a;
    at.time = b->time;
    at.opens = b->opens;
    at.closes = b->closes;
    bool same = memcmp( &at, b, sizeof at ) == 0 && !rf_scene_moves( scene, a->time, b->time );
    for ( int k = 0; same && a->blur_steps > 0 && k <= a->blur_steps; ++k )
        same = !rf_scene_moves( scene, rf_moment_time( a, k ), rf_moment_time( b, k ) );
    return same;
}

// Where no surface that moves differs between the moments of a shutter, nothing is blurred.
static void drop_still_moments( const RfScene* scene, RfEye* eye )
{
    for ( int k = 1; k <= eye->blur_steps; ++k )
    {
        if ( rf_surfaces_move( scene, rf_moment_time( eye, k - 1 ), rf_moment_time( eye, k ) ) )
            return;
    }
    eye->opens = eye->closes = 0.0;
    eye->blur_steps = 0;
}

// Frames that follow each other with equal cameras, between which nothing moves.
static RfResult find_runs( const RfScene* scene, RfCameraPath* path, RfError* error )
{
    path->runs = malloc( (size_t)path->count * sizeof *path->runs );
    path->run_of_frame = malloc( (size_t)path->count * sizeof *path->run_of_frame );
    if ( path->runs == NULL || path->run_of_frame == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "camera '%s': out of memory for %d frames", path->name, path->count );
    for ( int i = 0; i < path->count; ++i )
    {
        if ( i == 0 || !shows_same( scene, path->eyes + i, path->runs + path->run_count - 1 ) )
            path->runs[path->run_count++] = path->eyes[i];
        path->run_of_frame[i] = path->run_count - 1;
    }
    return RF_OK;
}

void rf_widen_eye( RfEye* eye, int x, int y )
{
    float* axes[] = { &eye->axis_x, &eye->axis_y, &eye->open.axis_x, &eye->open.axis_y, &eye->close.axis_x, &eye->close.axis_y };
    int count = eye->moves != 0 ? 6 : 2;
    eye->width += 2 * x;
    eye->height += 2 * y;
    for ( int i = 0; i < count; ++i )
        *axes[i] += (float)( i % 2 == 0 ? x : y );
}

static RfResult add_overscan( const RfCameraPath* path, RfEye* eye, RfError* error )
{
    if ( rf_projection_traits( rf_projection_of( eye ) )->extent == RF_EXTENT_ALL )
        return rf_fail( error, RF_ERROR_USAGE,
                        "camera '%.60s': a %s camera shows all directions: there is nothing around its picture", path->name,
                        g_rf_projection_names[eye->projection] );
    rf_widen_eye( eye, path->overscan[0], path->overscan[1] );
    return RF_OK;
}

// The cameras of all frames; the hash starts with what a path file has.
static RfResult make_eyes( const RfCameraSampling* sampling, RfCameraPath* path, RfError* error )
{
    const RfScene* scene = sampling->scene;
    const RfCamera* camera = sampling->camera;
    RfFps fps = sampling->fps;
    RfCameraFrames frames;
    RfResult result = rf_camera_frames( scene, camera, (double)fps.numerator / (double)fps.denominator, &frames, error );
    if ( result != RF_OK )
        return result;
    path->first = frames.first;
    path->step = frames.step;
    path->count = frames.count;
    path->name = strdup( camera->name );
    path->eyes = malloc( (size_t)path->count * sizeof *path->eyes );
    if ( path->eyes == NULL || path->name == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "camera '%s': out of memory for %d frames", camera->name, path->count );
    path->fps = fps;
    memcpy( path->origin, scene->origin, sizeof path->origin );
    path->hash = RF_HASH_START;
    if ( camera->track != NULL )
        path->hash = rf_hash_bytes( path->hash, &camera->track->hash, sizeof camera->track->hash );
    for ( int i = 0; i < path->count && result == RF_OK; ++i )
    {
        result = rf_camera_eye( sampling, (double)i, path->eyes + i, error );
        if ( result != RF_OK )
            break;
        drop_still_moments( scene, path->eyes + i );
        if ( ( path->overscan[0] | path->overscan[1] ) != 0 )
            result = add_overscan( path, path->eyes + i, error );
        path->hash = hash_eye( path->hash, path->eyes + i );
    }
    return result == RF_OK ? find_runs( scene, path, error ) : result;
}

// The aspect ratio of a camera's picture, 0 where it does not say: neither a camera path nor a panorama has one.
static double aspect_of( const RfCamera* camera )
{
    return camera->track == NULL && camera->projection != RF_PANORAMIC ? camera->aspect : 0.0;
}

// The camera that shows shot `i`.
static const RfCamera* shown_camera( const RfCameraSampling* sampling, int i )
{
    const RfEdit* edit = sampling->camera->edit;
    return edit != NULL ? sampling->scene->cameras + edit->shots[i].camera : sampling->camera;
}

// The size where neither the user nor the file says: as many pixels as the default in the camera's aspect ratio, with even sides.
static void default_size( double aspect, int* width, int* height )
{
    const double pixels = (double)DEFAULT_WIDTH * DEFAULT_HEIGHT, most = (double)RF_MAX_IMAGE_SIDE;
    double high = 2.0 * fmin( fmax( round( 0.5 * sqrt( pixels / aspect ) ), 1.0 ), 0.5 * most );
    *height = (int)high;
    *width = 2 * (int)fmin( fmax( round( 0.5 * high * aspect ), 1.0 ), 0.5 * most );
}

// The first aspect ratio of a camera that the picture does not have, to within a pixel.
static double unmet_aspect( const RfCameraSampling* sampling )
{
    int count = sampling->camera->edit != NULL ? sampling->camera->edit->count : 1;
    for ( int i = 0; i < count; ++i )
    {
        double aspect = aspect_of( shown_camera( sampling, i ) );
        if ( aspect > 0.0 && fabs( sampling->width - sampling->height * aspect ) > 1.0 &&
             fabs( sampling->height - sampling->width / aspect ) > 1.0 )
            return aspect;
    }
    return 0.0;
}

// Frames per second that are not given are those of the scene.
static RfResult complete_fps( const RfScene* scene, RfFps* fps, RfError* error )
{
    if ( fps->numerator == 0 && fps->denominator == 0 )
        *fps = rf_scene_fps( scene );
    if ( fps->numerator < 1 || fps->denominator < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "frames per second must be above 0, got %d/%d", fps->numerator, fps->denominator );
    return RF_OK;
}

// Fills in frames per second and film as the scene has them, and checks both.
static RfResult complete( RfCameraSampling* sampling, RfError* error )
{
    const RfScene* scene = sampling->scene;
    RF_TRY( complete_fps( scene, &sampling->fps, error ) );
    if ( sampling->width == 0 && sampling->height == 0 )
    {
        double aspect = aspect_of( shown_camera( sampling, 0 ) );
        sampling->width = scene->film_width > 0 ? scene->film_width : DEFAULT_WIDTH;
        sampling->height = scene->film_width > 0 ? scene->film_height : DEFAULT_HEIGHT;
        if ( scene->film_width == 0 && aspect > 0.0 )
            default_size( aspect, &sampling->width, &sampling->height );
    }
    RfFps fps = sampling->fps, keys = scene->key_fps;
    if ( keys.numerator > 0 && (int64_t)keys.numerator * fps.denominator != (int64_t)fps.numerator * keys.denominator )
        return rf_fail( error, RF_ERROR_USAGE,
                        "%s: keys of the scene count frames, at %g frames per second rather than %g: set \"fps\" of its "
                        "\"render\", or give keys times",
                        scene->path, (double)keys.numerator / keys.denominator, (double)fps.numerator / fps.denominator );
    int width = sampling->width, height = sampling->height;
    if ( width < 1 || height < 1 || width > RF_MAX_IMAGE_SIDE || height > RF_MAX_IMAGE_SIDE )
        return rf_fail( error, RF_ERROR_USAGE, "the image must be 1x1 to %dx%d pixels, got %dx%d", RF_MAX_IMAGE_SIDE,
                        RF_MAX_IMAGE_SIDE, width, height );
    return RF_OK;
}

// The margin in pixels; with it the film must not be too large.
static RfResult find_overscan( const RfOverscan* asked, const RfCameraSampling* sampling, int overscan[2], RfError* error )
{
    const int size[2] = { sampling->width, sampling->height };
    bool right = asked->size >= 0.0 && asked->size <= ( asked->relative ? 1.0 : RF_MAX_IMAGE_SIDE );
    for ( int i = 0; right && i < 2; ++i )
    {
        // 10 % of 30 pixels are 3, whatever 0.1 is in binary
        overscan[i] = (int)ceil( asked->relative ? asked->size * size[i] - 1e-6 : asked->size );
        if ( size[i] + 2 * overscan[i] > RF_MAX_IMAGE_SIDE )
            return rf_fail( error, RF_ERROR_USAGE, "a picture of %dx%d pixels with an overscan of %d has a side of more than %d",
                            size[0], size[1], overscan[i], RF_MAX_IMAGE_SIDE );
    }
    return right ? RF_OK
                 : rf_fail( error, RF_ERROR_USAGE, "overscan must be 0 to %d pixels or 0 to 100 %% of the picture",
                            RF_MAX_IMAGE_SIDE );
}

RfResult rf_create_camera_path( const RfScene* scene, const RfPathOptions* options, RfCameraPath* path, RfError* error )
{
    RfCamera loaded = { 0 };
    RfCameraSampling sampling = { scene, &loaded, options->lens, options->fps, options->width, options->height };
    *path = rf_empty_camera_path();
    RfResult result = RF_OK;
    if ( is_path_file( options->camera ) )
        result = rf_load_camera( options->camera, &loaded, error );
    else
    {
        int index;
        result = rf_find_camera( scene, options->camera, &index, error );
        sampling.camera = result == RF_OK ? scene->cameras + index : NULL;
    }
    if ( result == RF_OK )
        result = complete( &sampling, error );
    if ( result == RF_OK )
        result = find_overscan( &options->overscan, &sampling, path->overscan, error );
    if ( result == RF_OK )
    {
        path->unmet_aspect = unmet_aspect( &sampling );
        result = make_eyes( &sampling, path, error );
    }
    rf_destroy_camera( &loaded );
    if ( result != RF_OK )
        rf_destroy_camera_path( path );
    return result;
}

void rf_destroy_camera_path( RfCameraPath* path )
{
    if ( path == NULL )
        return;
    free( path->name );
    free( path->eyes );
    free( path->runs );
    free( path->run_of_frame );
    *path = rf_empty_camera_path();
}

RfResult rf_scene_camera( const RfScene* scene, int index, RfFps fps, RfCameraInfo* info, RfError* error )
{
    if ( index < 0 || index >= scene->camera_count )
        return rf_fail( error, RF_ERROR_USAGE, "%s: has %d camera%s, there is none of index %d", scene->path, scene->camera_count,
                        scene->camera_count == 1 ? "" : "s", index );
    RF_TRY( complete_fps( scene, &fps, error ) );
    const RfCamera* camera = scene->cameras + index;
    *info = ( RfCameraInfo ){ .name = camera->name, .shots = rf_camera_shots( camera ), .animated = camera->animated };
    if ( camera->track != NULL && !rf_camera_track_moves( camera->track ) )
        info->animated = false;
    info->projection = g_rf_projection_names[camera->track != NULL ? (int)camera->track->projection : camera->projection];
    RfCameraFrames frames;
    RfResult result = rf_camera_frames( scene, camera, (double)fps.numerator / (double)fps.denominator, &frames, error );
    info->frames = frames.count;
    info->first = frames.first;
    info->step = frames.step;
    return result;
}
