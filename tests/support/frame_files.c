#include "support/frame_files.h"

#include "image/sequence.h"
#include "support/cli_run.h"
#include "support/test.h"

RfFlickerFrame make_frame( int number )
{
    RfFlickerFrame frame = { .number = number, .is_finite = true };
    assert_int_equal( rf_create_image( WIDTH, HEIGHT, &frame.signal, NULL ), RF_OK );
    return frame;
}

float* make_layer( int channels, float value )
{
    float* layer = malloc( (size_t)( channels * PIXELS ) * sizeof( float ) );
    assert_non_null( layer );
    for ( int i = 0; i < channels * PIXELS; ++i )
        layer[i] = value;
    return layer;
}

void set_motion( RfFlickerFrame* frame, float x, float y )
{
    if ( frame->motion == NULL )
        frame->motion = make_layer( 2, 0.0f );
    for ( int i = 0; i < PIXELS; ++i )
    {
        frame->motion[2 * i] = x;
        frame->motion[2 * i + 1] = y;
    }
}

// Mean 0, variance 1 (sum of twelve uniforms).
static float normal( uint32_t* seed )
{
    double sum = -6.0;
    for ( int i = 0; i < 12; ++i )
        sum += next_random( seed ) * 0x1p-32;
    return (float)sum;
}

void fill_noise( RfFlickerFrame* frame, uint32_t seed, float scale )
{
    for ( int i = 0; i < 100; ++i ) // neighbouring seeds begin alike
        next_random( &seed );
    for ( int i = 0; i < VALUES; ++i )
        frame->signal.rgb[i] = scale * normal( &seed );
}

RfFlickerSums measure( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate, bool has_error )
{
    RfFlickerSums sums;
    RfError error = { 0 };
    if ( rf_measure_flicker( now, before, compensate, has_error, &sums, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return sums;
}

RfFlickerMetrics measured( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate, bool has_error )
{
    RfFlickerSums sums = measure( now, before, compensate, has_error );
    return rf_flicker_metrics( &sums );
}

void check_near( double value, double wanted, double tolerance )
{
    if ( !( fabs( value - wanted ) <= tolerance ) )
        fail_msg( "%.17g, not %.17g within %g", value, wanted, tolerance );
}

// ---- page checks ----

void page_write_frame( const char* name, int width, int height, float value, const RfExrString* strings, int count )
{
    RfImage image;
    RfError error = { 0 };
    assert_int_equal( rf_create_image( width, height, &image, &error ), RF_OK );
    for ( int i = 0; i < 3 * width * height; ++i )
        image.rgb[i] = value;
    RfExrOptions options = rf_default_exr_options();
    options.half = false;
    options.strings = strings;
    options.string_count = count;
    if ( rf_write_exr( cli_path( name ), &image, &options, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    rf_destroy_image( &image );
}

void page_write_frames( const char* pattern, int first, int last, float value, float step )
{
    char name[256];
    for ( int frame = first; frame <= last; ++frame )
    {
        assert_int_equal( rf_sequence_name( pattern, frame, name, sizeof name, NULL ), RF_OK );
        page_write_frame( name, 40, 30, value + step * (float)( frame - first ), NULL, 0 );
    }
}

void page_make_folder( const char* name ) { cli_expect( cli_run( "mkdir -p '%s'", name ), 0, NULL ); }

int page_count( const char* text, const char* part )
{
    int count = 0;
    for ( const char* at = strstr( text, part ); at != NULL; at = strstr( at + 1, part ) )
        ++count;
    return count;
}

json_t* page_read_data( const char* page, int blocks )
{
    static const char begin[] = "<script type=\"application/json\" id=\"data\">";
    size_t size;
    char* text = cli_read( page, &size );
    assert_int_equal( strlen( text ), size );
    char* data = strstr( text, begin );
    assert_non_null( data );
    data += strlen( begin );
    assert_int_equal( page_count( text, "<script type=\"text/plain\" id=\"s" ), blocks );
    int scripts = page_count( text, "<script type=\"text/plain\" id=\"" ) + 2; // the data, the script itself
    assert_int_equal( page_count( text, "<script" ), scripts );
    assert_int_equal( page_count( text, "</script" ), scripts );
    assert_int_equal( page_count( text, "{{" ), 0 );
    assert_int_equal( page_count( text, "http://" ), 1 ); // the name of SVG
    assert_int_equal( page_count( text, "https://" ), 0 );
    *strstr( data, "</script>" ) = '\0';
    json_error_t reason;
    json_t* json = json_loads( data, 0, &reason );
    if ( json == NULL )
        fail_msg( "%s: %s", page, reason.text );
    free( text );
    return json;
}

const json_t* page_sequence( const json_t* data, size_t index )
{
    const json_t* sequence = json_array_get( json_object_get( data, "sequences" ), index );
    assert_non_null( sequence );
    return sequence;
}

const json_t* page_item( const json_t* sequence, const char* key, size_t i )
{
    const json_t* value = json_array_get( json_object_get( sequence, key ), i );
    assert_non_null( value );
    return value;
}

void page_check_item( const json_t* sequence, const char* key, size_t i, double wanted )
{
    const json_t* value = page_item( sequence, key, i );
    if ( !json_is_number( value ) || !( fabs( json_number_value( value ) - wanted ) <= 1e-6 * ( 1e-6 + fabs( wanted ) ) ) )
        fail_msg( "%s %zu: %g, not %g", key, i, json_number_value( value ), wanted );
}

const char* page_fact( const json_t* sequence, const char* group, const char* label )
{
    size_t i;
    const json_t* row;
    json_array_foreach( json_object_get( sequence, "facts" ), i, row )
    {
        if ( strcmp( json_string_value( json_array_get( row, 0 ) ), group ) == 0 &&
             strcmp( json_string_value( json_array_get( row, 1 ) ), label ) == 0 )
            return json_string_value( json_array_get( row, 2 ) );
    }
    return NULL;
}
