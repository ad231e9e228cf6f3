// Scene values of the report page are those of the image, coarser as its budget wants it; AOVs are
// drawn so that their values can be read back.
#include "image/half.h"
#include "page/picture.h"
#include "page/page.h"
#include "support/image_support.h"
#include "support/test.h"

static int get16( const unsigned char* bytes ) { return bytes[0] | bytes[1] << 8; }

static float value_at( const unsigned char* bytes, int x, int y, int c )
{
    int columns = get16( bytes + 2 );
    return rf_half_to_float( (uint16_t)get16( bytes + RF_VALUES_HEADER_BYTES + 2 * ( 3 * ( y * columns + x ) + c ) ) );
}

static RfImage new_image( int width, int height )
{
    RfImage image;
    assert_int_equal( rf_create_image( width, height, &image, NULL ), RF_OK );
    for ( int i = 0; i < 3 * width * height; ++i )
        image.rgb[i] = (float)( i % 3 == 0 ? i / 3 % width : i % 3 == 1 ? -0.125 : i / 3 / width );
    return image;
}

TEST( test_values_are_those_of_the_image )
{
    AUTO_IMAGE image = new_image( 7, 5 );
    image.rgb[0] = NAN;
    image.rgb[3] = INFINITY;
    image.rgb[6] = -1e9f;
    AUTO_FREE unsigned char* bytes;
    size_t size;
    assert_int_equal( rf_encode_values( &image, 1, "image", &bytes, &size, NULL ), RF_OK );
    assert_true( size == RF_VALUES_HEADER_BYTES + 6 * 35 && get16( bytes ) == 1 && get16( bytes + 2 ) == 7 &&
                 get16( bytes + 4 ) == 5 );
    assert_true( isnan( value_at( bytes, 0, 0, 0 ) ) && isinf( value_at( bytes, 1, 0, 0 ) ) &&
                 value_at( bytes, 2, 0, 0 ) == -65504.0f );
    assert_true( value_at( bytes, 6, 4, 0 ) == 6.0f && value_at( bytes, 6, 4, 1 ) == -0.125f &&
                 value_at( bytes, 6, 4, 2 ) == 4.0f );
}

TEST( test_coarse_values_are_means )
{
    AUTO_IMAGE image = new_image( 7, 5 );
    AUTO_FREE unsigned char* bytes;
    size_t size;
    assert_int_equal( rf_encode_values( &image, 3, "image", &bytes, &size, NULL ), RF_OK );
    assert_true( get16( bytes ) == 3 && get16( bytes + 2 ) == 3 && get16( bytes + 4 ) == 2 &&
                 size == RF_VALUES_HEADER_BYTES + 36 );
    assert_true( value_at( bytes, 1, 0, 0 ) == 4.0f && value_at( bytes, 1, 0, 2 ) == 1.0f );
    assert_true( value_at( bytes, 2, 1, 0 ) == 6.0f && value_at( bytes, 2, 1, 2 ) == 3.5f ); // cropped to 1×2
}

// The factor is the smallest that fits.
TEST( test_values_stay_within_their_bytes )
{
    for ( double most = 500.0; most < 6e6; most *= 1.7 )
    {
        int factor = rf_values_factor( 960, 540, most );
        assert_true( factor == 0 || rf_values_page_bytes( 960, 540, factor ) <= most );
        assert_true( factor == 1 || rf_values_page_bytes( 960, 540, factor > 0 ? factor - 1 : RF_VALUES_MAX_FACTOR ) > most );
    }
    assert_int_equal( rf_values_factor( 960, 540, 5e6 ), 1 );
    assert_int_equal( rf_values_factor( 960, 540, 0.0 ), 0 );
}

// What a display shows of light, 0 to 1.
static double display( double light ) { return light <= 0.0031308 ? 12.92 * light : 1.055 * pow( light, 1.0 / 2.4 ) - 0.055; }

TEST( test_looks_can_be_read_back )
{
    float rgb[9];
    const float normals[9] = { 0.6f, 0.0f, -0.8f, 0.0f, 0.0f, 0.0f, NAN, 1.0f, 0.0f };
    rf_draw_look( RF_LOOK_NORMAL, ( RfLookRange ){ 0 }, normals, 3, 3, rgb );
    assert_true( fabs( 2.0 * display( rgb[0] ) - 1.0 - 0.6 ) < 0.003 && fabs( 2.0 * display( rgb[2] ) - 1.0 + 0.8 ) < 0.003 );
    assert_true( rgb[3] == 0.0f && rgb[4] == 0.0f && rgb[5] == 0.0f && isnan( rgb[6] ) );
    const float depths[3] = { 2.0f, 8.0f, 1e10f };
    RfLookRange range = rf_look_range( RF_LOOK_DEPTH, depths, 1, 3 );
    assert_true( range.low == 2.0f && range.high == 8.0f );
    const float middle[3] = { 4.0f, 2.0f, 1e10f };
    rf_draw_look( RF_LOOK_DEPTH, range, middle, 1, 3, rgb );
    assert_true( fabs( display( rgb[0] ) - 0.55 ) < 0.001 && display( rgb[3] ) > 0.999 && rgb[6] == 0.0f );
    const float motion[6] = { 3.0f, -1.0f, 0.0f, 0.0f, -3.0f, 1.5f };
    range = rf_look_range( RF_LOOK_MOTION, motion, 2, 3 );
    rf_draw_look( RF_LOOK_MOTION, range, motion, 2, 3, rgb );
    assert_true( range.high == 3.0f && display( rgb[0] ) > 0.999 && fabs( display( rgb[1] ) - 1.0 / 3.0 ) < 0.001 );
    assert_true( fabs( display( rgb[3] ) - 0.5 ) < 0.001 && rgb[6] == 0.0f && fabs( display( rgb[7] ) - 0.75 ) < 0.001 );
    const float variance[3] = { 4.0f, 0.25f, -1.0f };
    rf_draw_look( RF_LOOK_DEVIATION, range, variance, 3, 1, rgb );
    assert_true( rgb[0] == 2.0f && rgb[1] == 0.5f && rgb[2] == 0.0f );
}

// Nothing to see gives no division by zero.
TEST( test_empty_ranges_are_finite )
{
    float rgb[3];
    for ( int look = RF_LOOK_DEPTH; look <= RF_LOOK_SHARE; ++look )
    {
        const float values[2][2] = { { 1e10f, 0.0f }, { 0.0f, 0.0f } };
        for ( int k = 0; k < 2; ++k )
        {
            RfLookRange range = rf_look_range( (RfLook)look, values[k], 2, 1 );
            rf_draw_look( (RfLook)look, range, values[k], 2, 1, rgb );
            assert_true( isfinite( rgb[0] ) && isfinite( rgb[1] ) && isfinite( rgb[2] ) );
        }
    }
    const float flat[2] = { 3.0f, 3.0f };
    RfLookRange range = rf_look_range( RF_LOOK_DEPTH, flat, 1, 2 );
    rf_draw_look( RF_LOOK_DEPTH, range, flat, 1, 1, rgb );
    assert_true( isfinite( rgb[0] ) && rgb[0] > 0.0f );
}
