// The report page in headless Chromium, by tests/browser/check-page.js: it loads, plays,
// seeks and logs nothing to the console. Skipped without Chromium, Node.js or playwright-
// core, which scripts/install-packages --browser installs.
#include "support/cli_run.h"
#include "support/test.h"
#include "image/exr.h"

#include <unistd.h>

#ifdef REFRAME_SANITIZED
#define FRAMES 12
#else
#define FRAMES 48
#endif

// Enough for a busy machine; what a free one takes is in the README.
#define SECONDS "30"

#define CHECK                                                                                                                    \
    "REFRAME_NODE_MODULES='" REFRAME_SOURCE_DIR "/out/browser/node_modules' node '" REFRAME_SOURCE_DIR                           \
    "/tests/browser/check-page.js' "

// A ball of light that moves over a ramp, with noise of its own in each frame.
static void write_frame( const char* name, int width, int height, int frame, float noise )
{
    AUTO_IMAGE image;
    RfError error = { 0 };
    assert_int_equal( rf_create_image( width, height, &image, &error ), RF_OK );
    uint32_t seed = 12345u + (uint32_t)frame;
    for ( int i = 0; i < 3 * width * height; ++i )
    {
        seed = seed * 1664525u + 1013904223u;
        float x = (float)( i / 3 % width ) / (float)width, y = (float)( i / 3 / width ) / (float)width;
        float dx = x - 0.1f - 0.016f * (float)frame, dy = y - 0.3f;
        float light = 0.02f + 0.6f * x * x + ( dx * dx + dy * dy < 0.004f ? 20.0f : 0.0f );
        image.rgb[i] = light * ( 1.0f + noise * ( (float)( seed >> 8 ) * 0x1p-24f - 0.5f ) );
    }
    RfExrOptions options = rf_default_exr_options();
    options.compression = RF_EXR_NONE;
    if ( rf_write_exr( cli_path( name ), &image, &options, &error ) != RF_OK )
        fail_msg( "%s", error.text );
}

static void write_sequence( const char* folder, int width, int height, int count, float noise )
{
    char name[128];
    cli_expect( cli_run( "mkdir -p '%s'", folder ), 0, NULL );
    for ( int frame = 1; frame <= count; ++frame )
    {
        snprintf( name, sizeof name, "%s/f.%04d.exr", folder, frame );
        write_frame( name, width, height, frame, noise );
    }
}

// Columns, 8 pixels wide, of two brightnesses.
static void write_columns( const char* name, float a, float b )
{
    AUTO_IMAGE image;
    RfError error = { 0 };
    assert_int_equal( rf_create_image( 160, 90, &image, &error ), RF_OK );
    for ( int i = 0; i < 3 * 160 * 90; ++i )
        image.rgb[i] = i / 3 % 160 / 8 % 2 == 0 ? a : b;
    RfExrOptions options = rf_default_exr_options();
    assert_int_equal( rf_write_exr( cli_path( name ), &image, &options, &error ), RF_OK );
}

// False where there is no browser; fails where a check does. `more`: options.
static bool check_page( const char* page, const char* more )
{
    if ( cli_run( "command -v node > /dev/null" )->status != 0 )
    {
        print_message( "skipped: there is no Node.js: scripts/install-packages --browser gets it\n" );
        return false;
    }
    const CliResult* result = cli_run( CHECK "%s --seconds " SECONDS " %s", page, more );
    print_message( "%s", result->out );
    if ( result->status != 0 && result->status != 77 )
        fail_msg( "%s: %d\n%s", page, result->status, result->err );
    return result->status == 0;
}

TEST( test_full_size_loads_and_plays )
{
    write_sequence( "big", 960, 540, FRAMES, 0.2f );
    cli_expect( cli_run( "$R report big -o big.html --quiet" ), 0, NULL );
    size_t size;
    free( cli_read( "big.html", &size ) );
    assert_true( size < 40000000 );
    if ( !check_page( "big.html", "--quick" ) )
        skip();
}

// Side by side, with a reference, a frame that is missing, names of any kind.
TEST( test_side_by_side_with_holes_and_names )
{
    write_sequence( "a</script>&", 96, 54, 6, 0.3f );
    write_sequence( "b", 90, 60, 6, 0.1f );
    write_sequence( "r", 96, 54, 6, 0.0f );
    cli_expect( cli_run( "rm 'a</script>&/f.0004.exr'; $R report 'a</script>&' --reference r -o with.html --quiet" ), 0, NULL );
    cli_expect( cli_run( "$R report 'a</script>&' b -o two.html --values 40K --quiet" ), 0, NULL );
    cli_expect( cli_run( "$R report b/f.0001.exr -o one.html --quiet" ), 0, NULL );
    if ( !check_page( "with.html", "--quick" ) || !check_page( "two.html", "--coarse" ) || !check_page( "one.html", "" ) )
        skip();
}

