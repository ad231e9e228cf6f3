// Every compression, in one part and in several, of halves and of floats: read back by OpenEXR's C++ library and opened by its
// tools, where they are there. What is no colour survives DWA bit by bit.
#include "image/exr.h"
#include "image/half.h"
#include "support/image_support.h"
#include "support/openexr_file.h"
#include "support/test.h"

#include <sys/wait.h>

#define WIDTH 75
#define HEIGHT 67
#define PIXELS ( WIDTH * HEIGHT )
#define CHANNELS 16

typedef struct Channel
{
    const char *name, *part;
    bool half, lossy; // as a render with half floats writes it
} Channel;

// R, G, B, which come first in a file, and passes of all kinds, with names that DWA takes for colours.
static const Channel s_channels[CHANNELS] = {
    { "R", NULL, true, true },
    { "G", NULL, true, true },
    { "B", NULL, true, true },
    { "A", NULL, true, false },
    { "albedo.R", "albedo", true, true },
    { "albedo.G", "albedo", true, true },
    { "albedo.B", "albedo", true, true },
    { "normal.X", "normal", true, false },
    { "normal.Y", "normal", true, false },
    { "depth.Z", "depth", false, false },
    { "samples.Y", "samples", false, false },
    { "motion.X", "motion", false, false },
    { "CryptoObject00.R", "CryptoObject00", false, false },
    { "CryptoObject00.G", "CryptoObject00", false, false },
    { "CryptoObject00.B", "CryptoObject00", false, false },
    { "CryptoObject00.A", "CryptoObject00", false, false },
};

static float s_values[CHANNELS][PIXELS];
static float s_rgb[3 * PIXELS];

// Smooth colours with edges, bright specks and negative values; numbers with all their bits, as of hashes.
static void fill_values( void )
{
    uint32_t seed = 12345;
    for ( int c = 0; c < CHANNELS; ++c )
    {
        for ( int i = 0; i < PIXELS; ++i )
        {
            uint32_t bits = next_random( &seed );
            float x = (float)( i % WIDTH ), y = (float)( i / WIDTH ), noise = (float)( bits >> 8 ) * 0x1p-24f;
            float colour = 0.3f + 0.3f * sinf( 0.1f * x + (float)c ) + ( y > 30.0f ? 0.8f : 0.0f ) + 0.05f * noise;
            colour *= bits % 251 == 0 ? 900.0f : bits % 97 == 0 ? -1.0f : 1.0f;
            bits = ( bits & 0x807fffffu ) | ( 1u + bits % 253u ) << 23; // no NaN, nothing infinite or subnormal
            memcpy( &s_values[c][i], &bits, sizeof bits );
            if ( s_channels[c].half )
                s_values[c][i] = s_channels[c].lossy ? colour : rf_half_to_float( (uint16_t)( bits % 0x7c00u ) );
        }
    }
    for ( int i = 0; i < 3 * PIXELS; ++i )
        s_rgb[i] = s_values[i % 3][i / 3];
}

static RfResult write_all( const char* path, RfExrCompression compression, float level, bool parts, bool half, RfError* error )
{
    RfImage image = { WIDTH, HEIGHT, s_rgb };
    RfExrChannel channels[CHANNELS - 3];
    RfExrOptions options = rf_default_exr_options();
    for ( int c = 3; c < CHANNELS; ++c )
        channels[c - 3] = ( RfExrChannel ){
            .name = s_channels[c].name,
            .values = s_values[c],
            .stride = 1,
            .half = half && s_channels[c].half,
            .lossy = s_channels[c].lossy,
            .part = parts ? s_channels[c].part : NULL,
        };
    options.compression = compression;
    options.dwa_level = level;
    options.half = half;
    options.x = -3;
    options.y = 9;
    options.channels = channels;
    options.channel_count = CHANNELS - 3;
    return rf_write_exr( path, &image, &options, error );
}

static bool is_dwa( RfExrCompression compression ) { return compression == RF_EXR_DWAA || compression == RF_EXR_DWAB; }

static double scale( double value )
{
    double size = fabs( value );
    return copysign( size > 1.0 ? 1.0 + log( size ) / 2.2 : pow( size, 1.0 / 2.2 ), value );
}

