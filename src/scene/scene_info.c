// What the library reports of a scene (reframe/scene.h).
#include "scene/camera.h"
#include "scene/camera_path/camera_track.h"
#include "scene/projection.h"
#include "scene/scene.h"

#include <stdio.h>

RfResult rf_check_rendered( const RfScene* scene, RfError* error )
{
    int more = scene->unrendered_count - 1;
    char rest[32] = "";
    if ( more < 0 || scene->frozen )
        return RF_OK;
    if ( more > 0 )
        snprintf( rest, sizeof rest, " (and %d more)", more );
    return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: %s: %s%s: take it out, or freeze all as in the first frame (--freeze)",
                    scene->path, scene->unrendered->what, scene->unrendered->why, rest );
}

RfResult rf_scene_camera( const RfScene* scene, int index, RfFps fps, RfCameraInfo* info, RfError* error )
{
    if ( index < 0 || index >= scene->camera_count )
        return rf_fail( error, RF_ERROR_USAGE, "%s: has %d camera%s, there is none of index %d", scene->path, scene->camera_count,
                        scene->camera_count == 1 ? "" : "s", index );
    if ( fps.numerator == 0 && fps.denominator == 0 )
        fps = rf_scene_fps( scene );
    if ( fps.numerator < 1 || fps.denominator < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "frames per second must be above 0, got %d/%d", fps.numerator, fps.denominator );
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