// A frame with passes of many kinds, and one pixel whose values a half float holds.
static void write_full_frame( const char* folder, int frame, float light )
{
    enum
    {
        WIDTH = 96,
        HEIGHT = 54,
        COUNT = 24
    };
    static const char* const names[COUNT] = { "albedo.R",         "albedo.G",         "albedo.B",         "normal.X",
                                              "normal.Y",         "normal.Z",         "depth.Z",          "motion.X",
                                              "motion.Y",         "motion.Z",         "variance.R",       "variance.G",
                                              "variance.B",       "samples.Y",        "light_key.R",      "light_key.G",
                                              "light_key.B",      "light_fill.R",     "light_fill.G",     "light_fill.B",
                                              "CryptoObject00.R", "CryptoObject00.G", "CryptoObject00.B", "CryptoObject00.A" };
    static float values[WIDTH * HEIGHT][COUNT];
    RfExrChannel channels[COUNT];
    AUTO_IMAGE image;
    RfError error = { 0 };
    char path[512];
    snprintf( path, sizeof path, "%s/%s/f.%04d.exr", cli_folder(), folder, frame );
    assert_int_equal( rf_create_image( WIDTH, HEIGHT, &image, &error ), RF_OK );
    for ( int i = 0; i < WIDTH * HEIGHT; ++i )
    {
        float x = (float)( i % WIDTH ) / WIDTH, y = (float)( i / WIDTH ) / HEIGHT, t = 0.1f * (float)frame;
        const float at[COUNT] = { x,        y,     0.5f, 0.6f * x, 0.6f * y, 0.8f, 2.0f + 5.0f * y,
                                  x - 0.5f, y + t, 0.0f, x * y,    x,        y,    3.0f + x };
        memcpy( values[i], at, sizeof at );
        for ( int c = 0; c < 3; ++c )
        {
            values[i][14 + c] = light * ( 0.1f + x * y );
            values[i][17 + c] = light * 0.2f * t * (float)c;
            image.rgb[3 * i + c] = values[i][14 + c] + values[i][17 + c]; // the picture is the sum of the groups
        }
    }
    // "left" and "right" of column 40, the first column is nothing
    const uint32_t bits[2] = { 0x3f2a91c4u, 0x40b37e05u };
    for ( int i = 0; i < WIDTH * HEIGHT; ++i )
    {
        memcpy( &values[i][20], bits + ( i % WIDTH >= 40 ), i % WIDTH > 0 ? sizeof *bits : 0 );
        values[i][21] = i % WIDTH > 0 ? 1.0f : 0.0f;
    }
    const RfExrString strings[] = { { "cryptomatte/1234567/name", "CryptoObject" },
                                    { "cryptomatte/1234567/manifest", "{\"left\":\"3f2a91c4\",\"right\":\"40b37e05\"}" } };
    image.rgb[3 * ( 20 * WIDTH + 10 )] = 0.25f;
    image.rgb[3 * ( 20 * WIDTH + 10 ) + 1] = 12.5f;
    image.rgb[3 * ( 20 * WIDTH + 10 ) + 2] = -0.0625f;
    for ( int c = 0; c < COUNT; ++c )
        channels[c] = ( RfExrChannel ){ .name = names[c], .values = &values[0][c], .stride = COUNT };
    RfExrOptions options = rf_default_exr_options();
    options.channels = channels;
    options.channel_count = COUNT;
    options.strings = strings;
    options.string_count = 2;
    if ( rf_write_exr( path, &image, &options, &error ) != RF_OK )
        fail_msg( "%s", error.text );
}

// AOVs, wipe, probe, on a desk and on a phone.
TEST( test_everything_that_a_page_has )
{
    static const char render[] =
        "{\"frames\":[{\"frame\":1,\"seconds\":%d},{\"frame\":2,\"seconds\":%d},{\"frame\":3,\"seconds\":%d}],\"seconds\":9,"
        "\"threads\":2,\"rays\":{}}";
    static const char* const folders[3] = { "fast", "slow", "true" };
    char text[1024];
    for ( int k = 0; k < 3; ++k )
    {
        cli_expect( cli_run( "mkdir %s", folders[k] ), 0, NULL );
        for ( int frame = 1; frame <= 3; ++frame )
            write_full_frame( folders[k], frame, k == 0 ? 1.01f : k == 1 ? 1.1f : 1.0f );
        int length = snprintf( text, sizeof text, render, 1 + k, 1 + k, 1 + k );
        snprintf( text + 512, 512, "%s/r.json", folders[k] );
        cli_write( text + 512, text, (size_t)length );
    }
    cli_expect( cli_run( "$R report fast slow --reference true -o full.html --quiet" ), 0, NULL );
    if ( !check_page( "full.html",
                      "--probe 10,20:0.25,12.5,-0.0625 --mattes 'left@39,20;right@40,20;nothing@0,53;right@95,53'" ) )
        skip();
}

// What the browser paints is the sRGB curve of the light: of 0.5 it is 187.5, of
// columns of 0.1 and 0.8 the mean of 89.0 and 231.1, two stops darker of 43.8 and 123.6.
TEST( test_brightness_is_the_srgb_curve )
{
    write_columns( "flat.exr", 0.5f, 0.5f );
    write_columns( "columns.exr", 0.1f, 0.8f );
    cli_expect( cli_run( "$R report flat.exr -o flat.html --quiet && $R report columns.exr -o columns.html --quiet && "
                         "$R report columns.exr -o darker.html --exposure -2 --quiet && "
                         "$R report columns.exr -o agx.html --view agx --quiet" ),
                0, NULL );
    if ( !check_page( "flat.html", "--mean 187.5 --quick" ) || !check_page( "columns.html", "--mean 160.1 --quick" ) ||
         !check_page( "darker.html", "--mean 83.7 --quick" ) || !check_page( "agx.html", "--quick" ) )
        skip();
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
