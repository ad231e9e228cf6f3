// WebP images, as textures and environment maps.
#include "fuzz/fuzz.h"

#include "image/decode_formats.h"

#include <stdlib.h>

// A flat image takes a few bytes at any size: the parser is meant here, not the time and memory of many pixels.
#define MOST_PIXELS ( 1 << 20 )

int LLVMFuzzerTestOneInput( const uint8_t* data, size_t size )
{
    RfError error = { 0 };
    RfPixels pixels = { 0 };
    RfEncoded in = { data, size, "input.webp", true };
    RfResult result = rf_decode_webp( &in, &pixels, &error );
    if ( result == RF_ERROR_INTERRUPTED && (long)pixels.width * pixels.height > MOST_PIXELS )
        return 0;
    in.header_alone = false;
    fuzz_check( rf_decode_webp( &in, &pixels, &error ), &error );
    rf_destroy_pixels( &pixels );
    int width, height;
    float* rgb = NULL;
    double outside;
    fuzz_check( rf_decode_environment_map( data, size, "input.webp", &width, &height, &rgb, &outside, &error ), &error );
    free( rgb );
    return 0;
}
