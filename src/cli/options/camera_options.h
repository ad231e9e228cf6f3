// From the camera options that commands share to the eyes of a whole path.
#ifndef REFRAME_CLI_OPTIONS_CAMERA_OPTIONS_H
#define REFRAME_CLI_OPTIONS_CAMERA_OPTIONS_H

#include "cli/options/options.h"
#include "scene/eye.h"
#include "scene/scene.h"

#define RF_DEFAULT_FPS ( ( RfFps ){ 24, 1 } )

// The eyes of a camera's path, one per frame.
typedef struct RfCameraPath
{
    char* name; // of the camera, or of the file
    int count;
    RfEye* eyes;
    uint64_t hash; // of all eyes: a frame is made of its neighbours' paths too
} RfCameraPath;

double rf_fps_value( RfFps fps );

// The path of the camera called `name` (NULL: the one that the scene file asks
// for, else the scene's first animated one, else its first), or with a name that
// ends in .json that of a camera-path file, on a film of `size`. Free with rf_destroy_camera_path.
RfResult rf_create_camera_path( const RfScene* scene, const char* name, RfFps fps, RfSize size, RfCameraPath* path,
                                RfError* error );
void rf_destroy_camera_path( RfCameraPath* path );

#endif
