#include "support/moving_rooms.h"

#include "gltf/gltf.h"
#include "reframe/camera.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static MovingRoom load( const char* file, bool moving, int width, int height )
{
    MovingRoom room;
    RfError error;
    RfLog log = { 0 };
    RfCameraPath path = rf_empty_camera_path();
    RfResult result = rf_load_gltf( file, &room.scene, &log, &error );
    if ( result == RF_OK )
        result = rf_create_camera_path( &room.scene, &( RfPathOptions ){ .width = width, .height = height }, &path, &error );
    if ( result != RF_OK || path.count > MOVING_EYES || moving != ( room.scene.movement != NULL ) )
    {
        fprintf( stderr, "%s: %s\n", file, result != RF_OK ? error.text : "not as its script makes it" );
        abort();
    }
    room.eye_count = path.count;
    memcpy( room.eyes, path.eyes, (size_t)path.count * sizeof *path.eyes );
    rf_destroy_camera_path( &path );
    return room;
}

MovingRoom load_moving_room( const char* name, int width, int height )
{
    char file[512];
    snprintf( file, sizeof file, "%s/moving/%s.glb", REFRAME_SCENE_FOLDER, name );
    return load( file, true, width, height );
}

MovingRoom load_still_room( const char* name, int frame, int width, int height )
{
    char file[512];
    snprintf( file, sizeof file, "%s/moving/%s-%d.glb", REFRAME_SCENE_FOLDER, name, frame );
    return load( file, false, width, height );
}
