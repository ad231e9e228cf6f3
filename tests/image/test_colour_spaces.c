// EXR files in other primaries than Rec. 709: what is read is converted, what is no colour is not.
#include "image/colour.h"
#include "support/image_support.h"
#include "support/test.h"

#define WIDTH 5
#define HEIGHT 3
#define PIXELS ( WIDTH * HEIGHT )

// Linear Rec. 709 to ACEScg and back, by Bradford, as OpenColorIO's ACES configurations have them (CG-Config 1.0).
static const float s_to_acescg[3][3] = { { 0.6130974f, 0.3395231f, 0.0473795f },
                                         { 0.0701937f, 0.9163539f, 0.0134524f },
                                         { 0.0206156f, 0.1095698f, 0.8698147f } };
static const float s_to_rec709[3][3] = { { 1.7050510f, -0.6217921f, -0.0832589f },
                                         { -0.1302564f, 1.1408047f, -0.0105483f },
                                         { -0.0240034f, -0.1289690f, 1.1529723f } };

TEST( test_matrices )
{
    const RfChromaticities *rec709 = rf_chromaticities_of( RF_REC709 ), *acescg = rf_chromaticities_of( RF_ACESCG );
    RfColourConversion to, from;
    assert_true( rf_convert_between( rec709, acescg, &to ) && rf_convert_between( acescg, rec709, &from ) );
    for ( int i = 0; i < 9; ++i )
    {
        assert_true( fabsf( to.matrix[i / 3][i % 3] - s_to_acescg[i / 3][i % 3] ) < 2e-5f );
        assert_true( fabsf( from.matrix[i / 3][i % 3] - s_to_rec709[i / 3][i % 3] ) < 2e-5f );
    }
    // XYZ has primaries at the corners, ACES2065-1 one of negative y: white stays white
    RfChromaticities others[2] = { { { { 1.0f, 0.0f }, { 0.0f, 1.0f }, { 0.0f, 0.0f }, { 1.0f / 3.0f, 1.0f / 3.0f } } },
                                   { { { 0.7347f, 0.2653f }, { 0.0f, 1.0f }, { 0.0001f, -0.077f }, { 0.32168f, 0.33767f } } } };
    for ( int k = 0; k < 2; ++k )
    {
        float white[3] = { 2.0f, 2.0f, 2.0f };
        assert_true( rf_convert_between( others + k, rec709, &to ) && to.needed );
        rf_convert_colours( &to, RF_COLOUR_LIGHT, white, 1, 3 );
        for ( int c = 0; c < 3; ++c )
            assert_true( fabsf( white[c] - 2.0f ) < 1e-5f );
    }
    RfChromaticities rounded = *rec709;
    rounded.xy[3][0] = 0.31271f;
    assert_true( rf_convert_between( &rounded, rec709, &to ) && !to.needed );
    // a line, a white point outside, none, no number
    for ( int k = 0; k < 4; ++k )
    {
        RfChromaticities bad = *acescg;
        bad.xy[k == 0 ? 1 : 3][0] = k == 0 ? bad.xy[0][0] : k == 1 ? 0.9f : k == 2 ? 0.3f : NAN;
        bad.xy[k == 0 ? 1 : 3][1] = k == 0 ? bad.xy[0][1] : k == 2 ? 0.0f : bad.xy[3][1];
        assert_false( rf_convert_between( &bad, rec709, &to ) );
    }
}

static float s_colour[3 * PIXELS], s_layers[5][3 * PIXELS];

// A picture and layers in ACEScg, each in a part of its own.
static void write_layers( const char* path, RfColourSpace space )
{
    static const char* const s_names[5][3] = { { "light_key.R", "light_key.G", "light_key.B" },
                                               { "variance.R", "variance.G", "variance.B" },
                                               { "normal.X", "normal.Y", "normal.Z" },
                                               { "R", "G", "B" }, // of a part that is the layer
                                               { "V.CryptoMaterial00.r", "V.CryptoMaterial00.g", "V.CryptoMaterial00.b" } };
    static const RfExrMeaning s_meanings[5] = { RF_EXR_COLOUR, RF_EXR_VARIANCE };
    static const char* const s_parts[5] = { NULL, "variance", NULL, "crypto_object00", NULL };
    RfExrChannel channels[15];
    for ( int i = 0; i < 3 * PIXELS; ++i )
    {
        s_colour[i] = (float)( i % 7 ) * 0.5f;
        for ( int k = 0; k < 5; ++k )
            s_layers[k][i] = (float)( i * ( k + 2 ) % 11 ) * 0.25f;
    }
    for ( int i = 0; i < 15; ++i )
        channels[i] = ( RfExrChannel ){ .name = s_names[i / 3][i % 3],
                                        .values = s_layers[i / 3] + i % 3,
                                        .stride = 3,
                                        .part = s_parts[i / 3],
                                        .meaning = s_meanings[i / 3],
                                        .component = i % 3 };
    RfExrOptions options = rf_default_exr_options();
    options.half = false;
    options.colour_space = space;
    options.channels = channels;
    options.channel_count = 15;
    RfImage image = { .width = WIDTH, .height = HEIGHT, .rgb = s_colour };
    assert_int_equal( rf_write_exr( path, &image, &options, NULL ), RF_OK );
}

