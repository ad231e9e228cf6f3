// A small glTF and scene files over it, in the folder of cli_run.h.
#ifndef REFRAME_TESTS_JSON_ROOM_H
#define REFRAME_TESTS_JSON_ROOM_H

#include "scene/json/scene_file.h"

void write_text( const char* name, const char* text );

// room.gltf: a triangle that shines before the cameras "Eye" and "Side", and
// materials "vase" (Phong), "wood floor", two called "lamp" and one without a
// name. `extras` is further JSON of the scene object.
void write_room( const char* extras );

// rf_load_scene of a file of the folder.
RfResult load_named( const char* name, RfScene* scene, RfError* error );

// Writes {"scene": "room.gltf", MEMBERS} to scene.json and loads it.
RfResult try_members( const char* members, RfScene* scene, RfError* error );

#endif
