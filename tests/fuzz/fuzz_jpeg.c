// JPEG images, as textures and environment maps.
#include "fuzz/fuzz.h"

#include "image/decode_formats.h"

#include <stdlib.h>

int LLVMFuzzerTestOneInput( const uint8_t* data, size_t size )
{
    RfError error = { 0 };
    RfPixels pixels = { 0 };
    RfEncoded in = { data, size, "input.jpeg", false };
    fuzz_check( rf_decode_jpeg( &in, &pixels, &error ), &error );
    rf_destroy_pixels( &pixels );
    int width, height;
    float* rgb = NULL;
    double outside;
    fuzz_check( rf_decode_environment_map( data, size, "input.jpeg", &width, &height, &rgb, &outside, &error ), &error );
    free( rgb );
    return 0;
}
