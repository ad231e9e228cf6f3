// Cameras out of Blender see what Cycles sees: with depth of field, orthographic and panoramic. The mean of the picture is
// that of Cycles within 1 %, and so, within their noise, are the means of its parts. Skipped where Blender is missing.
#include "support/blender_run.h"
#include "support/test.h"

#include "reframe/image.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define WIDTH 96
#define HEIGHT 54
#define BLOCK_WIDTH 12
#define BLOCK_HEIGHT 9

static RfImage read_picture( const char* name )
{
    char path[512];
    RfImage image;
    RfError error;
    snprintf( path, sizeof path, "%s/%s", cli_folder(), name );
    if ( rf_read_exr( path, &image, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    assert_int_equal( image.width, WIDTH );
    assert_int_equal( image.height, HEIGHT );
    return image;
}

// The mean over the channels of a rectangle.
static double mean_of( const RfImage* image, int x0, int y0, int width, int height )
{
    double sum = 0.0;
    for ( int y = y0; y < y0 + height; ++y )
    {
        for ( int i = 3 * x0; i < 3 * ( x0 + width ); ++i )
            sum += (double)image->rgb[3 * (size_t)y * WIDTH + (size_t)i];
    }
    return sum / ( 3.0 * width * height );
}

typedef struct Difference
{
    double mean;   // of the whole picture, relative
    double blocks; // root of the mean square over blocks, relative to the whole
    double pixels; // mean over pixels of the absolute difference, likewise
} Difference;

static Difference compare( const char* ours, const char* cycles )
{
    RfImage a = read_picture( ours ), b = read_picture( cycles );
    double whole = mean_of( &b, 0, 0, WIDTH, HEIGHT ), square = 0.0, pixels = 0.0;
    for ( int y = 0; y < HEIGHT; y += BLOCK_HEIGHT )
    {
        for ( int x = 0; x < WIDTH; x += BLOCK_WIDTH )
        {
            double off = mean_of( &a, x, y, BLOCK_WIDTH, BLOCK_HEIGHT ) - mean_of( &b, x, y, BLOCK_WIDTH, BLOCK_HEIGHT );
            square += off * off * ( BLOCK_WIDTH * BLOCK_HEIGHT ) / ( WIDTH * HEIGHT );
        }
    }
    for ( size_t i = 0; i < 3 * WIDTH * HEIGHT; ++i )
        pixels += fabs( (double)a.rgb[i] - (double)b.rgb[i] ) / ( 3.0 * WIDTH * HEIGHT );
    Difference d = { mean_of( &a, 0, 0, WIDTH, HEIGHT ) / whole - 1.0, sqrt( square ) / whole, pixels / whole };
    printf( "%s against %s: mean %+.4f, blocks %.4f, pixels %.4f\n", ours, cycles, d.mean, d.blocks, d.pixels );
    fflush( stdout ); // or children print it again
    rf_destroy_image( &a );
    rf_destroy_image( &b );
    return d;
}

static void render_camera( const char* name )
{
    const CliResult* done = cli_run(
        BLENDER "cameras.blend -P " REFRAME_SOURCE_DIR "/scripts/blender/export.py -- %s.glb --camera %s > log", name, name );
    assert_int_equal( done->status, 0 );
    assert_non_null( strstr( done->err, "warning: the film's exposure of 2 is taken as one of the view" ) );
    assert_non_null( strstr( done->err, "warning: the compositor's nodes are left out" ) );
    assert_non_null( strstr( done->err, "warning: stereoscopy is left out" ) );
    assert_null( strstr( done->err, "the shutter's curve" ) );
    cli_expect(
        cli_run( "$R render %s.glb -o %s-ours.exr --spp 128 --tile 3x3 --no-adaptive --max-depth 4 --float > log", name, name ),
        0, NULL );
}

TEST( test_cameras_see_what_cycles_sees )
{
    if ( !enter_with_blender() )
        skip();
    cli_expect( cli_run( BLENDER "--python-exit-code 9 -P " REFRAME_SOURCE_DIR "/tests/support/blender_cameras.py > log 2>&1" ),
                0, NULL );
    static const char* const s_names[] = { "Lens", "Flat", "Round" };
    for ( int i = 0; i < 3; ++i )
    {
        char ours[32], cycles[32];
        snprintf( ours, sizeof ours, "%s-ours.exr", s_names[i] );
        snprintf( cycles, sizeof cycles, "%s.exr", s_names[i] );
        render_camera( s_names[i] );
        Difference d = compare( ours, cycles );
        assert_true( fabs( d.mean ) < 0.01 );
        assert_true( d.blocks < 0.012 );
        assert_true( d.pixels < 0.045 );
    }
    // the picture without the lens is another
    Difference sharp = compare( "Lens-ours.exr", "Sharp.exr" );
    assert_true( sharp.pixels > 0.055 );
    cli_leave();
}
