// Pictures of the report page survive their encoding at any exposure and stay within their
// size. They are read back as src/page/picture.h says, with the texture decoder, as a
// third opinion beside the script and the encoder.
#include "image/decode.h"
#include "page/picture.h"
#include "support/image_support.h"
#include "support/test.h"

static RfImage new_image( int width, int height )
{
    RfImage image;
    assert_int_equal( rf_create_image( width, height, &image, NULL ), RF_OK );
    return image;
}

static int get16( const unsigned char* bytes ) { return bytes[0] | bytes[1] << 8; }

static double base_at( const unsigned char* base, int columns, int rows, int cell, int x, int y, int c )
{
    double u = ( x + 0.5 ) / cell - 0.5, v = ( y + 0.5 ) / cell - 0.5, sum = 0.0;
    for ( int k = 0; k < 4; ++k )
    {
        int i = (int)floor( u ) + k % 2, j = (int)floor( v ) + k / 2;
        double weight = ( 1.0 - fabs( u - i ) ) * ( 1.0 - fabs( v - j ) );
        i = i < 0 ? 0 : i < columns ? i : columns - 1;
        j = j < 0 ? 0 : j < rows ? j : rows - 1;
        sum += weight * (int16_t)get16( base + 2 * ( 3 * ( j * columns + i ) + c ) );
    }
    return sum / 256.0;
}

