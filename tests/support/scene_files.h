// Small glTF files made in memory, for tests: accessors are added one by one,
// the rest of the JSON is given as text, and the whole is written as .gltf
// with a data URI or as .glb.
#ifndef REFRAME_TESTS_SCENE_FILES_H
#define REFRAME_TESTS_SCENE_FILES_H

#include "scene/camera.h"
#include "scene/camera_path/camera_track.h"
#include "scene/pose.h"
#include "scene/scene.h"
#include "scene_file/scene_file.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct GltfBuilder
{
    uint8_t bin[16384];
    size_t bin_size;
    int count; // accessors, each with a view of its own
    char views[8192];
    char accessors[8192];
    char json[32768];
} GltfBuilder;

typedef struct GltfFolder
{
    char path[64];
    char file[128]; // last name made by folder_file
} GltfFolder;

// A fresh folder under /tmp; removed again with the files of the names that the
// tests use: a.gltf, a.glb, a.bin, "b c.bin".
GltfFolder make_folder( void );
void remove_folder( GltfFolder* folder );
// The path of a file in it, valid until the next call.
const char* folder_file( GltfFolder* folder, const char* name );
const char* write_bytes( GltfFolder* folder, const char* name, const void* bytes, size_t size );

// Each adds data, a view and an accessor, and returns its index. `more` is
// further JSON of the accessor, such as ",\"normalized\":true".
int add_gltf_accessor( GltfBuilder* b, int component_type, const char* type, int count, const void* data, size_t size,
                       const char* more );
int add_gltf_floats( GltfBuilder* b, const char* type, int components, int count, const float* data );
int add_gltf_u16( GltfBuilder* b, int count, const uint16_t* data );

// A string for the caller to free.
char* gltf_base64( const uint8_t* bytes, size_t size );

// The JSON with a buffer that `uri` names (NULL: the chunk of a .glb), and the
// test's own members, `rest`, after it.
const char* build_gltf_json( GltfBuilder* b, const char* uri, const char* rest );
// Writes a.gltf with a data URI; returns its path.
const char* write_gltf( GltfBuilder* b, GltfFolder* folder, const char* rest );
// The bytes of a .glb; the caller frees them.
uint8_t* build_glb( GltfBuilder* b, const char* rest, size_t* size );

// One mutation, the same for the same number: flips, truncations, and digits
// or brackets of the JSON replaced by others. The container's own length is
// mended most of the time, else nothing behind it would be reached. Returns
// the new size, at most the old one.
size_t mutate_bytes( uint8_t* bytes, size_t size, uint64_t number );

// ---- gltf checks ----

// Loading of files made by the builder, and checks of what comes out, for
// the tests of the glTF reader.

extern GltfFolder gltf_folder;
extern char gltf_warnings[4096]; // of the last load, a line each

// Group set-up and tear-down: make and remove the folder.
int gltf_enter( void** state );
int gltf_leave( void** state );

// Both fail the test where the file does not load.
RfScene gltf_load( const char* path );
RfScene gltf_load_built( GltfBuilder* b, const char* rest );

RfScene gltf_load_with( const char* path, const RfGltfOptions* options );

// That it does not load, with an error that has `part`.
void gltf_refuse_built( GltfBuilder* b, const char* rest, const char* part );

// To within 1e-6, relative above 1.
void gltf_assert_near( float got, double want );
void gltf_assert_three( const float* got, double x, double y, double z );
void gltf_assert_rgb( RfVec3 got, double r, double g, double b );

// Position and normal of a corner, counted over all triangles.
void gltf_assert_corner( const RfScene* scene, int corner, double x, double y, double z );
void gltf_assert_normal( const RfScene* scene, int corner, double x, double y, double z );

// What moves, at a moment; fails the test where that cannot be posed.
RfPosedScene gltf_pose_at( const RfScene* scene, double time );
// A corner of a triangle of any number, in the world.
void gltf_find_placed_corner( const RfScene* scene, uint32_t triangle, int corner, double out[3] );
void gltf_assert_placed_corner( const RfScene* scene, uint32_t triangle, int corner, double x, double y, double z );
// Its normal, in the space of its mesh.
const float* gltf_placed_normal( const RfScene* scene, uint32_t triangle, int corner );
// Of all meshes that are posed.
void gltf_assert_unit_normals( const RfScene* scene );

// That the last load has warned so.
void gltf_assert_warned( const char* text );

// ---- json room ----

// A small glTF and scene files over it, in the folder of cli_run.h.

void write_text( const char* name, const char* text );

// room.gltf: a triangle that shines before the cameras "Eye" and "Side", and
// materials "vase" (Phong), "wood floor", two called "lamp" and one without a
// name. `extras` is further JSON of the scene object.
void write_room( const char* extras );

// rf_load_scene of a file of the folder.
RfResult load_named( const char* name, RfScene* scene, RfError* error );

// Writes {"scene": "room.gltf", MEMBERS} to scene.json and loads it.
RfResult try_members( const char* members, RfScene* scene, RfError* error );

// ---- camera path checks ----

// Camera paths from texts, for tests.

// Writes the text to path.json in the folder of cli_run.h and loads it; fails
// the test where it does not load. Free with rf_destroy_camera.
RfCamera load_path( const char* text );

// Loads the text, which must fail in one line that names the file and has `part`.
void expect_path_fault( const char* text, const char* part );

// The view at a time of the path; fails the test where there is none.
RfView view_at( const RfCamera* camera, double time );

void assert_close( double got, double want, double tolerance );
void assert_three( const double got[3], double x, double y, double z, double tolerance );

// ---- convert support ----

// Files to convert, and scenes loaded from what came out, for the tests of
// `reframe convert`. All names are in the folder of cli_run.h.

// Set-up and tear-down of a test: a folder of its own.
int convert_enter( void** state );
int convert_leave( void** state );

void convert_write( const char* name, const char* text );

// a.obj with a.mtl and wall.png: 5 triangles of 4 materials, and a line.
void convert_write_obj( void );

// Fails the test where the file does not load.
RfScene convert_load( const char* name );

// To within 1e-5, relative above 1.
bool convert_near( double a, double b );
void convert_assert_point( const float* p, double x, double y, double z );

// That the folder holds what the test wrote, this many files, and no more.
void convert_assert_files( int count );

#endif
