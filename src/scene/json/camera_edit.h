// The camera of a scene file that is an edit: cameras of the scene, one after the other.
#ifndef REFRAME_SCENE_JSON_CAMERA_EDIT_H
#define REFRAME_SCENE_JSON_CAMERA_EDIT_H

#include "base/json.h"
#include "scene/scene.h"

// Reads a list of { "name": a camera of the scene, "time": seconds or "frame": its first } (scenes/scene.schema.json). The edit
// lasts as long as its cameras and the scene move. `name` is copied. Free with rf_destroy_camera.
RfResult rf_read_camera_edit( const RfField* list, const RfScene* scene, const char* name, RfCamera* camera );

#endif
