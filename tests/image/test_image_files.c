// Images and their files: EXR, PNG, sequences; no failure leaves a partial file.
#include "image/atomic_file.h"
#include "image/exr.h"
#include "image/half.h"
#include "reframe/image.h"
#include "image/sequence.h"
#include "support/image_support.h"
#include "support/test.h"

#include <openexr.h>
#include <png.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#define INCOMPRESSIBLE 400

TEST( test_round_trip_float )
{
    const RfExrCompression compressions[] = { RF_EXR_NONE, RF_EXR_ZIP, RF_EXR_PIZ };
    const int sizes[][2] = { { 1, 1 }, { 7, 1 }, { 1, 40 }, { 67, 45 }, { 130, 97 } };
    for ( int i = 0; i < 15; ++i )
    {
        const int* size = sizes[i / 3];
        AUTO_IMAGE image = make_image( size[0], size[1], 7 + (uint32_t)i );
        image.rgb[0] = NAN;
        image.rgb[1] = -INFINITY;
        image.rgb[2] = 1e-42f; // denormal
        RfExrOptions options = rf_default_exr_options();
        options.half = false;
        options.compression = compressions[i % 3];
        AUTO_IMAGE back = write_and_read( "round.exr", &image, &options );
        assert_int_equal( back.width, image.width );
        assert_int_equal( back.height, image.height );
        assert_memory_equal( back.rgb, image.rgb, image_bytes( &image ) );
    }
}

// Rows that zlib makes no shorter and no longer: some of these come out as long as
// they were, which OpenEXRCore itself stores so that it reads something else.
TEST( test_round_trip_incompressible )
{
    for ( int i = 0; i < INCOMPRESSIBLE; ++i )
    {
        AUTO_IMAGE image = make_image( 40, 1, 1000 + (uint32_t)i );
        // the last pixels are alike, so that a few bytes are saved
        for ( int k = 3 * ( 39 - i % 8 ); k < 3 * 40; ++k )
            image.rgb[k] = image.rgb[k - 3];
        RfExrOptions options = rf_default_exr_options();
        options.half = false;
        AUTO_IMAGE back = write_and_read( "dense.exr", &image, &options );
        assert_memory_equal( back.rgb, image.rgb, image_bytes( &image ) );
    }
}

// All halfs come back, and what lies between two goes to the nearer, from the middle to the even one.
TEST( test_half_rounding )
{
    for ( uint32_t h = 0; h < 0x7bff; ++h )
    {
        float low = rf_half_to_float( (uint16_t)h ), high = rf_half_to_float( (uint16_t)( h + 1 ) );
        float middle = 0.5f * ( low + high );
        assert_int_equal( rf_float_to_half( low ), h );
        assert_int_equal( rf_float_to_half( -low ), h | 0x8000u );
        assert_int_equal( rf_float_to_half( middle ), h + ( h & 1u ) );
        assert_int_equal( rf_float_to_half( nextafterf( middle, low ) ), h );
        assert_int_equal( rf_float_to_half( -nextafterf( middle, high ) ), ( h + 1 ) | 0x8000u );
    }
    assert_int_equal( rf_float_to_half( 65504.0f ), 0x7bff );
    assert_int_equal( rf_float_to_half( -INFINITY ), 0xfc00 );
    assert_true( isnan( rf_half_to_float( rf_float_to_half( NAN ) ) ) );
}

TEST( test_round_trip_half )
{
    AUTO_IMAGE image = make_image( 61, 53, 3 );
    const float extremes[] = { 1e9f, -1e9f, 65519.0f, 65520.0f, 70000.0f, INFINITY, NAN, 0.0f };
    memcpy( image.rgb, extremes, sizeof extremes );
    for ( int c = 0; c < 3; ++c )
    {
        RfExrOptions options = rf_default_exr_options();
        options.compression = (RfExrCompression)c;
        AUTO_IMAGE back = write_and_read( "half.exr", &image, &options );
        const float clamped[] = { 65504.0f, -65504.0f, 65504.0f, 65504.0f, 65504.0f, INFINITY };
        assert_memory_equal( back.rgb, clamped, sizeof clamped );
        assert_true( isnan( back.rgb[6] ) );
        for ( size_t i = 7; i < image_bytes( &image ) / sizeof( float ); ++i )
            assert_true( fabsf( back.rgb[i] - image.rgb[i] ) <= fmaxf( 0x1p-11f * fabsf( image.rgb[i] ), 0x1p-25f ) );
    }
}

