#include "support/convert_support.h"

#include "support/cli_run.h"
#include "support/encode_images.h"
#include "scene/gltf/gltf.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

int convert_enter( void** state )
{
    (void)state;
    cli_enter();
    return 0;
}

int convert_leave( void** state )
{
    (void)state;
    cli_leave();
    return 0;
}

void convert_write( const char* name, const char* text ) { cli_write( name, text, strlen( text ) ); }

bool convert_near( double a, double b ) { return fabs( a - b ) <= 1e-5 * ( 1.0 + fabs( b ) ); }

void convert_assert_point( const float* p, double x, double y, double z )
{
    if ( !convert_near( p[0], x ) || !convert_near( p[1], y ) || !convert_near( p[2], z ) )
        fail_msg( "wanted %g %g %g, got %g %g %g", x, y, z, (double)p[0], (double)p[1], (double)p[2] );
}

RfScene convert_load( const char* name )
{
    char path[256];
    RfScene scene;
    RfLog log = { 0 };
    RfError error;
    snprintf( path, sizeof path, "%s/%s", cli_folder(), name );
    if ( rf_load_gltf( path, &scene, &log, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return scene;
}

// Nothing but what the test wrote and the two files of cli_run.
void convert_assert_files( int count )
{
    int found = cli_count_files( "", "." );
    if ( found != count + 2 )
        fail_msg( "%d files instead of %d", found - 2, count );
}

static const char s_obj[] = "mtllib a.mtl\no floor\nv 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\n"
                            "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 0.75\nvn 0 0 1\n"
                            "usemtl wall\nf 1/1/1 2/2/1 3/3/1 4/4/1\n"
                            "usemtl lamp\nf 1 2 3\nusemtl glass\nf 1 2 3\nusemtl gold\nf 1 2 3\nl 1 2\n";
static const char s_mtl[] = "newmtl wall\nKd 0.5 0.25 0.125\nKs 0.5 0.5 0.5\nNs 30\nmap_Kd wall.png\n"
                            "newmtl lamp\nKd 0 0 0\nKe 12 6 3\n"
                            "newmtl glass\nKd 0 0 0\nKs 1 1 1\nTf 1 0.9 0.8\nNi 1.33\nillum 7\n"
                            "newmtl gold\nKd 0 0 0\nKs 0.9 0.7 0.25\nNs 30\n";

void convert_write_obj( void )
{
    static const uint8_t pixels[6] = { 255, 0, 0, 0, 0, 255 };
    size_t size;
    uint8_t* png = encode_png( 2, 1, 3, pixels, &size );
    cli_write( "wall.png", png, size );
    free( png );
    convert_write( "a.obj", s_obj );
    convert_write( "a.mtl", s_mtl );
}
