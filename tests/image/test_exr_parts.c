// Files of several parts, of many channels, with a display window of its own and attributes of all types.
#include "image/exr.h"
#include "support/image_support.h"
#include "support/test.h"

#include <openexr.h>
#include <signal.h>
#include <sys/resource.h>

#define WIDTH 37
#define HEIGHT 41
#define PIXELS ( WIDTH * HEIGHT )

static const float s_values[4 * PIXELS];

// Channels that are numbers, of halves and floats, in parts whose order is not that of their names.
static float s_data[3][PIXELS];

static RfExrOptions make_options( RfExrChannel channels[4], const char* const parts[4] )
{
    static const char* const names[4] = { "normal.Y", "depth.Z", "A", "depth.A" };
    for ( int i = 0; i < PIXELS; ++i )
    {
        s_data[0][i] = (float)( i % 17 ) * 0.125f - 1.0f;
        s_data[1][i] = 1e-3f * (float)( i * i ) + 1e6f;
        s_data[2][i] = (float)( i % 5 ) * 0.25f;
    }
    for ( int c = 0; c < 4; ++c )
        channels[c] = ( RfExrChannel ){
            .name = names[c], .values = s_data[c % 3], .stride = 1, .half = c != 1, .part = parts != NULL ? parts[c] : NULL
        };
    RfExrOptions options = rf_default_exr_options();
    options.channels = channels;
    options.channel_count = 4;
    return options;
}

static void check_values( const char* path, const RfImage* image, bool dwa, bool half )
{
    static const char* const names[] = { "depth.Z", "normal.Y", "A", "depth.A", "R" };
    RfExrWindow window;
    RfError error;
    AUTO_FREE float* values;
    assert_int_equal( rf_read_exr_channels( path, names, 5, &window, &values, &error ), RF_OK );
    assert_int_equal( window.width, WIDTH );
    assert_int_equal( window.height, HEIGHT );
    for ( int i = 0; i < PIXELS; ++i )
    {
        assert_true( values[5 * i] == s_data[1][i] && values[5 * i + 1] == s_data[0][i] );
        assert_true( values[5 * i + 2] == s_data[2][i] && values[5 * i + 3] == s_data[0][i] );
        float bound = dwa    ? 0.1f + 0.1f * fabsf( image->rgb[3 * i] )
                      : half ? fmaxf( 0x1p-11f * fabsf( image->rgb[3 * i] ), 0x1p-25f )
                             : 0.0f;
        assert_true( fabsf( values[5 * i + 4] - image->rgb[3 * i] ) <= bound );
    }
}

TEST( test_parts_hold_what_one_part_does )
{
    static const char* const parts[4] = { "normal", "depth", NULL, "depth" };
    AUTO_IMAGE image = make_image( WIDTH, HEIGHT, 4 );
    for ( int way = 0; rf_compression_words[way / 4] != NULL; ++way )
    {
        RfExrChannel channels[4];
        RfExrOptions options = make_options( channels, way % 2 == 1 ? parts : NULL );
        options.compression = (RfExrCompression)( way / 4 );
        options.half = way / 2 % 2 == 0;
        AUTO_IMAGE back = write_and_read( "parts.exr", &image, &options );
        check_values( cli_path( "parts.exr" ), &image, options.compression >= RF_EXR_DWAA, options.half );
    }
}

// Where the first chunk begins: what the first offset of the table of chunks names, which is the end of the table.
static size_t find_pixels( const char* bytes, size_t size )
{
    for ( size_t at = 64; at + 8 < size; ++at )
    {
        uint64_t offset;
        memcpy( &offset, bytes + at, sizeof offset );
        if ( offset > at && offset < size && offset - at <= 8 * 5 * HEIGHT && ( offset - at ) % 8 == 0 )
            return (size_t)offset;
    }
    fail_msg( "no table of chunks" );
    return 0;
}

static RfResult verify( const char* bytes, size_t size, bool* same )
{
    RfError error;
    cli_write( "damaged.exr", bytes, size );
    return rf_verify_exr( cli_path( "damaged.exr" ), same, &error );
}

