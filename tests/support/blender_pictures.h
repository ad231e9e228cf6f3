// Scenes that are made inside Blender and rendered by both: the means of their pictures, and what the exporter says.
#ifndef REFRAME_TESTS_BLENDER_PICTURES_H
#define REFRAME_TESTS_BLENDER_PICTURES_H

#include "support/blender_run.h"
#include "support/test.h"

#include "gltf/gltf.h"
#include "reframe/image.h"
#include "scene/scene.h"

#include <string.h>

#define EXPORT( scene )                                                                                                          \
    BLENDER scene ".blend -P " REFRAME_SOURCE_DIR "/scripts/blender/export.py -- " scene ".glb --bake-cache cache "

static inline double mean_of( const char* name )
{
    char path[512];
    snprintf( path, sizeof path, "%s/%s", cli_folder(), name );
    RfImage image;
    RfError error = { .code = RF_OK };
    if ( rf_read_exr( path, &image, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    double sum = 0.0;
    int count = 3 * image.width * image.height;
    for ( int i = 0; i < count; ++i )
        sum += (double)image.rgb[i];
    rf_destroy_image( &image );
    return sum / count;
}

static inline double cycles_mean( const char* scene )
{
    char name[80];
    snprintf( name, sizeof name, "%s.mean", scene );
    size_t size;
    char* text = cli_read( name, &size );
    double sum = 0.0;
    char* at = text;
    for ( int i = 0; i < 3; ++i )
        sum += strtod( at, &at );
    free( text );
    assert_true( sum > 0.0 );
    return sum / 3.0;
}

static inline void load( const char* name, RfScene* scene )
{
    char path[512];
    snprintf( path, sizeof path, "%s/%s", cli_folder(), name );
    RfError error;
    RfLog log = { 0 };
    if ( rf_load_gltf( path, scene, &log, &error ) != RF_OK )
        fail_msg( "%s", error.text );
}

static inline const RfMaterial* find_material( const RfScene* scene, const char* name )
{
    for ( uint32_t i = 0; i < scene->material_count; ++i )
    {
        if ( strcmp( scene->materials[i].name, name ) == 0 )
            return scene->materials + i;
    }
    fail_msg( "there is no material '%s'", name );
    return NULL;
}

#define SIZE "24x18"

// The means of both pictures scatter by half a per cent.
static inline void compare( const char* scene, double least, double most )
{
    cli_expect( cli_run( "$R render %s.glb -o %s.r.exr --size " SIZE
                         " --spp 256 --group 0 --tile 1 --max-depth 26 --float --quiet",
                         scene, scene ),
                0, NULL );
    char name[80];
    snprintf( name, sizeof name, "%s.r.exr", scene );
    double ratio = mean_of( name ) / cycles_mean( scene );
    print_message( "%s: %.4f of Cycles\n", scene, ratio );
    if ( ratio < least || ratio > most )
        fail_msg( "%s: the mean is %.4f of Cycles'", scene, ratio );
}

static inline void expect_line( const char* text, const char* part )
{
    if ( strstr( text, part ) == NULL )
        fail_msg( "does not say: %s\n%s", part, text );
}

#endif
