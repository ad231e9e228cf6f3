#include "support/gltf_checks.h"

#include "scene/gltf/gltf.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

GltfFolder gltf_folder;
char gltf_warnings[4096];

static void keep_warning( void* user, const char* line )
{
    (void)user;
    size_t used = strlen( gltf_warnings );
    snprintf( gltf_warnings + used, sizeof gltf_warnings - used, "%s\n", line );
}

RfScene gltf_load( const char* path )
{
    RfLog log = { .fn = keep_warning };
    RfScene scene;
    RfError error = { 0 };
    gltf_warnings[0] = 0;
    if ( rf_load_gltf( path, &scene, &log, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    assert_string_equal( scene.path, path );
    return scene;
}

RfScene gltf_load_built( GltfBuilder* b, const char* rest ) { return gltf_load( write_gltf( b, &gltf_folder, rest ) ); }

void gltf_assert_near( float got, double want )
{
    if ( ( fabs( (double)got - want ) <= 1e-6 * fmax( 1.0, fabs( want ) ) ) == false )
        fail_msg( "got %.9g, want %.9g", (double)got, want );
}

void gltf_assert_three( const float* got, double x, double y, double z )
{
    gltf_assert_near( got[0], x );
    gltf_assert_near( got[1], y );
    gltf_assert_near( got[2], z );
}

void gltf_assert_rgb( RfVec3 got, double r, double g, double b ) { gltf_assert_three( &got.x, r, g, b ); }

void gltf_assert_corner( const RfScene* scene, int corner, double x, double y, double z )
{
    gltf_assert_three( scene->triangles.positions + 3 * (size_t)scene->triangles.indices[corner], x, y, z );
}

void gltf_assert_normal( const RfScene* scene, int corner, double x, double y, double z )
{
    gltf_assert_three( scene->triangles.normals + 3 * (size_t)scene->triangles.indices[corner], x, y, z );
}

void gltf_assert_warned( const char* text )
{
    if ( strstr( gltf_warnings, text ) == NULL )
        fail_msg( "no warning has '%s': %s", text, gltf_warnings );
}

int gltf_enter( void** state )
{
    (void)state;
    gltf_folder = make_folder();
    return 0;
}

int gltf_leave( void** state )
{
    (void)state;
    remove_folder( &gltf_folder );
    return 0;
}