TEST( test_same_image_same_bytes )
{
    AUTO_IMAGE image = make_image( 64, 40, 9 );
    RfExrOptions options = rf_default_exr_options();
    RfError error;
    size_t sizes[2];
    char* bytes[2];
    for ( int i = 0; i < 2; ++i )
    {
        const char* path = cli_path( i == 0 ? "a.exr" : "b.exr" );
        assert_int_equal( rf_write_exr( path, &image, &options, &error ), RF_OK );
        bytes[i] = cli_read( path, sizes + i );
    }
    assert_int_equal( sizes[0], sizes[1] );
    assert_memory_equal( bytes[0], bytes[1], sizes[0] );
    free( bytes[0] );
    free( bytes[1] );
}

TEST( test_attributes_round_trip )
{
    AUTO_IMAGE image = make_image( 20, 10, 1 );
    const RfExrString strings[] = { { "reframe/group", "3" },
                                    { "reframe/empty", "" },
                                    { "reframe/a-name-longer-than-thirty-one-bytes", "long" } };
    RfExrOptions options = rf_default_exr_options();
    options.compression = RF_EXR_PIZ;
    options.fps_numerator = 24000;
    options.fps_denominator = 1001;
    options.has_camera = true;
    for ( int i = 0; i < 16; ++i )
    {
        options.world_to_camera[i] = (float)i;
        options.world_to_ndc[i] = (float)-i;
    }
    options.strings = strings;
    options.string_count = 3;
    AUTO_IMAGE back = write_and_read( "attributes.exr", &image, &options );

    exr_context_t context = NULL;
    assert_int_equal( exr_start_read( &context, cli_path( "attributes.exr" ), NULL ), EXR_ERR_SUCCESS );
    exr_attr_rational_t fps;
    assert_int_equal( exr_attr_get_rational( context, 0, "framesPerSecond", &fps ), EXR_ERR_SUCCESS );
    assert_int_equal( fps.num, 24000 );
    assert_int_equal( fps.denom, 1001 );
    exr_attr_m44f_t matrix;
    assert_int_equal( exr_attr_get_m44f( context, 0, "worldToCamera", &matrix ), EXR_ERR_SUCCESS );
    assert_memory_equal( matrix.m, options.world_to_camera, sizeof matrix.m );
    assert_int_equal( exr_attr_get_m44f( context, 0, "worldToNDC", &matrix ), EXR_ERR_SUCCESS );
    assert_memory_equal( matrix.m, options.world_to_ndc, sizeof matrix.m );
    exr_attr_chromaticities_t primaries;
    assert_int_equal( exr_attr_get_chromaticities( context, 0, "chromaticities", &primaries ), EXR_ERR_SUCCESS );
    assert_true( primaries.red_x == 0.64f && primaries.white_y == 0.3290f );
    exr_compression_t compression;
    assert_int_equal( exr_get_compression( context, 0, &compression ), EXR_ERR_SUCCESS );
    assert_int_equal( compression, EXR_COMPRESSION_PIZ );
    exr_attr_box2i_t window, display;
    assert_int_equal( exr_get_data_window( context, 0, &window ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_get_display_window( context, 0, &display ), EXR_ERR_SUCCESS );
    assert_memory_equal( &window, &display, sizeof window );
    assert_int_equal( window.min.x, 0 );
    assert_int_equal( window.max.x, 19 );
    assert_int_equal( window.max.y, 9 );
    exr_finish( &context );
}

TEST( test_strings_are_found_in_headers )
{
    (void)state; // the file of test_attributes_round_trip
    const char* path = cli_path( "attributes.exr" );
    char value[16];
    RfError error;
    assert_int_equal( rf_read_exr_string( path, "reframe/group", value, sizeof value, &error ), RF_OK );
    assert_string_equal( value, "3" );
    assert_int_equal( rf_read_exr_string( path, "reframe/empty", value, sizeof value, &error ), RF_OK );
    assert_string_equal( value, "" );
    assert_int_equal( rf_read_exr_string( path, "reframe/a-name-longer-than-thirty-one-bytes", value, 3, &error ), RF_OK );
    assert_string_equal( value, "lo" );
    assert_int_equal( rf_read_exr_string( path, "reframe/none", value, sizeof value, &error ), RF_ERROR_FORMAT );
    assert_non_null( strstr( error.text, "reframe/none" ) );
    assert_int_equal( rf_read_exr_string( path, "framesPerSecond", value, sizeof value, &error ), RF_ERROR_FORMAT );
    assert_int_equal( rf_read_exr_string( cli_path( "none.exr" ), "x", value, sizeof value, &error ), RF_ERROR_IO );
}

TEST( test_png_is_srgb_of_the_light )
{
    AUTO_IMAGE image = make_image( 5, 2, 1 );
    const float pixels[] = { 0.0f, 1.0f, 0.5f, NAN, 0.0f, 0.0f, -1.0f, INFINITY, 2.0f, 0.25f, 0.0f, 0.0f, 0.0f, 0.0f, 0.001f };
    memcpy( image.rgb, pixels, sizeof pixels );
    RfError error;
    const char* path = cli_path( "image.png" );
    assert_int_equal( rf_write_png( path, &image, 1.0f, &error ), RF_OK );
    png_image png = { .version = PNG_IMAGE_VERSION };
    assert_true( png_image_begin_read_from_file( &png, path ) );
    png.format = PNG_FORMAT_RGB;
    assert_int_equal( png.width, 5 );
    assert_int_equal( png.height, 2 );
    unsigned char bytes[30];
    assert_true( png_image_finish_read( &png, NULL, bytes, 0, NULL ) );
    // sRGB of 0.5 is 187.5… and of 0.002 (linear part) 6.6
    const unsigned char expected[] = { 0, 255, 255, 255, 0, 255, 0, 255, 255, 188, 0, 0, 0, 0, 7 };
    assert_memory_equal( bytes, expected, sizeof expected );
    assert_int_equal( rf_write_png( path, &image, 1e9f, &error ), RF_ERROR_USAGE );
}

// Each writer into a place where it cannot write: an error line, nothing left.
static void check_refused( const char* path, RfResult wanted )
{
    AUTO_IMAGE image = make_image( 16, 16, 1 );
    RfExrOptions options = rf_default_exr_options();
    RfError errors[3] = { { 0 } };
    assert_int_equal( rf_write_exr( path, &image, &options, errors ), wanted );
    assert_int_equal( rf_write_png( path, &image, 0.0f, errors + 1 ), wanted );
    assert_int_equal( rf_write_file_atomic( path, "x", 1, errors + 2 ), wanted );
    for ( int i = 0; i < 3; ++i )
        assert_non_null( strstr( errors[i].text, path ) );
}

TEST( test_unwritable_places_are_reported )
{
    RfError error;
    assert_int_equal( rf_write_file_atomic( cli_path( "file" ), "old", 3, &error ), RF_OK );
    assert_int_equal( mkdir( cli_path( "folder" ), 0755 ), 0 );
    int before = cli_count_files( "", "." );
    check_refused( cli_path( "none/image.exr" ), RF_ERROR_IO );
    check_refused( cli_path( "file/image.exr" ), RF_ERROR_IO );
    check_refused( cli_path( "folder" ), RF_ERROR_IO );
    check_refused( cli_path( "folder/" ), RF_ERROR_IO );
    assert_int_equal( cli_count_files( "", "." ), before );
    if ( geteuid() != 0 ) // permissions do not bind root
    {
        assert_int_equal( chmod( cli_path( "folder" ), 0555 ), 0 );
        check_refused( cli_path( "folder/image.exr" ), RF_ERROR_IO );
    }
    assert_int_equal( rmdir( cli_path( "folder" ) ), 0 );
}

TEST( test_links_are_followed )
{
    RfError error;
    const char* path = cli_path( "text" );
    assert_int_equal( rf_write_file_atomic( path, "one", 3, &error ), RF_OK );
    assert_int_equal( chmod( path, 0600 ), 0 );
    assert_int_equal( symlink( "text", cli_path( "link" ) ), 0 );
    assert_int_equal( rf_write_file_atomic( cli_path( "link" ), "three", 5, &error ), RF_OK );
    struct stat status;
    assert_int_equal( lstat( cli_path( "link" ), &status ), 0 );
    assert_true( S_ISLNK( status.st_mode ) ); // the link stays, what it names is replaced
    assert_int_equal( stat( path, &status ), 0 );
    assert_int_equal( status.st_mode & 0777, 0600 );
    size_t size;
    AUTO_FREE char* text = cli_read( path, &size );
    assert_int_equal( size, 5 );
    assert_memory_equal( text, "three", 5 );
    assert_int_equal( rf_write_file_atomic( "/dev/null", "x", 1, &error ), RF_OK );
    assert_int_equal( stat( "/dev/null", &status ), 0 );
    assert_true( S_ISCHR( status.st_mode ) );
}

// A disk that is full after `limit` bytes, as far as a process can have one.
static void set_file_limit( rlim_t limit )
{
    struct rlimit value;
    assert_int_equal( getrlimit( RLIMIT_FSIZE, &value ), 0 );
    value.rlim_cur = limit;
    assert_int_equal( setrlimit( RLIMIT_FSIZE, &value ), 0 );
}

TEST( test_full_disk_leaves_no_part )
{
    RfError error;
    const char* path = cli_path( "full" );
    assert_int_equal( rf_write_file_atomic( path, "old", 3, &error ), RF_OK );
    int before = cli_count_files( "", "." );
    AUTO_IMAGE image = make_image( 200, 100, 5 );
    RfExrOptions options = rf_default_exr_options();
    signal( SIGXFSZ, SIG_IGN );
    // 0: nothing fits; 100: part of the header; then the chunk table; then chunks
    const rlim_t limits[] = { 0, 100, 400, 5000, 50000 };
    for ( int i = 0; i < 5; ++i )
    {
        set_file_limit( limits[i] );
        for ( int c = 0; c < 3; ++c )
        {
            options.compression = (RfExrCompression)c;
            error.text[0] = 0;
            assert_int_equal( rf_write_exr( path, &image, &options, &error ), RF_ERROR_IO );
            assert_non_null( strstr( error.text, "File too large" ) );
        }
        assert_int_equal( rf_write_png( path, &image, 0.0f, &error ), RF_ERROR_IO );
        set_file_limit( RLIM_INFINITY );
        assert_int_equal( cli_count_files( "", "." ), before );
    }
}

TEST( test_full_disk_keeps_old )
{
    RfError error;
    const char* path = cli_path( "kept.exr" );
    AUTO_IMAGE image = make_image( 200, 100, 5 );
    RfExrOptions options = rf_default_exr_options();
    assert_int_equal( rf_write_exr( path, &image, &options, &error ), RF_OK );
    size_t sizes[2];
    AUTO_FREE char* old = cli_read( path, sizes );
    options.half = false;
    set_file_limit( 20000 );
    assert_int_equal( rf_write_exr( path, &image, &options, &error ), RF_ERROR_IO );
    set_file_limit( RLIM_INFINITY );
    AUTO_FREE char* now = cli_read( path, sizes + 1 );
    assert_int_equal( sizes[0], sizes[1] );
    assert_memory_equal( old, now, sizes[0] );
}

TEST( test_sequence_names_are_read_and_made )
{
    char name[64];
    RfError error;
    assert_true( rf_is_sequence( "out/f.####.exr" ) );
    assert_false( rf_is_sequence( "out#/f.exr" ) );
    assert_int_equal( rf_sequence_name( "out/f.####.exr", 7, name, sizeof name, &error ), RF_OK );
    assert_string_equal( name, "out/f.0007.exr" );
    assert_int_equal( rf_sequence_name( "#", 123, name, sizeof name, &error ), RF_OK );
    assert_string_equal( name, "123" );
    assert_int_equal( rf_sequence_name( "plain.exr", 123, name, sizeof name, &error ), RF_OK );
    assert_string_equal( name, "plain.exr" );
    assert_int_equal( rf_sequence_name( "#a#", 1, name, sizeof name, &error ), RF_ERROR_USAGE );
    assert_int_equal( rf_sequence_name( "a#/b.#", 1, name, sizeof name, &error ), RF_ERROR_USAGE );
    assert_int_equal( rf_sequence_name( "s.#.exr", -1, name, sizeof name, &error ), RF_OK );
    assert_string_equal( name, "s.-1.exr" );
    assert_int_equal( rf_sequence_name( "####", 1, name, 4, &error ), RF_ERROR_USAGE );
}

// As printf and ffmpeg write it.
TEST( test_printf_patterns_are_understood )
{
    static const char* const names[][2] = {
        { "out/f.%04d.exr", "out/f.0007.exr" },
        { "f%d.exr", "f7.exr" },
        { "%010d", "0000000007" },
        { "a%d/f.%02d.exr", "a%d/f.07.exr" },
        { "50%d.####.exr", "50%d.0007.exr" },
        { "a%x%03d", "a%x007" },
    };
    static const char* const plain[] = { "50%done.exr", "f.%4d.exr", "f.%00d.exr", "f.%04x.exr", "f.%0d", "a%04d/f.exr", "%" };
    char name[64];
    RfError error;
    for ( size_t i = 0; i < sizeof names / sizeof names[0]; ++i )
    {
        assert_true( rf_is_sequence( names[i][0] ) );
        assert_int_equal( rf_sequence_name( names[i][0], 7, name, sizeof name, &error ), RF_OK );
        assert_string_equal( name, names[i][1] );
    }
    for ( size_t i = 0; i < sizeof plain / sizeof plain[0]; ++i )
    {
        assert_false( rf_is_sequence( plain[i] ) );
        assert_int_equal( rf_sequence_name( plain[i], 7, name, sizeof name, &error ), RF_OK );
        assert_string_equal( name, plain[i] );
    }
    assert_int_equal( rf_sequence_name( "%04d.%04d", 7, name, sizeof name, &error ), RF_ERROR_USAGE );
    assert_true( rf_may_be_same_file( "f.%04d.exr", "f.####.exr" ) );
    assert_true( rf_may_be_same_file( "f.%04d.exr", "f.0012.exr" ) );
    assert_false( rf_may_be_same_file( "f.%04d.exr", "g.####.exr" ) );
}

TEST( test_sequence_frames )
{
    const char* const names[] = { "s.0010.exr",  "s.0002.exr", "s.12345.exr",       "s.00012.exr", "s.001.exr",  "s.0003.ex",
                                  "xs.0004.exr", "s.-001.exr", "s.99999999999.exr", "s.-0012.exr", "s.-0000.exr" };
    RfError error;
    for ( int i = 0; i < 11; ++i )
        assert_int_equal( rf_write_file_atomic( cli_path( names[i] ), "", 0, &error ), RF_OK );
    int* frames;
    int count;
    assert_int_equal( rf_sequence_frames( cli_path( "s.####.exr" ), &frames, &count, &error ), RF_OK );
    const int expected[] = { -12, 2, 10, 12345 };
    assert_int_equal( count, 4 );
    assert_memory_equal( frames, expected, sizeof expected );
    free( frames );
    char name[64];
    assert_int_equal( rf_sequence_name( "s.%04d.exr", -12, name, sizeof name, &error ), RF_OK );
    assert_string_equal( name, "s.-0012.exr" );
    rf_format_frames( ( const int[] ){ -5, -4, -3, -1, 0, 2 }, 6, name, sizeof name );
    assert_string_equal( name, "-5 to -3, -1, 0, 2" );
    assert_int_equal( rf_sequence_frames( cli_path( "t.####.exr" ), &frames, &count, &error ), RF_ERROR_IO );
    assert_null( frames );
    assert_int_equal( rf_sequence_frames( cli_path( "none/s.#" ), &frames, &count, &error ), RF_ERROR_IO );
    assert_int_equal( rf_sequence_frames( cli_path( "s.exr" ), &frames, &count, &error ), RF_ERROR_USAGE );
}

TEST( test_image_sizes_are_checked )
{
    RfImage image;
    RfError error;
    assert_int_equal( rf_create_image( 0, 5, &image, &error ), RF_ERROR_USAGE );
    assert_null( image.rgb );
    assert_int_equal( rf_create_image( 5, -1, &image, &error ), RF_ERROR_USAGE );
    assert_int_equal( rf_create_image( 3, 2, &image, &error ), RF_OK );
    for ( int i = 0; i < 18; ++i )
        assert_true( image.rgb[i] == 0.0f );
    rf_destroy_image( &image );
    assert_null( image.rgb );
    rf_destroy_image( &image ); // twice does no harm
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
