// reframe render --aov as a user sees it: the channels in the files, and what is refused.
#include "support/cli_run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "image/exr.h"

#define ALL "albedo,normal,depth,motion,variance,samples"
#define SMALL "--size 48x27 --spp 6 --group 1 --frames 10-11 --quiet"

// One channel of a frame, to be freed; NULL where it has none.
static float* channel_of( const char* name, const char* channel, int width, int height )
{
    char path[512];
    snprintf( path, sizeof path, "%s/%s", cli_folder(), name );
    float* values;
    RfExrWindow window;
    RfError error;
    if ( rf_read_exr_channels( path, &channel, 1, &window, &values, &error ) != RF_OK )
    {
        assert_non_null( strstr( error.text, channel ) );
        return NULL;
    }
    assert_true( window.width == width && window.height == height );
    return values;
}

static void test_every_channel_is_written( void** state )
{
    (void)state;
    static const char* const names[] = { "albedo.R",   "albedo.G",   "albedo.B",  "normal.X", "normal.Y", "normal.Z",
                                         "depth.Z",    "motion.X",   "motion.Y",  "motion.Z", "motion.W", "variance.R",
                                         "variance.G", "variance.B", "samples.Y", "R",        "G",        "B" };
    cli_expect( cli_run( "$R render $VASE -o a/f.####.exr " SMALL " --aov " ALL ), 0, NULL );
    for ( size_t i = 0; i < sizeof names / sizeof names[0]; ++i )
    {
        float* values = channel_of( "a/f.0010.exr", names[i], 48, 27 );
        assert_non_null( values );
        double sum = 0.0;
        for ( int k = 0; k < 48 * 27; ++k )
        {
            assert_true( isfinite( values[k] ) );
            sum += fabs( (double)values[k] );
        }
        if ( !( sum > 0.0 ) )
            fail_msg( "%s is 0 everywhere", names[i] );
        free( values );
    }
    assert_null( channel_of( "a/f.0010.exr", "alpha.A", 48, 27 ) );
    // the colour is what it is without, and other commands find it
    cli_expect( cli_run( "$R render $VASE -o b/f.####.exr " SMALL ), 0, NULL );
    const CliResult* result = cli_run( "$R compare a/f.####.exr b/f.####.exr --json -" );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->out, "\"max\": 0.0" ) );
    cli_expect( cli_run( "$R png a/f.0010.exr a.png" ), 0, NULL );
    // threads and frames alone make no difference to the bytes
    cli_expect(
        cli_run( "$R render $VASE -o c/f.####.exr --threads 3 --size 48x27 --spp 6 --group 1 --frames 11 --quiet --aov " ALL ), 0,
        NULL );
    cli_expect( cli_run( "cmp a/f.0011.exr c/f.0011.exr" ), 0, NULL );
    // only what was asked for
    cli_expect( cli_run( "$R render $VASE -o d/f.####.exr " SMALL " --aov depth --float" ), 0, NULL );
    float* depth = channel_of( "d/f.0010.exr", "depth.Z", 48, 27 );
    assert_true( depth != NULL && depth[0] > 0.1f && depth[0] < 100.0f );
    free( depth );
    assert_null( channel_of( "d/f.0010.exr", "albedo.R", 48, 27 ) );
}

static void test_wrong_names_are_refused( void** state )
{
    (void)state;
    cli_expect(
        cli_run( "$R render $VASE -o r.exr --aov colour" ), 2,
        "reframe render: --aov: 'colour' is no AOV, there are albedo,normal,depth,motion,variance,samples,removed,primal,dx,dy" );
    cli_expect( cli_run( "$R render $VASE -o r.exr --aov depth,normals" ), 2, "did you mean normal?" );
    cli_expect( cli_run( "$R render $VASE -o r.exr --aov depth,,normal" ), 2, "'' is no AOV" );
    cli_expect( cli_run( "$R render $VASE -o r.exr --aov depth," ), 2, "'' is no AOV" );
    cli_expect( cli_run( "$R render $VASE -o r.exr --aov ''" ), 2, "--aov" );
    cli_expect( cli_run( "$R render $VASE -o r.exr --aov depth,normal,depth" ), 2, "--aov: AOV depth is given twice" );
    assert_false( cli_exists( "r.exr" ) );
}

static void test_resume_wants_the_same_aovs( void** state )
{
    (void)state;
    cli_expect( cli_run( "$R render $VASE -o s/f.####.exr " SMALL " --aov depth,albedo" ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o s/f.####.exr " SMALL " --resume --aov albedo,depth" ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o s/f.####.exr " SMALL " --resume" ), 1, "--resume: s/f.0010.exr" );
    cli_expect( cli_run( "$R render $VASE -o s/f.####.exr " SMALL " --resume --aov albedo" ), 1, "--resume: s/f.0010.exr" );
    cli_expect( cli_run( "$R render $VASE -o b/f.####.exr " SMALL " --resume --aov depth" ), 1, "--resume: b/f.0010.exr" );
}

static void test_variance_of_one_pass( void** state )
{
    (void)state;
    const CliResult* result =
        cli_run( "$R render $VASE -o v.exr --size 8x6 --spp 1 --group 0 --frames 3 --quiet --aov variance" );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->err, "warning: --aov variance: will be 0 in frame 3" ) );
    float* values = channel_of( "v.exr", "variance.G", 8, 6 );
    for ( int i = 0; i < 48; ++i )
        assert_true( values[i] == 0.0f );
    free( values );
    result = cli_run( "$R render $VASE -o w.exr --size 8x6 --spp 2 --group 0 --frames 3 --quiet --aov variance" );
    cli_expect( result, 0, NULL );
    assert_string_equal( result->err, "" );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_every_channel_is_written ),
        cmocka_unit_test( test_wrong_names_are_refused ),
        cmocka_unit_test( test_resume_wants_the_same_aovs ),
        cmocka_unit_test( test_variance_of_one_pass ),
    };
    return cmocka_run_group_tests_name( "aov", tests, cli_enter_group, cli_leave_group );
}
