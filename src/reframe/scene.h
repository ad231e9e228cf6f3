// Scenes: loading them, what is in them, and the tracer that a render shoots its
// rays with.
//
//     RfScene* scene = NULL;
//     RfTracer* tracer = NULL;
//     if ( rf_open_scene( "room.glb", &scene, &log, &error ) == RF_OK )
//         result = rf_create_tracer( scene, &tracer, &error );
//     ...
//     rf_destroy_tracer( tracer ); // before its scene
//     rf_close_scene( scene );
#ifndef REFRAME_SCENE_H
#define REFRAME_SCENE_H

#include "reframe/effects.h"
#include "reframe/error.h"
#include "reframe/types.h"

RF_API_BEGIN

// Triangles, materials, lights and cameras; does not change once it is loaded.
typedef struct RfScene RfScene;

// Loads a scene: a .glb or .gltf (glTF 2.0), or a scene file (.json) that names one of these
// and adds what moves, other files, a camera path, an environment or changes of materials. What is ignored or looks
// wrong goes to `log` (may be NULL). On failure *scene is NULL. Free with rf_close_scene.
RfResult rf_open_scene( const char* path, RfScene** scene, RfLog* log, RfError* error );

// What of a scene is read; zeros are as rf_open_scene reads it.
typedef struct RfSceneOptions
{
    bool freeze;           // all but cameras stands still, as in the first frame of the default camera
    const char* animation; // of the glTF: those of this name go before the others where several move the same; NULL: the first
    const char* variant;   // of the glTF (KHR_materials_variants), which gives its meshes other materials; NULL: their own
    bool accept_losses;    // textures that cannot be read are left out, and listed (RfSceneInfo.losses); else they are an error
} RfSceneOptions;

// Fails with RF_ERROR_USAGE, naming those there are, if no animation or variant has the name asked for.
RfResult rf_open_scene_with( const char* path, const RfSceneOptions* options, RfScene** scene, RfLog* log, RfError* error );

// Frees a scene; NULL is allowed. No tracer may be using it.
void rf_close_scene( RfScene* scene );

// Something that changes in the file and cannot be rendered so.
typedef struct RfUnrendered
{
    char* what; // such as "material 'glow'"
    char* why;  // such as "the file animates /materials/0/alphaCutoff, which is not rendered"
} RfUnrendered;

typedef struct RfSceneInfo
{
    const char* path;          // as it was opened; the scene's
    uint32_t triangles;        // as placed by nodes
    uint32_t stored_triangles; // in memory: fewer where instances share them
    uint32_t instances;        // meshes as placed by nodes
    uint32_t materials;
    uint32_t lights; // emitting triangles, punctual lights, and the sky as one
    uint32_t emitting_triangles;
    double emitting_area; // m²; of what moves as at the first key of the scene
    int punctual_lights;  // point, spot and directional
    bool has_sky;         // an environment that shines
    int cameras;          // may be 0: rf_create_camera_path then needs a path file
    RfVec3 bounds_min;    // of the triangles, metres; both 0 where there are none
    RfVec3 bounds_max;
    double origin[3];          // cameras are relative to it, metres; 0 unless the scene lies so far out that floats would not do
    RfFps fps;                 // that the scene asks for; 0/0: it does not say
    int width, height;         // of the picture, likewise
    bool alpha;                // the file asks for RGBA
    int moving_count;          // objects that move, or would if they were not frozen
    const char* const* moving; // their names
    bool frozen;               // they stand still, as RfSceneOptions.freeze asked for
    int unrendered_count;      // what changes in the file and cannot be rendered: unless it is frozen, no tracer can be made
    const RfUnrendered* unrendered;
    int variant_count;               // of materials (KHR_materials_variants), whichever is chosen
    const char* const* variants;     // their names
    int light_group_count;           // tags of lights, as a render may split its picture by (RfRenderSettings.light_groups)
    const char* const* light_groups; // their names
    int loss_count;                  // what RfSceneOptions.accept_losses went on without
    const char* const* losses;
    int export_loss_count; // of the program that wrote the file: what freezes a movement or changes the light of the picture
    const char* const* export_losses;
    int export_warning_count; // its smaller losses
    const char* const* export_warnings;
} RfSceneInfo;

// Counts what is in a scene. Fails with RF_ERROR_MEMORY only.
RfResult rf_scene_info( const RfScene* scene, RfSceneInfo* info, RfError* error );

typedef struct RfLightInfo
{
    const char* kind; // "lamp", "material" that may emit, or "sky"
    const char* name; // the scene's; "environment" of the sky
    int group;        // of RfSceneInfo.light_groups; −1: none
    bool shines;      // else it is a lamp without power, a material that emits nothing, or there is no sky
} RfLightInfo;

// Describes what may shine in a scene by number, from 0 on: its lamps, its materials, the sky. False beyond the last.
bool rf_scene_light( const RfScene* scene, int index, RfLightInfo* info );

typedef struct RfCameraInfo
{
    const char* name;       // unique, never empty; the scene's
    int frames;             // of its path at the frame rate asked for; 1 where it stands still and nothing moves
    int shots;              // between the cuts of its path; 1: there are none
    bool animated;          // false also where it stands still in all its frames
    int first, step;        // number of its first frame, and from a frame's number to the next one's
    const char* projection; // "perspective", "orthographic" or "panoramic"
} RfCameraInfo;

// Describes camera `index`, 0 to RfSceneInfo.cameras - 1, at `fps`; 0/0 is the scene's own rate, else 24. Fails with RF_ERROR_USAGE for an index
// or a rate out of range, with RF_ERROR_SCENE for a path of more than 1,000,000 frames.
RfResult rf_scene_camera( const RfScene* scene, int index, RfFps fps, RfCameraInfo* info, RfError* error );

// A scene with its acceleration structure and light distribution. Rays may be traced
// from many threads at a time.
typedef struct RfTracer RfTracer;

// Builds the BVH of a scene, which must outlive the tracer. In an empty scene every ray misses.
// Fails with RF_ERROR_DEVICE or RF_ERROR_MEMORY, and with RF_ERROR_UNSUPPORTED where something changes that cannot be
// rendered so (RfSceneInfo.unrendered).
RfResult rf_create_tracer( const RfScene* scene, RfTracer** tracer, RfError* error );

// Frees a tracer; NULL is allowed.
void rf_destroy_tracer( RfTracer* tracer );

// The scene that it was created for.
const RfScene* rf_tracer_scene( const RfTracer* tracer );

// Embree's version and instruction set, on which images depend besides the scene.
const char* rf_tracer_device( const RfTracer* tracer );

// Does anything shine: a material, a lamp, the sky? Else every picture is black.
bool rf_tracer_has_light( const RfTracer* tracer );

// Memory of Embree and of the triangle records, bytes. It is not part of a render's budget.
size_t rf_tracer_bytes( const RfTracer* tracer );

RF_API_END

#endif
