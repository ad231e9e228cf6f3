// EXR: as a texture from memory, and as a file with layers, parts and attributes.
#include "fuzz/fuzz.h"

#include "image/decode_formats.h"
#include "image/exr.h"
#include "page/pass_groups.h"

#include <stdlib.h>

static void decode( const uint8_t* data, size_t size )
{
    RfError error = { 0 };
    RfPixels pixels = { 0 };
    RfEncoded in = { data, size, "input.exr", false };
    fuzz_check( rf_decode_exr( &in, &pixels, &error ), &error );
    rf_destroy_pixels( &pixels );
}

static void read_channels( const char* path, const RfExrHeader* header )
{
    RfError error = { 0 };
    RfExrWindow window;
    RfImage image = { 0 };
    for ( int i = 0; i < header->channel_count && i < 8; ++i )
    {
        const char* names[] = { header->channels[i].text };
        float* values = NULL;
        fuzz_check( rf_read_exr_channels( path, names, 1, &window, &values, &error ), &error );
        free( values );
    }
    if ( header->channel_count == 0 )
        return;
    fuzz_check( rf_read_exr_layer( path, header->channels[0].text, &image, &window, &error ), &error );
    rf_destroy_image( &image );
}

// What a page shows of it.
static void draw_passes( const char* path, const RfExrHeader* header )
{
    RfError error = { 0 };
    RfFilePasses passes;
    fuzz_check( rf_list_passes( header, &passes, &error ), &error );
    for ( int i = 0; i < passes.count && i < 8; ++i )
    {
        const RfFilePass* pass = passes.passes + i;
        RfMatteNames names;
        RfExrWindow window;
        RfImage image = { 0 };
        float* values = NULL;
        int stride;
        RfResult result = rf_read_passes( path, pass, 1, &window, &values, &stride, &error );
        fuzz_check( result, &error );
        if ( result == RF_OK && rf_create_image( window.width, window.height, &image, NULL ) == RF_OK )
        {
            size_t pixels = (size_t)image.width * (size_t)image.height;
            RfLookRange range = rf_pass_range( pass, values, (size_t)stride, pixels );
            rf_draw_pass( pass, range, values, (size_t)stride, pixels, image.rgb );
        }
        fuzz_check( rf_read_matte_names( path, pass, &names, &error ), &error );
        rf_free_matte_names( &names );
        rf_destroy_image( &image );
        free( values );
    }
    rf_free_passes( &passes );
}

static void take_string( void* user, const char* name, const char* value ) { *(size_t*)user += name[0] + value[0]; }

int LLVMFuzzerTestOneInput( const uint8_t* data, size_t size )
{
    decode( data, size );
    const char* path = fuzz_file( "input.exr", data, size );
    RfError error = { 0 };
    RfImage image = { 0 };
    RfExrHeader header = { 0 };
    size_t sum = 0;
    char value[64];
    bool same;
    fuzz_check( rf_verify_exr( path, &same, &error ), &error );
    fuzz_check( rf_read_exr( path, &image, &error ), &error );
    rf_destroy_image( &image );
    RfResult result = rf_read_exr_header( path, NULL, &header, &error );
    fuzz_check( result, &error );
    if ( result == RF_OK )
    {
        read_channels( path, &header );
        draw_passes( path, &header );
    }
    rf_destroy_exr_header( &header );
    fuzz_check( rf_list_exr_strings( path, take_string, &sum, &error ), &error );
    fuzz_check( rf_read_exr_string( path, "reframe/fingerprint", value, sizeof value, &error ), &error );
    return 0;
}