// The errors of a colour are within the bound of reframe/image.h, and without loss none.
static void check_colour( const float* read, int c, double level, bool half )
{
    double errors = 0.0, values = 0.0;
    for ( int i = 0; i < PIXELS; ++i )
    {
        double value = (double)s_values[c][i], error = scale( (double)read[i] ) - scale( value );
        if ( level < 0.0 )
            assert_true( fabs( (double)read[i] - value ) <= ( half ? 0x1p-11 * fabs( value ) + 0x1p-25 : 0.0 ) );
        errors += error * error;
        values += scale( value ) * scale( value );
    }
    double root = sqrt( errors / PIXELS ), roundings = 6.0 * 0x1p-11 * sqrt( values / PIXELS );
    if ( level >= 0.0 )
        assert_true( root <= 16.6e-5 * level + roundings + 1e-4 );
    if ( level >= 45.0 ) // the level is used
        assert_true( root > 2e-5 * level );
}

static void check_file( const char* path, double level, bool half )
{
    static float library[PIXELS];
    for ( int c = 0; c < CHANNELS; ++c )
    {
        RfExrWindow window;
        RfError error;
        AUTO_FREE float* ours = NULL;
        assert_int_equal( rf_read_exr_channels( path, &s_channels[c].name, 1, &window, &ours, &error ), RF_OK );
        assert_true( window.x == -3 && window.y == 9 && window.width == WIDTH && window.height == HEIGHT );
#ifdef REFRAME_DWA
        assert_true( read_by_openexr( path, s_channels[c].name, WIDTH, HEIGHT, library ) );
        assert_memory_equal( library, ours, sizeof library );
#else
        memcpy( library, ours, sizeof library );
#endif
        if ( s_channels[c].lossy )
            check_colour( library, c, level, half );
        else
            assert_memory_equal( library, s_values[c], sizeof library );
    }
}

// Runs a tool of OpenEXR on a file; true where it is not there.
static bool run_tool( const char* tool, const char* arguments, const char* wanted )
{
    char line[1024];
    snprintf( line, sizeof line, "command -v %s >/dev/null || exit 77; %s %s >%s 2>&1", tool, tool, arguments,
              cli_path( "tool.txt" ) );
    int status = system( line );
    size_t size;
    if ( WIFEXITED( status ) && WEXITSTATUS( status ) == 77 )
        return true;
    AUTO_FREE char* text = cli_read( "tool.txt", &size );
    text[size] = '\0';
    bool works = strstr( text, "ERROR" ) == NULL && ( wanted == NULL || strstr( text, wanted ) != NULL );
    // exrinfo 3.1.5 leaves with any status
    works = works && ( strcmp( tool, "exrinfo" ) == 0 ? WIFEXITED( status ) : status == 0 );
    if ( !works )
        print_error( "%s\n%s\n", line, text );
    return works;
}

static void check_tools( const char* path, RfExrCompression compression, bool parts )
{
    char arguments[800];
    static const char* const names[] = { "none", "zip,", "piz", "zip,", "dwa", "dwa" };
    assert_true( run_tool( "exrheader", path, names[compression] ) );
    assert_true( run_tool( "exrheader", path, parts ? "CryptoObject00.G, 32-bit" : "samples.Y, 32-bit" ) );
    snprintf( arguments, sizeof arguments, "-s -v %s", path );
    assert_true( run_tool( "exrinfo", arguments, rf_compression_words[compression] ) );
    snprintf( arguments, sizeof arguments, "-separate -i %s -o %s -override 1", path, cli_path( "piece" ) );
    if ( parts )
        assert_true( run_tool( "exrmultipart", arguments, NULL ) );
}

TEST( test_each_is_read_by_openexr )
{
    fill_values();
    for ( int way = 0; rf_compression_words[way / 4] != NULL; ++way )
    {
        RfExrCompression compression = (RfExrCompression)( way / 4 );
        bool parts = way % 2 == 1, half = way / 2 % 2 == 0;
        double level = way % 4 == 1 ? 100.0 : 45.0;
        RfError error = { 0 };
        if ( is_dwa( compression ) && !rf_has_dwa() )
            continue;
        RfResult result = write_all( cli_path( "all.exr" ), compression, (float)level, parts, half, &error );
        if ( is_dwa( compression ) && !parts && !half ) // R of the colour and of the hash
        {
            assert_int_equal( result, RF_ERROR_USAGE );
            assert_non_null(
                strstr( error.text, "DWA cannot keep CryptoObject00.B as it is in one part with B, both of 32 bits" ) );
            continue;
        }
        if ( result != RF_OK )
            fail_msg( "%s", error.text );
        check_file( cli_path( "all.exr" ), is_dwa( compression ) ? level : -1.0, half );
        check_tools( cli_path( "all.exr" ), compression, parts );
    }
}

