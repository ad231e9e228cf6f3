// reframe png shows any pass of a file as what it is: light groups mixed anew, mattes by name, data by a range for all frames, the
// display window of files with overscan.
#include "image/exr.h"
#include "image/decode.h"
#include "support/cli_run.h"
#include "support/frame_files.h"
#include "support/image_files.h"
#include "support/test.h"

enum
{
    W = 12,
    H = 8,
    N = W * H
};

#define MANIFEST "{\"wall\":\"40b37e05\",\"vase\":\"3f2a91c4\"}"

// A frame with two light groups, depth, normals, and a Cryptomatte in which the vase covers the left half, and half of the column
// between it and the wall. The picture is the sum of the groups.
static void write_frame( const char* name, float far )
{
    static float key[3 * N], fill[3 * N], normal[3 * N], depth[N], crypto[4 * N];
    static const char letters[] = "RGB", axes[] = "XYZ", all[] = "RGBA";
    const uint32_t bits[2] = { 0x3f2a91c4u, 0x40b37e05u };
    AUTO_IMAGE image;
    RfExrChannel channels[32];
    char names[32][24];
    int count = 0;
    assert_int_equal( rf_create_image( W, H, &image, NULL ), RF_OK );
    memset( crypto, 0, sizeof crypto );
    for ( int i = 0; i < N; ++i )
    {
        int x = i % W;
        for ( int c = 0; c < 3; ++c )
        {
            key[3 * i + c] = c == 0 ? 0.25f : 0.0f;
            fill[3 * i + c] = c == 2 ? 0.125f : 0.0f;
            normal[3 * i + c] = c == 1 ? 1.0f : 0.0f;
            image.rgb[3 * i + c] = key[3 * i + c] + fill[3 * i + c];
        }
        depth[i] = x == 0 ? 1e10f : 1.0f + ( far - 1.0f ) * (float)x / ( W - 1 );
        memcpy( crypto + 4 * i, bits + ( x > W / 2 ), sizeof *bits );
        crypto[4 * i + 1] = x == W / 2 ? 0.5f : 1.0f;
        memcpy( crypto + 4 * i + 2, bits + 1, sizeof *bits );
        crypto[4 * i + 3] = x == W / 2 ? 0.5f : 0.0f;
    }
#define ADD( layer, of, letter_list, letters_of )                                                                                \
    for ( int c = 0; c < ( letters_of ); ++c, ++count )                                                                          \
    {                                                                                                                            \
        snprintf( names[count], sizeof names[count], "%s.%c", layer, letter_list[c] );                                           \
        channels[count] = ( RfExrChannel ){ .name = names[count], .values = ( of ) + c, .stride = letters_of };                  \
    }
    ADD( "light_key", key, letters, 3 )
    ADD( "light_fill", fill, letters, 3 )
    ADD( "normal", normal, axes, 3 )
    ADD( "depth", depth, "Z", 1 )
    ADD( "CryptoObject00", crypto, all, 4 )
    ADD( "CryptoMaterial00", crypto, all, 4 ) // materials of the same names
#undef ADD
    const RfExrString strings[] = { { "cryptomatte/1234567/name", "CryptoObject" },
                                    { "cryptomatte/1234567/manifest", MANIFEST },
                                    { "cryptomatte/89abcde/name", "CryptoMaterial" },
                                    { "cryptomatte/89abcde/manifest", MANIFEST } };
    RfExrOptions options = rf_default_exr_options();
    options.half = false;
    options.channels = channels;
    options.channel_count = count;
    options.strings = strings;
    options.string_count = 4;
    assert_int_equal( rf_write_exr( cli_path( name ), &image, &options, NULL ), RF_OK );
}

// A channel of a pixel of a PNG that was written.
static int pixel( const char* name, int x, int y, int c )
{
    RfPixels picture;
    size_t size;
    AUTO_FREE char* bytes = cli_read( name, &size );
    assert_int_equal( rf_decode_image( bytes, size, name, &picture, NULL ), RF_OK );
    int value = ( (const uint8_t*)picture.data )[picture.channels * ( y * picture.width + x ) + c];
    rf_destroy_pixels( &picture );
    return value;
}

static void check_pixel( const char* name, int x, int y, int r, int g, int b )
{
    int found[3] = { pixel( name, x, y, 0 ), pixel( name, x, y, 1 ), pixel( name, x, y, 2 ) };
    if ( abs( found[0] - r ) > 1 || abs( found[1] - g ) > 1 || abs( found[2] - b ) > 1 )
        fail_msg( "%s at (%d, %d): %d %d %d, not %d %d %d", name, x, y, found[0], found[1], found[2], r, g, b );
}

static int level( double light )
{
    return (int)lrint( 255.0 * ( light <= 0.0031308 ? 12.92 * light : 1.055 * pow( light, 1.0 / 2.4 ) - 0.055 ) );
}

static void show( const char* options, const char* to )
{
    cli_expect( cli_run( "$R png f.exr %s --quiet %s", to, options ), 0, NULL );
}

