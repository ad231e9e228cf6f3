#include "cli/camera_options.h"

#include "base/file.h"
#include "scene/camera.h"

#include <stdlib.h>
#include <string.h>

double rf_fps_value( RfFps fps )
{
    return (double)fps.numerator / (double)fps.denominator;
}

static bool is_path_file( const char* name )
{
    size_t length = name != NULL ? strlen( name ) : 0;
    return length > 5 && strcmp( name + length - 5, ".json" ) == 0;
}

static RfResult find_camera( const RfScene* scene, const char* name, int* camera, RfError* error )
{
    RfResult result = rf_find_camera( scene, name, camera, error );
    if ( result != RF_OK && is_path_file( name ) )
        return rf_fail( error, RF_ERROR_UNSUPPORTED,
                        "--camera: '%s': camera-path files are not read yet, name a camera of the scene", name );
    return result;
}

static uint64_t hash_eye( uint64_t hash, const RfEye* e )
{
    float numbers[13] = { e->origin.x, e->origin.y, e->origin.z,  e->right.x,   e->right.y,   e->right.z, e->up.x,
                          e->up.y,     e->up.z,     e->forward.x, e->forward.y, e->forward.z, e->focal };
    int size[2] = { e->width, e->height };
    return rf_hash_bytes( rf_hash_bytes( hash, numbers, sizeof numbers ), size, sizeof size );
}

RfResult rf_create_camera_path( const RfScene* scene, const char* name, RfFps fps, RfSize size, RfCameraPath* path,
                                RfError* error )
{
    *path = ( RfCameraPath ){ 0 };
    RfResult result = find_camera( scene, name, &path->camera, error );
    if ( result != RF_OK )
        return result;
    const RfCamera* camera = scene->cameras + path->camera;
    result = rf_camera_frame_count( camera, rf_fps_value( fps ), &path->count, error );
    if ( result != RF_OK )
        return result;
    path->eyes = malloc( (size_t)path->count * sizeof *path->eyes );
    if ( path->eyes == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "camera '%s': no memory left for %d frames", camera->name, path->count );
    path->hash = RF_HASH_START;
    for ( int i = 0; i < path->count && result == RF_OK; ++i )
    {
        // One division from whole numbers, so that a frame's time is the same however it is reached.
        double time = camera->start + (double)i * (double)fps.denominator / (double)fps.numerator;
        result = rf_scene_eye( scene, path->camera, time, size.width, size.height, path->eyes + i, error );
        if ( result == RF_OK )
            path->hash = hash_eye( path->hash, path->eyes + i );
    }
    if ( result != RF_OK )
        rf_destroy_camera_path( path );
    return result;
}

void rf_destroy_camera_path( RfCameraPath* path )
{
    free( path->eyes );
    *path = ( RfCameraPath ){ 0 };
}