// Any bit of the pixels, of any part, and any cut; a file without a checksum is judged by decoding.
TEST( test_damage_is_found )
{
    static const char* const parts[4] = { "normal", "depth", NULL, "depth" };
    AUTO_IMAGE image = make_image( WIDTH, HEIGHT, 4 );
    char sums[2][64] = { "" };
    int alike = 0;
    uint32_t seed = 99;
    for ( int way = 0; rf_compression_words[way / 2] != NULL; ++way )
    {
        RfExrChannel channels[4];
        RfExrOptions options = make_options( channels, way % 2 == 1 ? parts : NULL );
        RfError error;
        options.compression = (RfExrCompression)( way / 2 );
        size_t size;
        bool same;
        assert_int_equal( rf_write_exr( cli_path( "whole.exr" ), &image, &options, &error ), RF_OK );
        AUTO_FREE char* bytes = cli_read( "whole.exr", &size );
        size_t begin = find_pixels( bytes, size );
        assert_true( verify( bytes, size, &same ) == RF_OK && same );
        for ( int i = 0; i < 30; ++i )
        {
            size_t at = i == 0 ? begin : i == 1 ? size - 1 : begin + next_random( &seed ) % ( size - begin );
            bytes[at] ^= (char)( 1 << i % 8 );
            if ( verify( bytes, size, &same ) == RF_OK && same ) // zlib has several streams for the same samples
            {
                assert_true( options.compression < RF_EXR_DWAA );
                check_values( cli_path( "damaged.exr" ), &image, false, true );
                ++alike;
            }
            bytes[at] ^= (char)( 1 << i % 8 );
            size_t left = i == 0 ? begin : i == 1 ? size - 1 : at;
            assert_int_not_equal( verify( bytes, left, &same ), RF_OK );
        }
        // lossless compressions have one checksum, of the samples
        char sum[64];
        assert_int_equal( rf_read_exr_string( cli_path( "whole.exr" ), "reframe/checksum", sum, sizeof sum, &error ), RF_OK );
        if ( options.compression < RF_EXR_DWAA && sums[way % 2][0] != '\0' )
            assert_string_equal( sum, sums[way % 2] );
        if ( options.compression < RF_EXR_DWAA )
            strcpy( sums[way % 2], sum );
    }
    assert_true( alike < 5 );
}

TEST( test_without_checksum_decoding_decides )
{
    AUTO_IMAGE image = make_image( WIDTH, HEIGHT, 4 );
    RfExrOptions options = rf_default_exr_options();
    RfError error;
    options.compression = RF_EXR_NONE;
    assert_int_equal( rf_write_exr( cli_path( "whole.exr" ), &image, &options, &error ), RF_OK );
    size_t size, at = 0;
    bool same;
    AUTO_FREE char* bytes = cli_read( "whole.exr", &size );
    while ( memcmp( bytes + at, "reframe/checksum", 16 ) != 0 )
        ++at;
    bytes[at] = 'R'; // an attribute that means nothing
    bytes[size - 5] ^= 1;
    assert_true( verify( bytes, size, &same ) == RF_OK && same );
    assert_int_not_equal( verify( bytes, size - 1, &same ), RF_OK );
    bytes[at] = 'r';
    assert_true( verify( bytes, size, &same ) == RF_OK && !same );
}