TEST( test_light_groups_are_mixed )
{
    write_frame( "f.exr", 4.0f );
    show( "--layer light_key", "k.png" );
    check_pixel( "k.png", 3, 3, level( 0.25 ), 0, 0 );
    show( "--mix key=1", "c.png" );
    show( "", "d.png" );
    assert_int_equal( pixel( "c.png", 0, 0, 2 ), pixel( "d.png", 0, 0, 2 ) );
    show( "--mix key=2,fill=0 --exposure 1", "m.png" );
    check_pixel( "m.png", 5, 7, 255, 0, 0 );
    show( "--mix fill=4", "m.png" );
    check_pixel( "m.png", 5, 7, level( 0.25 ), 0, level( 0.5 ) );
    cli_expect( cli_run( "$R png f.exr n.png --mix kye=2" ), 1, "has no light group 'kye', did you mean 'key'?" );
    cli_expect( cli_run( "$R png f.exr n.png --mix sun=2" ), 1, "has no light group 'sun', there are fill, key" );
    static const char* const bad[] = { "key", "key=", "=1", "key=1,", "key=x", "key=1x", "key=-1", "key=nan", "key=1,key=2", "" };
    for ( size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i )
        cli_expect( cli_run( "$R png f.exr n.png --mix '%s'", bad[i] ), 2, "--mix: " );
    cli_expect( cli_run( "$R png f.exr n.png --mix key=1 --layer depth" ), 2, "leave out --layer" );
    page_write_frame( "plain.exr", 4, 4, 1.0f, NULL, 0 );
    cli_expect( cli_run( "$R png plain.exr n.png --mix key=1" ), 1, "has no light groups" );
    assert_false( cli_exists( "n.png" ) );
}

TEST( test_mattes_by_name )
{
    write_frame( "f.exr", 4.0f );
    show( "--matte vase", "v.png" );
    show( "--matte wall --layer CryptoObject", "w.png" );
    check_pixel( "v.png", W / 2 - 1, 2, 255, 255, 255 );
    check_pixel( "v.png", W / 2, 2, 128, 128, 128 );
    check_pixel( "v.png", W / 2 + 1, 2, 0, 0, 0 );
    check_pixel( "w.png", W / 2, 2, 128, 128, 128 );
    check_pixel( "w.png", W / 2 + 1, 2, 255, 255, 255 );
    show( "--layer CryptoObject", "c.png" );
    int apart = 0;
    for ( int c = 0; c < 3; ++c )
        apart += abs( pixel( "c.png", 0, 0, c ) - pixel( "c.png", W - 1, 0, c ) );
    assert_true( apart > 60 );
    cli_expect( cli_run( "$R compare f.exr f.exr --layer CryptoObject" ), 1,
                "CryptoObject has ids of names, which are not compared" );
    cli_expect( cli_run( "$R png f.exr n.png --matte vasse" ), 1, "has no matte 'vasse', did you mean 'vase'?" );
    cli_expect( cli_run( "$R png f.exr n.png --matte tree" ), 1, "has no matte 'tree', there are vase, wall" );
    cli_expect( cli_run( "$R png plain.exr n.png --matte vase" ), 1, "has no Cryptomatte with names" );
    cli_expect( cli_run( "$R png f.exr v.png --matte vase --exposure 1 --quiet" ), 0, NULL );
    check_pixel( "v.png", W / 2, 2, 128, 128, 128 );
}

TEST( test_data_is_drawn )
{
    page_make_folder( "s" );
    write_frame( "s/f.1.exr", 4.0f );
    write_frame( "s/f.2.exr", 16.0f );
    write_frame( "f.exr", 4.0f );
    show( "--layer normal", "n.png" );
    check_pixel( "n.png", 1, 1, 128, 255, 128 );
    show( "--layer depth", "z.png" );
    check_pixel( "z.png", 0, 0, 0, 0, 0 );        // nothing
    check_pixel( "z.png", W - 1, 0, 26, 26, 26 ); // the farthest
    cli_expect( cli_run( "$R png s t --layer depth --quiet" ), 0, NULL );
    assert_true( pixel( "t/f.1.png", W - 1, 0, 0 ) > 100 ); // 4 m of 16, by one range for all frames
    check_pixel( "t/f.2.png", W - 1, 0, 26, 26, 26 );
    show( "--layer depth.Z", "z.png" ); // a channel is as it is
    check_pixel( "z.png", 1, 0, 255, 255, 255 );
    cli_expect( cli_run( "$R png f.exr q.png --layer nothing" ), 1,
                "f.exr: has no layer nothing; it has normal, depth, light_fill, light_key, CryptoMaterial, CryptoObject" );
    const CliResult* result = cli_run( "$R png f.exr z.png --layer depth --exposure 2" );
    assert_non_null( strstr( result->err, "depth is not a colour: exposure and view do not apply" ) );
}

// The data window may be larger than the display window, as with overscan, or smaller.
TEST( test_the_display_window_is_shown )
{
    Foreign part = { .names = { "B", "G", "R" }, .values = { 1, 1, 1 }, .x = -3, .y = 2, .width = 80, .height = 10 };
    write_foreign_exr( cli_path( "o.exr" ), &part, 1 ); // of a display window of 64x64 pixels
    cli_expect( cli_run( "$R png o.exr o.png && $R png o.exr w.png --window data" ), 0, NULL );
    RfPixels picture;
    size_t size;
    char* bytes = cli_read( "o.png", &size );
    assert_int_equal( rf_measure_image( bytes, size, "o.png", &picture, NULL ), RF_OK );
    assert_true( picture.width == 64 && picture.height == 64 );
    free( bytes );
    bytes = cli_read( "w.png", &size );
    assert_int_equal( rf_measure_image( bytes, size, "w.png", &picture, NULL ), RF_OK );
    assert_true( picture.width == 80 && picture.height == 10 );
    free( bytes );
    check_pixel( "o.png", 0, 1, 0, 0, 0 );
    check_pixel( "o.png", 0, 2, 255, 255, 255 );
    check_pixel( "o.png", 63, 11, 255, 255, 255 );
    check_pixel( "o.png", 63, 12, 0, 0, 0 );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
