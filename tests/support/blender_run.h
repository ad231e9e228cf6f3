// Blender for tests: that of the path, or the one that the environment variable REFRAME_BLENDER names, a program or a Python that has
// bpy. Scenes are made inside of it by
// blender_make.py, exported, rendered by Cycles and by Reframe, and their pictures compared.
//
//     BLENDER_TEST( test_something )
//     {
//         blender_make( "materials --samples 256 glass" );  // glass.blend and glass-1.exr
//         const CliResult* done = blender_export( "glass", "--bake 64" );
//         …
//     }
#ifndef REFRAME_TESTS_BLENDER_RUN_H
#define REFRAME_TESTS_BLENDER_RUN_H

#include "scene/scene.h"
#include "support/cli_run.h"
#include "support/scene_files.h"
#include "support/test.h"

#define BLENDER "python3 -B " REFRAME_SOURCE_DIR "/scripts/blender/run -b "
#define BLENDER_SCRIPT REFRAME_SOURCE_DIR "/scripts/blender/export.py -- "

// A test in a folder of its own; skipped if there is no Blender with numpy.
#define BLENDER_TEST( name )                                                                                                     \
    static void name##_in_blender( void );                                                                                       \
    TEST( name )                                                                                                                 \
    {                                                                                                                            \
        if ( !enter_with_blender() )                                                                                             \
            skip();                                                                                                              \
        name##_in_blender();                                                                                                     \
        cli_leave();                                                                                                             \
    }                                                                                                                            \
    static void name##_in_blender( void )

// Enters a folder if there is a Blender with numpy; else says that the test is skipped.
bool enter_with_blender( void );

// The version's first number, and whether it is 4 or later.
int blender_major( void );
bool blender_is_4( void );

// Runs blender_make.py with these words; returns what it says.
const CliResult* blender_make( const char* format, ... ) __attribute__( ( format( printf, 1, 2 ) ) );

// Exports SCENE.blend to SCENE.glb, baking into one cache.
const CliResult* blender_export( const char* scene, const char* options );
// The same, which must succeed.
const CliResult* blender_exported( const char* scene, const char* options );

// Fails unless each of these is said.
void expect_said( const char* text, const char* part );
void expect_all_said( const char* text, const char* const* parts, size_t count );
#define EXPECT_ALL_SAID( text, parts ) expect_all_said( text, parts, sizeof( parts ) / sizeof *( parts ) )

// What fails the test where there is none of this name.
const RfMaterial* find_material( const RfScene* scene, const char* name );
const RfPunctual* find_lamp( const RfScene* scene, const char* name );

// Of a picture of ours, of the folder, to another one.
typedef struct Difference
{
    double mean;   // of the whole picture, relative
    double blocks; // root of the mean square over blocks, relative to the whole
    double worst;  // block, relative to itself, less 1e-3
    double pixels; // mean over pixels of the absolute difference, relative to the whole
} Difference;

Difference picture_difference( const char* ours, const char* other, int columns, int rows );

// The mean over pixels and channels of a picture of the folder.
double picture_mean( const char* name );

// Renders SCENE.glb to SCENE.r.exr: the mean is that of Cycles in SCENE-1.exr to within these ratios. Both scatter by half a per cent.
void expect_cycles_mean( const char* scene, double least, double most );

#endif