// The names, the order and the shared attributes that the specification asks of parts.
TEST( test_parts_are_named_and_share_attributes )
{
    static const char* const parts[4] = { "normal", "depth", NULL, "depth" };
    static const char* const names[3] = { "rgba", "normal", "depth" };
    static const int counts[3] = { 4, 1, 2 };
    AUTO_IMAGE image = make_image( WIDTH, HEIGHT, 4 );
    RfExrChannel channels[4];
    RfExrOptions options = make_options( channels, parts );
    const RfExrAttribute attributes[] = {
        { .name = "timeCode", .type = RF_EXR_TIMECODE, .timecode = { 0x01020304u, 7u } },
        { .name = "focus", .type = RF_EXR_FLOAT, .values = { 2.5f } },
        { .name = "cameraToWorld", .type = RF_EXR_M44F, .values = { [0] = 1.0f, [13] = -3.0f } },
    };
    options.attributes = attributes;
    options.attribute_count = 3;
    options.strings = &( const RfExrString ){ "owner", "me" };
    options.string_count = 1;
    options.x = -5;
    options.y = 3;
    options.display = ( RfExrWindow ){ 0, 8, WIDTH - 10, HEIGHT - 10 };
    options.pixel_aspect = 2.0f;
    RfError error;
    if ( rf_write_exr( cli_path( "shared.exr" ), &image, &options, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    exr_context_t context = NULL;
    int count = 0;
    assert_int_equal( exr_start_read( &context, cli_path( "shared.exr" ), NULL ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_get_count( context, &count ), EXR_ERR_SUCCESS );
    assert_int_equal( count, 3 );
    for ( int p = 0; p < count; ++p )
    {
        const char* text = NULL;
        int length = 0;
        const exr_attr_chlist_t* list = NULL;
        exr_attr_box2i_t window, display;
        exr_attr_timecode_t timecode;
        exr_attr_m44f_t matrix;
        float number = 0.0f;
        assert_int_equal( exr_get_name( context, p, &text ), EXR_ERR_SUCCESS );
        assert_string_equal( text, names[p] );
        assert_int_equal( exr_get_channels( context, p, &list ), EXR_ERR_SUCCESS );
        assert_int_equal( list->num_channels, counts[p] );
        assert_int_equal( exr_get_data_window( context, p, &window ), EXR_ERR_SUCCESS );
        assert_int_equal( exr_get_display_window( context, p, &display ), EXR_ERR_SUCCESS );
        assert_true( window.min.x == -5 && window.min.y == 3 && window.max.x == WIDTH - 6 && window.max.y == HEIGHT + 2 );
        assert_true( display.min.x == 0 && display.min.y == 8 && display.max.x == WIDTH - 11 && display.max.y == HEIGHT - 3 );
        assert_int_equal( exr_get_pixel_aspect_ratio( context, p, &number ), EXR_ERR_SUCCESS );
        assert_true( number == 2.0f );
        assert_int_equal( exr_attr_get_timecode( context, p, "timeCode", &timecode ), EXR_ERR_SUCCESS );
        assert_true( timecode.time_and_flags == 0x01020304u && timecode.user_data == 7u );
        exr_attr_chromaticities_t primaries;
        assert_int_equal( exr_attr_get_chromaticities( context, p, "chromaticities", &primaries ), EXR_ERR_SUCCESS );
        bool first = p == 0;
        assert_int_equal( exr_attr_get_string( context, p, "owner", &length, &text ) == EXR_ERR_SUCCESS, first );
        assert_int_equal( exr_attr_get_float( context, p, "focus", &number ) == EXR_ERR_SUCCESS, first );
        assert_int_equal( exr_attr_get_m44f( context, p, "cameraToWorld", &matrix ) == EXR_ERR_SUCCESS, first );
        assert_true( !first || ( number == 2.5f && matrix.m[0] == 1.0f && matrix.m[13] == -3.0f ) );
    }
    exr_finish( &context );
    AUTO_BY( rf_destroy_exr_header ) RfExrHeader header;
    assert_int_equal( rf_read_exr_header( cli_path( "shared.exr" ), NULL, &header, &error ), RF_OK );
    assert_true( header.x == -5 && header.y == 3 && header.width == WIDTH && header.height == HEIGHT );
    assert_true( header.display_x == 0 && header.display_y == 8 && header.display_width == WIDTH - 10 );
    assert_non_null( rf_find_exr_name( &header, "depth.Z", 7 ) );
    assert_string_equal( header.channels[header.channel_count - 1].text, "depth.Z" ); // not depth.depth.Z
}

TEST( test_many_channels_and_long_names )
{
    static char names[RF_EXR_MAX_CHANNELS][64];
    RfExrChannel channels[RF_EXR_MAX_CHANNELS];
    for ( int c = 0; c < RF_EXR_MAX_CHANNELS; ++c )
    {
        snprintf( names[c], sizeof names[c], "light_a name beyond thirty-one characters %03d.R",
                  ( 7 * c ) % RF_EXR_MAX_CHANNELS );
        channels[c] = ( RfExrChannel ){ .name = names[c], .values = s_values + c, .stride = 1, .half = c % 2 == 0 };
        channels[c].part = c % 4 == 3 ? names[c] : NULL;
    }
    AUTO_IMAGE image = make_image( 4, 3, 4 );
    RfExrOptions options = rf_default_exr_options();
    options.channels = channels;
    options.channel_count = RF_EXR_MAX_CHANNELS - 3;
    RfError error;
    const char* path = cli_path( "many.exr" );
    assert_int_equal( rf_write_exr( path, &image, &options, &error ), RF_OK );
    AUTO_BY( rf_destroy_exr_header ) RfExrHeader header;
    assert_int_equal( rf_read_exr_header( path, NULL, &header, &error ), RF_OK );
    assert_int_equal( header.channel_count, RF_EXR_MAX_CHANNELS );
    ++options.channel_count;
    assert_int_equal( rf_write_exr( path, &image, &options, &error ), RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "254 channels cannot be written: at most 253" ) );
    char name[300];
    memset( name, 'x', sizeof name - 1 );
    name[299] = '\0';
    channels[0].name = name;
    options.channel_count = 1;
    assert_int_equal( rf_write_exr( path, &image, &options, &error ), RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "at most 255 bytes" ) );
}

// Wherever a file breaks off, a part before it may be whole: no file is left all the same.
TEST( test_full_disk_leaves_no_part )
{
    static const char* const parts[4] = { "normal", "depth", NULL, "depth" };
    AUTO_IMAGE image = make_image( WIDTH, HEIGHT, 4 );
    RfExrChannel channels[4];
    RfExrOptions options = make_options( channels, parts );
    RfError error;
    int before = cli_count_files( "", "." );
    struct rlimit value;
    signal( SIGXFSZ, SIG_IGN );
    assert_int_equal( getrlimit( RLIMIT_FSIZE, &value ), 0 );
    for ( int way = 0; rf_compression_words[way / 5] != NULL; ++way )
    {
        static const rlim_t limits[] = { 0, 300, 1300, 9000, 12000 };
        options.compression = (RfExrCompression)( way / 5 );
        value.rlim_cur = limits[way % 5];
        assert_int_equal( setrlimit( RLIMIT_FSIZE, &value ), 0 );
        RfResult result = rf_write_exr( cli_path( "full.exr" ), &image, &options, &error );
        value.rlim_cur = RLIM_INFINITY;
        assert_int_equal( setrlimit( RLIMIT_FSIZE, &value ), 0 );
        assert_int_equal( result, RF_ERROR_IO );
        assert_non_null( strstr( error.text, "File too large" ) );
        assert_int_equal( cli_count_files( "", "." ), before );
    }
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
