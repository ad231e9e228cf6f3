// The eyes of a whole path.
#include "base/file.h"
#include "reframe/render.h"
#include "scene/camera.h"
#include "scene/camera_path/camera_track.h"

#include <stdlib.h>
#include <string.h>

RfCameraPath rf_empty_camera_path( void ) { return ( RfCameraPath ){ .name = NULL }; }

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
    return rf_hash_bytes( rf_hash_bytes( hash, numbers, sizeof numbers ), size, sizeof size );
}

// The eyes of all frames; the hash starts with what a path file has.
static RfResult make_eyes( const RfScene* scene, const RfCamera* camera, RfFps fps, int width, int height, RfCameraPath* path,
                           RfError* error )
{
    RfResult result = rf_scene_frame_count( scene, camera, (double)fps.numerator / (double)fps.denominator, &path->count, error );
    if ( result != RF_OK )
        return result;
    path->name = strdup( camera->name );
    path->eyes = malloc( (size_t)path->count * sizeof *path->eyes );
    if ( path->eyes == NULL || path->name == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "camera '%s': no memory left for %d frames", camera->name, path->count );
    path->fps = fps;
    memcpy( path->origin, scene->origin, sizeof path->origin );
    path->hash = RF_HASH_START;
    if ( camera->track != NULL )
        path->hash = rf_hash_bytes( path->hash, &camera->track->hash, sizeof camera->track->hash );
    for ( int i = 0; i < path->count && result == RF_OK; ++i )
    {
        result = rf_camera_eye( scene, camera, (double)i, fps.numerator, fps.denominator, width, height, path->eyes + i, error );
        if ( result == RF_OK )
            path->hash = hash_eye( path->hash, path->eyes + i );
    }
    return result;
}

RfResult rf_create_camera_path( const RfScene* scene, const char* name, RfFps fps, int width, int height, RfCameraPath* path,
                                RfError* error )
{
    *path = rf_empty_camera_path();
    if ( fps.numerator < 1 || fps.denominator < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "frames per second must be above 0, got %d/%d", fps.numerator, fps.denominator );
    if ( width < 1 || height < 1 || width > RF_MAX_IMAGE_SIDE || height > RF_MAX_IMAGE_SIDE )
        return rf_fail( error, RF_ERROR_USAGE, "the image must be 1x1 to %dx%d pixels, got %dx%d", RF_MAX_IMAGE_SIDE,
                        RF_MAX_IMAGE_SIDE, width, height );
    RfCamera loaded = { 0 };
    const RfCamera* camera = &loaded;
    RfResult result;
    if ( is_path_file( name ) )
        result = rf_load_camera( name, &loaded, error );
    else
    {
        int index;
        result = rf_find_camera( scene, name, &index, error );
        camera = result == RF_OK ? scene->cameras + index : NULL;
    }
    if ( result == RF_OK )
        result = make_eyes( scene, camera, fps, width, height, path, error );
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
    *path = rf_empty_camera_path();
}
