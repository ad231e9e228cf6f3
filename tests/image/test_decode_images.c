// Decoding images made by others: each format returns what was stored; damaged, truncated
// or oversized files fail with one line.
#include "support/image_files.h"
#include "support/test.h"

#include "image/decode.h"
#include "image/exr.h"

#include <unistd.h>

#define WIDTH 21
#define HEIGHT 13

static RfPixels decode( const uint8_t* bytes, size_t size )
{
    RfPixels out;
    RfError error = { 0 };
    if ( rf_decode_image( bytes, size, "picture", &out, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    RfPixels header;
    assert_int_equal( rf_measure_image( bytes, size, "picture", &header, &error ), RF_OK );
    assert_null( header.data );
    assert_true( header.width == out.width && header.height == out.height && header.channels == out.channels &&
                 header.type == out.type );
    return out;
}

static void expect( const uint8_t* bytes, size_t size, RfResult code, const char* text )
{
    RfPixels out;
    RfError error = { 0 };
    RfResult result = rf_decode_image( bytes, size, "picture", &out, &error );
    if ( result != code || strstr( error.text, text ) == NULL || strncmp( error.text, "picture: ", 9 ) != 0 )
        fail_msg( "got %s '%s', wanted %s '%s'", rf_result_name( result ), error.text, rf_result_name( code ), text );
    assert_null( out.data );
    assert_int_equal( rf_decode_image( bytes, size, "picture", &out, NULL ), code );
}

static void fill( uint8_t* pixels, size_t count )
{
    uint32_t seed = 12345;
    for ( size_t i = 0; i < count; ++i )
    {
        seed = seed * 1664525u + 1013904223u;
        pixels[i] = (uint8_t)( seed >> 24 );
    }
}

TEST( test_png_comes_out_as_it_went_in )
{
    uint8_t pixels[WIDTH * HEIGHT * 4];
    fill( pixels, sizeof pixels );
    for ( int channels = 1; channels <= 4; ++channels )
    {
        size_t size;
        AUTO_FREE uint8_t* bytes = encode_png( WIDTH, HEIGHT, channels, pixels, &size );
        AUTO_BY( rf_destroy_pixels ) RfPixels out = decode( bytes, size );
        assert_int_equal( out.width, WIDTH );
        assert_int_equal( out.height, HEIGHT );
        assert_int_equal( out.channels, channels );
        assert_int_equal( out.type, RF_PIXELS_U8 );
        assert_memory_equal( out.data, pixels, (size_t)( WIDTH * HEIGHT * channels ) );
    }
}

// The numbers of the file, although it names a gamma.
TEST( test_png16_ignores_gamma )
{
    uint16_t pixels[WIDTH * HEIGHT * 3];
    fill( (uint8_t*)pixels, sizeof pixels );
    for ( int channels = 1; channels <= 3; channels += 2 )
    {
        size_t size;
        AUTO_FREE uint8_t* bytes = encode_png16( WIDTH, HEIGHT, channels, pixels, &size );
        AUTO_BY( rf_destroy_pixels ) RfPixels out = decode( bytes, size );
        assert_int_equal( out.channels, channels );
        assert_int_equal( out.type, RF_PIXELS_U16 );
        assert_memory_equal( out.data, pixels, (size_t)( WIDTH * HEIGHT * channels * 2 ) );
    }
}

TEST( test_jpeg_comes_out_nearly )
{
    uint8_t pixels[WIDTH * HEIGHT * 4];
    for ( int channels = 1; channels <= 3; channels += 2 )
    {
        for ( int i = 0; i < WIDTH * HEIGHT * channels; ++i )
            pixels[i] = (uint8_t)( 40 * ( i % channels ) + 5 * ( i / channels % WIDTH ) + 3 * ( i / channels / WIDTH ) );
        size_t size;
        AUTO_FREE uint8_t* bytes = encode_jpeg( WIDTH, HEIGHT, channels, pixels, &size );
        AUTO_BY( rf_destroy_pixels ) RfPixels out = decode( bytes, size );
        assert_int_equal( out.width, WIDTH );
        assert_int_equal( out.height, HEIGHT );
        assert_int_equal( out.channels, channels );
        assert_int_equal( out.type, RF_PIXELS_U8 );
        for ( int i = 0; i < WIDTH * HEIGHT * channels; ++i )
            assert_true( abs( ( (uint8_t*)out.data )[i] - pixels[i] ) <= 4 );
    }
    size_t size;
    AUTO_FREE uint8_t* bytes = encode_jpeg( WIDTH, HEIGHT, 4, pixels, &size );
    expect( bytes, size, RF_ERROR_UNSUPPORTED, "CMYK" );
}

TEST( test_exr_comes_out_as_it_went_in )
{
    float pixels[WIDTH * HEIGHT * 3];
    for ( int i = 0; i < WIDTH * HEIGHT * 3; ++i )
        pixels[i] = (float)i * 1.37f - 100.0f;
    size_t size;
    AUTO_FREE uint8_t* bytes = encode_exr( WIDTH, HEIGHT, pixels, &size );
    AUTO_BY( rf_destroy_pixels ) RfPixels out = decode( bytes, size );
    assert_int_equal( out.width, WIDTH );
    assert_int_equal( out.channels, 3 );
    assert_int_equal( out.type, RF_PIXELS_FLOAT );
    assert_memory_equal( out.data, pixels, sizeof pixels );
}

TEST( test_hdr_comes_out_as_it_went_in )
{
    uint8_t pixels[300 * 4 * 4];
    fill( pixels, sizeof pixels );
    static const int widths[] = { 3, 300 };
    for ( int k = 0; k < 2; ++k )
    {
        for ( int i = 0; i < widths[k] * 4; ++i )
            pixels[4 * i + 3] = (uint8_t)( 120 + i % 20 );
        pixels[0] |= 128; // as real ones have: else it looks like a run
        size_t size;
        AUTO_FREE uint8_t* bytes = encode_hdr( widths[k], 4, pixels, &size );
        AUTO_BY( rf_destroy_pixels ) RfPixels out = decode( bytes, size );
        assert_int_equal( out.width, widths[k] );
        assert_int_equal( out.height, 4 );
        assert_int_equal( out.channels, 3 );
        assert_int_equal( out.type, RF_PIXELS_FLOAT );
        for ( int i = 0; i < widths[k] * 4 * 3; ++i )
        {
            float want = ldexpf( (float)pixels[4 * ( i / 3 ) + i % 3], pixels[4 * ( i / 3 ) + 3] - 136 );
            assert_true( fabsf( ( (float*)out.data )[i] - want ) <= 1e-6f * want );
        }
    }
}

#ifdef REFRAME_WEBP

TEST( test_webp )
{
    uint8_t pixels[WIDTH * HEIGHT * 4];
    for ( int i = 0; i < 4; ++i )
    {
        int channels = 3 + i % 2;
        bool lossy = i >= 2;
        for ( int k = 0; k < WIDTH * HEIGHT * channels; ++k )
            pixels[k] = (uint8_t)( lossy ? 90 + k / channels % WIDTH + 3 * ( k / channels / WIDTH ) : k * 37 + k / 7 * 11 );
        for ( int k = 3; k < WIDTH * HEIGHT * 4 && channels == 4; k += 4 )
            pixels[k] |= 128; // colours of clear pixels are not kept
        size_t size;
        AUTO_FREE uint8_t* bytes = encode_webp( WIDTH, HEIGHT, channels, lossy, pixels, &size );
        AUTO_BY( rf_destroy_pixels ) RfPixels out = decode( bytes, size );
        assert_true( out.width == WIDTH && out.height == HEIGHT && out.channels == channels && out.type == RF_PIXELS_U8 );
        for ( int k = 0; k < WIDTH * HEIGHT * channels; ++k )
            assert_true( abs( ( (uint8_t*)out.data )[k] - pixels[k] ) <= ( lossy ? 6 : 0 ) );
        expect( bytes, size - 9, RF_ERROR_FORMAT, "truncated" );
        expect( bytes, 14, RF_ERROR_FORMAT, "truncated" );
        if ( i == 0 )
        {
            bytes[20] ^= 0xff; // the signature of what is lossless
            expect( bytes, size, RF_ERROR_FORMAT, "damaged WebP" );
        }
    }
    static const uint8_t s_moving[30] = "RIFF\x16\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0\x0f\0\0\x0f\0\0";
    expect( s_moving, 30, RF_ERROR_UNSUPPORTED, "animated WebP is not supported" );
}

#else

TEST( test_webp )
{
    expect( (const uint8_t*)"RIFF\x20\0\0\0WEBPVP8 ", 16, RF_ERROR_UNSUPPORTED, "this Reframe was built without libwebp" );
}

#endif

// Every format, cut off everywhere and with bytes changed anywhere: an error
// or an image, never a crash, a hang or half an image.
TEST( test_damage_never_crashes )
{
    uint8_t pixels[WIDTH * HEIGHT * 4];
    float reals[WIDTH * HEIGHT * 3];
    fill( pixels, sizeof pixels );
    for ( int i = 0; i < WIDTH * HEIGHT * 3; ++i )
        reals[i] = (float)pixels[i] * 0.31f;
    size_t sizes[6];
    int count = 5;
    uint8_t* files[6] = {
        encode_png( WIDTH, HEIGHT, 4, pixels, sizes ), encode_jpeg( WIDTH, HEIGHT, 3, pixels, sizes + 1 ),
        encode_exr( WIDTH, HEIGHT, reals, sizes + 2 ), encode_hdr( WIDTH, HEIGHT, pixels, sizes + 3 ),
        encode_hdr( 5, HEIGHT, pixels, sizes + 4 ),
    };
#ifdef REFRAME_WEBP
    files[count++] = encode_webp( WIDTH, HEIGHT, 4, true, pixels, sizes + 5 );
#endif
    for ( int f = 0; f < count; ++f )
    {
        RfPixels out;
        RfError error;
        for ( size_t length = 0; length < sizes[f]; ++length )
        {
            // a copy of just this size: what reads past it is seen by the sanitizers
            AUTO_FREE uint8_t* copy = malloc( length + 1 );
            memcpy( copy, files[f], length );
            RfResult result = rf_decode_image( copy, length, "picture", &out, &error );
            if ( result == RF_OK )
                fail_msg( "file %d of %zu bytes was read with %zu of them", f, sizes[f], length );
            assert_null( out.data );
        }
        uint32_t seed = 99;
        for ( int n = 0; n < 2000; ++n )
        {
            AUTO_FREE uint8_t* copy = malloc( sizes[f] );
            memcpy( copy, files[f], sizes[f] );
            for ( int k = 0; k < 1 + n % 3; ++k )
            {
                seed = seed * 1664525u + 1013904223u;
                copy[( seed >> 8 ) % sizes[f]] = (uint8_t)( seed >> 24 );
            }
            if ( rf_decode_image( copy, sizes[f], "picture", &out, &error ) == RF_OK )
                rf_destroy_pixels( &out );
            else
                assert_true( error.text[0] != 0 && out.data == NULL );
        }
        free( files[f] );
    }
}

TEST( test_wrong_images_are_refused )
{
    uint8_t bytes[64] = { 0 };
    expect( bytes, 64, RF_ERROR_FORMAT, "not a PNG, JPEG, WebP, EXR or Radiance HDR" );
    expect( bytes, 0, RF_ERROR_FORMAT, "not a PNG" );
    expect( (const uint8_t*)"\xabKTX 20\xbb\r\n\x1a\n", 12, RF_ERROR_UNSUPPORTED, "KTX2 images are not supported" );
    size_t size = promise_png( bytes, 20000, 10 );
    expect( bytes, size, RF_ERROR_UNSUPPORTED, "20000x10 pixels is too large, the limit is 16384 per side" );
    size = promise_png( bytes, 0x7fffffff, 0x7fffffff );
    expect( bytes, size, RF_ERROR_UNSUPPORTED, "2147483647x2147483647" );
    size = promise_png( bytes, 0, 10 );
    expect( bytes, size, RF_ERROR_FORMAT, "PNG" );
    size = promise_png( bytes, 16000, 16000 );
    expect( bytes, size, RF_ERROR_FORMAT, "truncated" );
    const char* hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16000 +X 16000\n";
    expect( (const uint8_t*)hdr, strlen( hdr ), RF_ERROR_UNSUPPORTED, "takes 2929 MiB" );
    hdr = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n1234";
    expect( (const uint8_t*)hdr, strlen( hdr ), RF_ERROR_FORMAT, "damaged HDR" );
    uint8_t grey[3] = { 1, 2, 3 };
    AUTO_FREE uint8_t* jpeg = encode_jpeg( 1, 1, 3, grey, &size );
    for ( size_t i = 0; i + 8 < size; ++i )
    {
        if ( jpeg[i] == 0xff && jpeg[i + 1] == 0xc0 )
            memset( jpeg + i + 5, 0xfe, 4 );
    }
    expect( jpeg, size, RF_ERROR_UNSUPPORTED, "65278x65278" );
}

static const char* save( const uint8_t* bytes, size_t size )
{
    static char path[64];
    snprintf( path, sizeof path, "/tmp/reframe-map-%d", (int)getpid() );
    FILE* file = fopen( path, "wb" );
    assert_non_null( file );
    assert_int_equal( fwrite( bytes, 1, size, file ), size );
    fclose( file );
    return path;
}

TEST( test_environment_map )
{
    float reals[4 * 2 * 3];
    for ( int i = 0; i < 24; ++i )
        reals[i] = (float)( i * i );
    size_t size;
    int width, height;
    float* rgb;
    double outside;
    RfError error = { 0 };
    uint8_t* bytes = encode_exr( 4, 2, reals, &size );
    assert_int_equal( rf_load_environment_map( save( bytes, size ), &width, &height, &rgb, &outside, &error ), RF_OK );
    assert_int_equal( width, 4 );
    assert_int_equal( height, 2 );
    assert_memory_equal( rgb, reals, sizeof reals );
    free( rgb );
    free( bytes );

    static const float bad[] = { -1.0f, NAN, INFINITY };
    for ( int k = 0; k < 3; ++k )
    {
        reals[3 * 6 + 1] = bad[k]; // pixel (2, 1)
        bytes = encode_exr( 4, 2, reals, &size );
        assert_int_equal( rf_load_environment_map( save( bytes, size ), &width, &height, &rgb, &outside, &error ),
                          RF_ERROR_FORMAT );
        assert_non_null( strstr( error.text, "pixel (2, 1) is" ) );
        assert_null( rgb );
        free( bytes );
    }

    // 8 bits are sRGB, and grey is spread
    uint8_t grey[] = { 0, 128, 255 };
    bytes = encode_png( 3, 1, 1, grey, &size );
    assert_int_equal( rf_load_environment_map( save( bytes, size ), &width, &height, &rgb, &outside, &error ), RF_OK );
    assert_true( rgb[0] == 0.0f && fabsf( rgb[8] - 1.0f ) < 1e-6f );
    for ( int c = 3; c < 6; ++c )
        assert_true( fabsf( rgb[c] - 0.2158605f ) < 1e-6f );
    free( rgb );
    free( bytes );
    unlink( save( grey, 3 ) );
    assert_int_equal( rf_load_environment_map( "/nowhere/sky.exr", &width, &height, &rgb, &outside, &error ), RF_ERROR_IO );
}
