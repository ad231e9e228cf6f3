// `objects` of a scene file: which nodes and files move, and how.
#ifndef REFRAME_SCENE_FILE_OBJECTS_H
#define REFRAME_SCENE_FILE_OBJECTS_H

#include "base/json.h"
#include "gltf/gltf.h"

#define RF_OBJECT_PATHS ( RF_VISIBILITY + 1 )

// One of the list. Texts are the document's.
typedef struct RfObject
{
    RfField field;
    const char *node, *file;             // one of the two: a node of the scene's own file, or a file that is placed
    const char* name;                    // of what is placed
    unsigned given;                      // a bit for each RfAnimatedPath that it sets
    double still[RF_OBJECT_PATHS][4];    // translation, rotation, scale, and whether it is visible, without keys
    RfChannel channels[RF_OBJECT_PATHS]; // keys in seconds of the scene, for node -1; without any: `still`
    const char* animation;               // of the file; NULL: the first
    const char* variant;                 // of the file; NULL: none
    RfClock clock;                       // of the file
    const char* plays;                   // the first of the members that say how its animation is played, or NULL
} RfObject;

typedef struct RfObjects
{
    int count;
    RfObject* list;
    bool in_frames; // keys of some are numbers of frames
} RfObjects;

// Reads the list, which may be missing; frames are counted at `fps`, the first is 1, at 0 s. Free with rf_destroy_objects, also
// on failure.
RfResult rf_read_objects( const RfField* list, RfFps fps, RfObjects* objects );

void rf_destroy_objects( RfObjects* objects );

// Finds the nodes that objects name, in the document of the scene's own file, and appends what places, hides and moves them to
// `channels` (RfGltfOptions), which has room for 5 for each object. Fails where a name is not that of one node.
RfResult rf_find_nodes( const RfObjects* objects, const json_t* root, RfChannel* channels, int* count );

// Loads the files that objects place and makes them part of the scene, of so many frames per second: frozen at a time, in seconds,
// unless that is NULL.
RfResult rf_place_files( const RfObjects* objects, RfFps fps, const double* frozen_at, bool accept_losses, RfScene* scene,
                         RfLog* log );

#endif