static RfImage decode( const unsigned char* bytes, size_t size )
{
    int cell = get16( bytes ), columns = get16( bytes + 2 ), rows = get16( bytes + 4 );
    const unsigned char* base = bytes + 6;
    size_t before = 6 + 6 * (size_t)columns * (size_t)rows;
    RfPixels pixels;
    RfError error = { 0 };
    if ( rf_decode_image( bytes + before, size - before, "detail", &pixels, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    assert_true( pixels.channels == 3 && pixels.type == RF_PIXELS_U8 );
    assert_true( columns == ( pixels.width + cell - 1 ) / cell && rows == ( pixels.height + cell - 1 ) / cell );
    RfImage image = new_image( pixels.width, pixels.height );
    for ( int i = 0; i < 3 * pixels.width * pixels.height; ++i )
    {
        int steps = ( (const unsigned char*)pixels.data )[i] - 128;
        double stops = copysign( 0.5 * ( exp( abs( steps ) / 32.0 ) - 1.0 ), steps );
        double level = base_at( base, columns, rows, cell, i / 3 % pixels.width, i / 3 / pixels.width, i % 3 ) + stops;
        image.rgb[i] = (float)( exp2( level ) - 1.0 / 512.0 );
    }
    rf_destroy_pixels( &pixels );
    return image;
}

static RfImage through( const RfImage* image, size_t* size )
{
    unsigned char* bytes;
    RfError error = { 0 };
    if ( rf_encode_picture( image, RF_PICTURE_MAX_BITS, "picture", &bytes, size, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    RfImage back = decode( bytes, *size );
    assert_true( back.width == image->width && back.height == image->height );
    free( bytes );
    return back;
}

// The byte that a display is given.
static int display( double light, int stops )
{
    double value = ldexp( light, stops );
    if ( !( value > 0.0 ) )
        return 0;
    return value >= 1.0 ? 255
                        : (int)lround( 255.0 * ( value <= 0.0031308 ? 12.92 * value : 1.055 * pow( value, 1.0 / 2.4 ) - 0.055 ) );
}

// A slow ramp over 12 stops, slanted, in three colours: at −4 to 4 stops no byte of the
// display is off by more than 3, nor do two neighbours differ by more than 3, which is what
// a band would be: the steps of a plain 8-bit logarithm of 26 stops are 8 in the lights.
TEST( test_ramps_show_no_bands )
{
    AUTO_IMAGE image = new_image( 600, 200 );
    for ( int i = 0; i < 3 * 600 * 200; ++i )
        image.rgb[i] = exp2f( -7.0f + ( (float)( i / 3 % 600 ) + 0.3f * (float)( i / 1800 ) ) / 55.0f + 0.3f * (float)( i % 3 ) );
    size_t size;
    AUTO_IMAGE back = through( &image, &size );
    for ( int stops = -4; stops <= 4; ++stops )
    {
        int most = 0, step = 0;
        for ( int i = 0; i < 3 * 600 * 200; ++i )
        {
            int is = display( back.rgb[i], stops ), off = abs( is - display( image.rgb[i], stops ) );
            most = off > most ? off : most;
            int jump = i / 3 % 600 > 0 ? abs( is - display( back.rgb[i - 3], stops ) ) : 0;
            step = jump > step ? jump : step;
        }
        if ( most > 3 || step > 3 )
            fail_msg( "%d stops: a byte is off by %d, neighbours differ by %d", stops, most, step );
    }
    assert_true( size < 600 * 200 );
}

// Flat areas of any brightness come back to 1 %, whatever their neighbours are.
TEST( test_flat_areas_come_back )
{
    static const float levels[6] = { 0.0f, 0.01f, 0.18f, 1.0f, 40.0f, 60000.0f };
    AUTO_IMAGE image = new_image( 6 * 64, 64 );
    for ( int i = 0; i < 3 * 6 * 64 * 64; ++i )
        image.rgb[i] = levels[i / 3 % ( 6 * 64 ) / 64];
    size_t size;
    AUTO_IMAGE back = through( &image, &size );
    for ( int k = 0; k < 6; ++k )
    {
        float found = back.rgb[3 * ( 32 * 6 * 64 + k * 64 + 32 )];
        if ( !( fabsf( found - levels[k] ) <= 0.01f * levels[k] + 1e-4f ) )
            fail_msg( "%g came back as %g", levels[k], found );
    }
}

// A firefly does not spoil what is about it, and stays bright.
TEST( test_fireflies_spoil_no_neighbour )
{
    AUTO_IMAGE image = new_image( 100, 70 );
    for ( int i = 0; i < 3 * 7000; ++i )
        image.rgb[i] = 0.25f;
    for ( int c = 0; c < 3; ++c )
        image.rgb[3 * ( 35 * 100 + 50 ) + c] = 5000.0f;
    size_t size;
    AUTO_IMAGE back = through( &image, &size );
    assert_true( back.rgb[3 * ( 35 * 100 + 50 )] > 500.0f );
    double worst = 0.0;
    for ( int i = 0; i < 7000; ++i )
    {
        if ( abs( i % 100 - 50 ) > 16 || abs( i / 100 - 35 ) > 16 )
            worst = fmax( worst, fabs( back.rgb[3 * i] / 0.25 - 1.0 ) );
    }
    assert_true( worst < 0.02 );
}

// What is no number shows: magenta, brighter than white; infinity is the brightest.
TEST( test_nan_and_infinity_show )
{
    AUTO_IMAGE image = new_image( 48, 48 );
    for ( int i = 0; i < 3 * 48 * 48; ++i )
        image.rgb[i] = i / 3 % 48 < 16 ? ( i % 3 == 1 ? NAN : -5.0f ) : i / 3 % 48 < 32 ? INFINITY : -INFINITY;
    size_t size;
    AUTO_IMAGE back = through( &image, &size );
    const float *nan = back.rgb + 3 * ( 24 * 48 + 4 ), *inf = back.rgb + 3 * ( 24 * 48 + 24 ),
                *dark = back.rgb + 3 * ( 24 * 48 + 44 );
    assert_true( nan[0] > 8.0f && nan[1] < 0.1f && nan[2] > 8.0f );
    assert_true( inf[0] > 30000.0f && dark[0] < 0.01f );
}

// The worst of noise: 48 frames of 960x540 stay below 40 MB as base64.
TEST( test_noise_stays_below_40_mb )
{
    AUTO_IMAGE image = make_image( 960, 540, 77 );
    unsigned char* bytes;
    size_t size;
    assert_int_equal( rf_encode_picture( &image, RF_PICTURE_MAX_BITS, "noise", &bytes, &size, NULL ), RF_OK );
    assert_true( 48.0 * 4.0 / 3.0 * (double)size < 39e6 );
    free( bytes );
    // and keep tighter limits, as AOVs have them
    assert_int_equal( rf_encode_picture( &image, 2.5, "noise", &bytes, &size, NULL ), RF_OK );
    if ( (double)size > 960.0 * 540.0 * 2.6 / 8.0 + 20000.0 )
        fail_msg( "%zu bytes, %.2f bits per pixel", size, 8.0 * (double)size / ( 960.0 * 540.0 ) );
    free( bytes );
}

TEST( test_small_and_refused )
{
    static const int sizes[][2] = { { 1, 1 }, { 17, 1 }, { 1, 33 }, { 15, 16 }, { 16, 17 } };
    for ( size_t k = 0; k < sizeof sizes / sizeof sizes[0]; ++k )
    {
        AUTO_IMAGE image = new_image( sizes[k][0], sizes[k][1] );
        for ( int i = 0; i < 3 * image.width * image.height; ++i )
            image.rgb[i] = 0.5f;
        size_t size;
        AUTO_IMAGE back = through( &image, &size );
        for ( int i = 0; i < 3 * image.width * image.height; ++i )
            assert_true( fabsf( back.rgb[i] - 0.5f ) < 0.005f );
    }
    unsigned char* bytes;
    size_t size;
    RfError error;
    RfImage wide = { 65501, 1, NULL };
    assert_int_equal( rf_encode_picture( &wide, RF_PICTURE_MAX_BITS, "wide", &bytes, &size, &error ), RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "wide: an image of 65501x1" ) );
}

TEST( test_shrinking_takes_means )
{
    AUTO_IMAGE image = new_image( 5, 3 ), small;
    for ( int i = 0; i < 45; ++i )
        image.rgb[i] = (float)( i / 3 );
    image.rgb[3 * 14] = NAN;
    assert_int_equal( rf_shrink_image( &image, 2, &small, NULL ), RF_OK );
    assert_true( small.width == 3 && small.height == 2 );
    assert_true( small.rgb[0] == 3.0f && small.rgb[3 * 2] == 6.5f && small.rgb[3 * 3] == 10.5f && isnan( small.rgb[3 * 5] ) &&
                 small.rgb[3 * 5 + 1] == 14.0f );
}