#ifdef REFRAME_DWA
// Files of other programs, with tiles that are higher than the chunks of lines.
TEST( test_foreign_dwa_is_read )
{
    fill_values();
    static const char* const names[] = { "Z", "R", "G", "B" };
    static float library[PIXELS];
    for ( int way = 0; way < 4; ++way )
    {
        const char* path = cli_path( "foreign.exr" );
        assert_true( write_by_openexr( path, WIDTH, HEIGHT, s_rgb, way % 2 == 1, way / 2 == 1 ) );
        for ( int c = 0; c < 4; ++c )
        {
            RfExrWindow window;
            RfError error;
            AUTO_FREE float* ours = NULL;
            assert_int_equal( rf_read_exr_channels( path, names + c, 1, &window, &ours, &error ), RF_OK );
            assert_true( read_by_openexr( path, names[c], WIDTH, HEIGHT, library ) );
            assert_memory_equal( library, ours, sizeof library );
            for ( int i = 0; i < PIXELS && c == 0; ++i )
                assert_true( ours[i] == s_rgb[3 * i] ); // Z is kept
        }
    }
}

// Nothing that a pixel may hold ends as an infinite value, or as 0 in silence.
TEST( test_extreme_colours_and_dwa )
{
    RfImage image = make_image( 64, 64, 5 ), back;
    RfExrOptions options = rf_default_exr_options();
    RfError error;
    for ( int i = 0; i < 3 * 64 * 64; ++i )
        image.rgb[i] = i % 5 == 0 ? 1e9f : i % 7 == 0 ? -65504.0f : i % 3 == 0 ? 29999.0f : 0.0f;
    for ( int way = 0; way < 4; ++way )
    {
        options.compression = way % 2 == 0 ? RF_EXR_DWAA : RF_EXR_DWAB;
        options.dwa_level = way / 2 == 0 ? 45.0f : RF_EXR_MAX_DWA_LEVEL;
        back = write_and_read( "bright.exr", &image, &options );
        for ( int i = 0; i < 3 * 64 * 64; ++i )
            assert_true( fabsf( back.rgb[i] ) <= 65504.0f );
        rf_destroy_image( &back );
    }
    int before = cli_count_files( "", "." );
    for ( int way = 0; way < 2; ++way )
    {
        image.rgb[4000] = way == 0 ? NAN : -INFINITY;
        assert_int_equal( rf_write_exr( cli_path( "nan.exr" ), &image, &options, &error ), RF_ERROR_USAGE );
        assert_non_null( strstr( error.text, "NaN or infinite values, which DWA would turn to 0" ) );
    }
    image.rgb[4000] = 0.0f;
    options.dwa_level = RF_EXR_MAX_DWA_LEVEL + 1.0f;
    assert_int_equal( rf_write_exr( cli_path( "nan.exr" ), &image, &options, &error ), RF_ERROR_USAGE );
    options.dwa_level = NAN;
    assert_int_equal( rf_write_exr( cli_path( "nan.exr" ), &image, &options, &error ), RF_ERROR_USAGE );
    assert_int_equal( cli_count_files( "", "." ), before );
    rf_destroy_image( &image );
}

// Changed and cut-off bytes end in an image or in one line.
TEST( test_broken_dwa_is_one_line )
{
    fill_values();
    RfError error;
    uint32_t seed = 77;
    for ( int round = 0; round < 200; ++round )
    {
        size_t size;
        if ( round % 100 == 0 )
            assert_int_equal( write_all( cli_path( "whole.exr" ), RF_EXR_DWAA, 45.0f, round == 0, true, &error ), RF_OK );
        AUTO_FREE char* bytes = cli_read( "whole.exr", &size );
        for ( int k = 0; k < 1 + round % 7; ++k )
            bytes[next_random( &seed ) % size] = (char)next_random( &seed );
        cli_write( "broken.exr", bytes, round % 3 == 0 ? next_random( &seed ) % size : size );
        RfImage image;
        error.text[0] = '\0';
        if ( rf_read_exr( cli_path( "broken.exr" ), &image, &error ) == RF_OK )
            rf_destroy_image( &image );
        else
            assert_non_null( strstr( error.text, "broken.exr" ) );
        assert_null( strchr( error.text, '\n' ) );
    }
}
#endif

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
