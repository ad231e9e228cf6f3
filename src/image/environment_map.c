// Loads equirectangular environment maps as linear RGB.
#include "base/file.h"
#include "image/decode.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#define MAX_FILE_BYTES ( (uint64_t)2 << 30 )

float rf_srgb_to_linear( float encoded )
{
    return encoded <= 0.04045f ? encoded / 12.92f : powf( ( encoded + 0.055f ) / 1.055f, 2.4f );
}

static float value_at( const RfPixels* pixels, size_t i )
{
    if ( pixels->type == RF_PIXELS_FLOAT )
        return ( (const float*)pixels->data )[i];
    return rf_srgb_to_linear( pixels->type == RF_PIXELS_U8 ? (float)( (const uint8_t*)pixels->data )[i] / 255.0f
                                                           : (float)( (const uint16_t*)pixels->data )[i] / 65535.0f );
}

#define MAX_RADIANCE 1e15f

static RfResult fill( const RfPixels* pixels, const char* path, float* rgb, RfError* error )
{
    bool grey = pixels->channels < 3;
    size_t width = (size_t)pixels->width, count = width * (size_t)pixels->height, channels = (size_t)pixels->channels;
    for ( size_t i = 0; i < count; ++i )
    {
        for ( size_t c = 0; c < 3; ++c )
        {
            float value = value_at( pixels, i * channels + ( grey ? 0 : c ) );
            // written so that NaN fails; brighter values would overflow floats in later products
            if ( !( value >= 0.0f && value <= MAX_RADIANCE ) )
                return rf_fail( error, RF_ERROR_FORMAT,
                                "%s: pixel (%zu, %zu) is %g, but light must be a number from 0 to %g: repair the image", path,
                                i % width, i / width, (double)value, (double)MAX_RADIANCE );
            rgb[3 * i + c] = value;
        }
    }
    return RF_OK;
}

// Converts to linear floats; takes ownership of the pixels.
static RfResult convert( RfPixels* pixels, const char* path, float** rgb, RfError* error )
{
    size_t count = (size_t)pixels->width * (size_t)pixels->height;
    *rgb = malloc( count * 3 * sizeof **rgb );
    RfResult result = *rgb != NULL ? fill( pixels, path, *rgb, error )
                                   : rf_fail( error, RF_ERROR_MEMORY, "%s: the system has no %zu MiB left for its pixels", path,
                                              count * 12 >> 20 );
    if ( result == RF_OK )
        return RF_OK;
    free( *rgb );
    *rgb = NULL;
    return result;
}

RfResult rf_decode_environment_map( const void* bytes, size_t size, const char* name, int* width, int* height, float** rgb,
                                    RfError* error )
{
    *width = *height = 0;
    *rgb = NULL;
    RfPixels pixels;
    RfResult result = rf_decode_image( bytes, size, name, &pixels, error );
    if ( result != RF_OK )
        return result;
    result = convert( &pixels, name, rgb, error );
    if ( result == RF_OK )
    {
        *width = pixels.width;
        *height = pixels.height;
    }
    rf_destroy_pixels( &pixels );
    return result;
}

RfResult rf_load_environment_map( const char* path, int* width, int* height, float** rgb, RfError* error )
{
    *width = *height = 0;
    *rgb = NULL;
    uint8_t* bytes;
    size_t size;
    RfResult result = rf_read_file( path, MAX_FILE_BYTES, &bytes, &size, error );
    if ( result != RF_OK )
        return result;
    result = rf_decode_environment_map( bytes, size, path, width, height, rgb, error );
    free( bytes );
    return result;
}