static void check_near( const float* values, const float* wanted, int stride )
{
    for ( int i = 0; i < 3 * PIXELS; ++i )
        assert_true( fabsf( values[i / 3 * stride + i % 3] - wanted[i] ) <= 2e-6f * ( 1.0f + 3.0f * fabsf( wanted[i] ) ) );
}

TEST( test_what_is_read_is_rec709 )
{
    static const char* const s_layer_names[5] = { "light_key", "variance", "normal", "crypto_object00", NULL };
    const char* path = cli_path( "a.exr" );
    RfExrWindow window;
    RfImage image;
    write_layers( path, RF_ACESCG );
    assert_int_equal( rf_read_exr( path, &image, NULL ), RF_OK );
    check_near( image.rgb, s_colour, 3 );
    rf_destroy_image( &image );
    for ( int k = 0; k < 4; ++k )
    {
        assert_int_equal( rf_read_exr_layer( path, s_layer_names[k], &image, &window, NULL ), RF_OK );
        check_near( image.rgb, s_layers[k], 3 );
        rf_destroy_image( &image );
    }
    static const char* const s_all[] = { "normal.X",   "light_key.R", "light_key.G", "light_key.B", "variance.R",
                                         "variance.G", "variance.B",  "R",           "G",           "B" };
    float* values;
    assert_int_equal( rf_read_exr_channels( path, s_all, 10, &window, &values, NULL ), RF_OK );
    check_near( values + 1, s_layers[0], 10 );
    check_near( values + 4, s_layers[1], 10 );
    check_near( values + 7, s_colour, 10 );
    free( values );
    // and the file has what another program reads as ACEScg
    static const char* const s_single[] = { "R", "light_key.G", "V.CryptoMaterial00.r", "V.CryptoMaterial00.g",
                                            "V.CryptoMaterial00.b" };
    assert_int_equal( rf_read_exr_channels( path, s_single, 5, &window, &values, NULL ), RF_OK );
    for ( int i = 0; i < PIXELS; ++i )
    {
        const float *rgb = s_colour + 3 * i, *key = s_layers[0] + 3 * i;
        float red = 0.0f, green = 0.0f;
        for ( int c = 0; c < 3; ++c )
        {
            red += s_to_acescg[0][c] * rgb[c];
            green += s_to_acescg[1][c] * key[c];
            assert_true( values[5 * i + 2 + c] == s_layers[4][3 * i + c] );
        }
        assert_true( fabsf( values[5 * i] - red ) < 1e-4f && fabsf( values[5 * i + 1] - green ) < 1e-4f );
    }
    free( values );
}

// Puts another white point into all parts of a file.
static void set_white( const char* from, const char* to, const float white[2] )
{
    static const char name[] = "chromaticities\0chromaticities\0 \0\0";
    static char bytes[65536];
    FILE* file = fopen( from, "rb" );
    assert_non_null( file );
    size_t size = fread( bytes, 1, sizeof bytes, file );
    fclose( file );
    for ( size_t i = 0; i + 70 < size; ++i )
    {
        if ( memcmp( bytes + i, name, sizeof name - 1 ) == 0 )
            memcpy( bytes + i + sizeof name - 1 + 1 + 24, white, 8 );
    }
    file = fopen( to, "wb" );
    assert_true( file != NULL && fwrite( bytes, 1, size, file ) == size );
    fclose( file );
}

TEST( test_chromaticities_that_are_none )
{
    const char *path = cli_path( "b.exr" ), *bad = cli_path( "bad.exr" );
    static const char* const s_colours[] = { "R", "G", "B" };
    RfError error;
    RfExrWindow window;
    RfImage image;
    float* values;
    write_layers( path, RF_REC709 );
    set_white( path, bad, ( float[2] ){ 0.9f, 0.3f } );
    assert_int_equal( rf_read_exr( bad, &image, &error ), RF_ERROR_FORMAT );
    assert_non_null( strstr( error.text, "bad.exr: its chromaticities do not define a colour space (red 0.64 0.33," ) );
    assert_int_equal( rf_read_exr_layer( bad, "light_key", &image, &window, &error ), RF_ERROR_FORMAT );
    assert_int_equal( rf_read_exr_channels( bad, s_colours, 3, &window, &values, &error ), RF_ERROR_FORMAT );
    assert_int_equal( rf_read_exr_layer( bad, "normal", &image, &window, &error ), RF_OK ); // no colour
    rf_destroy_image( &image );
    // in Rec. 709 not a bit changes
    assert_int_equal( rf_read_exr( path, &image, &error ), RF_OK );
    assert_memory_equal( image.rgb, s_colour, sizeof s_colour );
    rf_destroy_image( &image );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
