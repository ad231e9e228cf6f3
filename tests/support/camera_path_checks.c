#include "support/camera_path_checks.h"

#include "support/cli_run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static RfResult load( const char* text, RfCamera* camera, RfError* error )
{
    char path[256];
    cli_write( "path.json", text, strlen( text ) );
    snprintf( path, sizeof path, "%s/path.json", cli_folder() );
    return rf_load_camera( path, camera, error );
}

RfCamera load_path( const char* text )
{
    RfCamera camera;
    RfError error = { 0 };
    if ( load( text, &camera, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return camera;
}

void expect_path_fault( const char* text, const char* part )
{
    RfCamera camera;
    RfError error = { 0 };
    RfResult result = load( text, &camera, &error );
    rf_destroy_camera( &camera );
    if ( result == RF_OK || strstr( error.text, part ) == NULL || strchr( error.text, '\n' ) != NULL ||
         strstr( error.text, "/path.json: " ) == NULL )
        fail_msg( "'%s' gave '%s' instead of '%s'", text, result == RF_OK ? "no error" : error.text, part );
    RfResult again = load( text, &camera, NULL ); // the report may be NULL
    assert_int_equal( again, result );
}

RfView view_at( const RfCamera* camera, double time )
{
    RfView view;
    RfError error = { 0 };
    if ( rf_sample_camera_track( camera->track, time, &view, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return view;
}

void assert_close( double got, double want, double tolerance )
{
    if ( !( fabs( got - want ) <= tolerance ) )
        fail_msg( "got %.17g, wanted %.17g to within %g", got, want, tolerance );
}

void assert_three( const double got[3], double x, double y, double z, double tolerance )
{
    assert_close( got[0], x, tolerance );
    assert_close( got[1], y, tolerance );
    assert_close( got[2], z, tolerance );
}
