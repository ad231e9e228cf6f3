// Makes textures of decoded images, also of those of a sequence.
#include "scene/image_sequence.h"

#include "base/file.h"
#include "reframe/image.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define EARLY 1e-2 // of the time of an image

static size_t value_count( const RfTexture* t ) { return (size_t)t->width * (size_t)t->height * (size_t)t->channels; }

static bool is_alpha( const RfTexture* t, size_t i )
{
    size_t channels = (size_t)t->channels;
    return channels % 2 == 0 && i % channels == channels - 1;
}

// Converts 16-bit pixels to floats.
static RfResult widen( const char* where, const RfPixels* pixels, bool srgb, RfTexture* out, RfError* error )
{
    size_t count = value_count( out );
    const uint16_t* from = pixels->data;
    out->floats = malloc( count * sizeof *out->floats );
    if ( out->floats == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory: close other programs", where );
    for ( size_t i = 0; i < count; ++i )
    {
        float value = (float)from[i] / 65535.0f;
        out->floats[i] = srgb && !is_alpha( out, i ) ? rf_srgb_to_linear( value ) : value;
    }
    return RF_OK;
}

static RfResult take_floats( const char* where, RfPixels* pixels, bool colour, RfTexture* out, RfError* error )
{
    size_t count = value_count( out ), channels = (size_t)out->channels, width = (size_t)out->width;
    out->floats = pixels->data;
    pixels->data = NULL;
    for ( size_t i = 0; i < count; ++i )
    {
        if ( !isfinite( out->floats[i] ) )
            return rf_fail( error, RF_ERROR_SCENE, "%s: pixel (%zu, %zu) is not finite: repair the image", where,
                            i / channels % width, i / channels / width );
    }
    if ( colour && channels >= 3 )
        out->outside = rf_convert_light( &pixels->conversion, out->floats, count / channels, channels );
    for ( size_t i = 0; i < count; ++i )
        out->floats[i] = fmaxf( out->floats[i], 0.0f );
    return RF_OK;
}

static void find_largest( RfTexture* t )
{
    size_t count = value_count( t );
    for ( size_t i = 0; i < count; ++i )
    {
        if ( !is_alpha( t, i ) )
            t->largest = fmaxf( t->largest, t->bytes != NULL ? t->table[t->bytes[i]] : t->floats[i] );
    }
}

RfResult rf_make_texture( const char* where, RfPixels* pixels, bool srgb, RfTexture* out, RfError* error )
{
    *out = ( RfTexture ){ .width = pixels->width, .height = pixels->height, .channels = pixels->channels };
    for ( int i = 0; i < 256; ++i )
        out->table[i] = srgb ? rf_srgb_to_linear( (float)i / 255.0f ) : (float)i / 255.0f;
    RfResult result = RF_OK;
    if ( pixels->type == RF_PIXELS_U8 )
    {
        out->bytes = pixels->data;
        pixels->data = NULL;
    }
    else
        result = pixels->type == RF_PIXELS_U16 ? widen( where, pixels, srgb, out, error )
                                               : take_floats( where, pixels, srgb, out, error );
    if ( result == RF_OK )
        find_largest( out );
    return result;
}

void rf_destroy_texture( RfTexture* texture )
{
    free( texture->bytes );
    free( texture->floats );
    *texture = ( RfTexture ){ 0 };
}

// Sequences.

int rf_sequence_number( const RfImageSequence* s, double time )
{
    double count = (double)s->last - (double)s->first + 1.0, shown = floor( ( time - s->start ) * s->fps + EARLY );
    if ( shown <= 0.0 )
        return s->first;
    shown = s->loops ? fmod( shown, count ) : fmin( shown, count - 1.0 );
    return s->first + (int)shown;
}

void rf_sequence_span( const RfImageSequence* s, double* start, double* end )
{
    *start = fmax( s->start, 0.0 );
    *end = fmax( s->start + ( (double)s->last - (double)s->first ) / s->fps, *start );
}

static RfResult read_image( const RfImageSequence* s, int number, char name[PATH_MAX], uint8_t** bytes, size_t* size,
                            RfError* error )
{
    RfResult result = rf_sequence_name( s->pattern, number, name, PATH_MAX, error );
    return result == RF_OK ? rf_read_file( name, RF_MAX_IMAGE_BYTES, bytes, size, error ) : result;
}

size_t rf_texture_bytes( const RfPixels* pixels )
{
    return rf_pixels_bytes( pixels ) * ( pixels->type == RF_PIXELS_U16 ? sizeof( float ) / sizeof( uint16_t ) : 1 );
}

RfResult rf_measure_sequence( RfImageSequence* s, uint64_t* hash, RfError* error )
{
    char name[PATH_MAX];
    for ( int number = s->first; number <= s->last; ++number )
    {
        uint8_t* bytes;
        size_t size;
        RfPixels header = { 0 };
        RfResult result = read_image( s, number, name, &bytes, &size, error );
        if ( result != RF_OK )
            return result;
        result = rf_measure_image( bytes, size, name, &header, error );
        *hash = rf_hash_bytes( *hash, bytes, size );
        free( bytes );
        if ( result != RF_OK )
            return result;
        size_t texture = rf_texture_bytes( &header ), scratch = size + rf_pixels_bytes( &header ) + texture;
        s->bytes = texture > s->bytes ? texture : s->bytes;
        s->scratch = scratch > s->scratch ? scratch : s->scratch;
    }
    return RF_OK;
}

RfResult rf_load_sequence_image( const RfImageSequence* s, int number, RfTexture* out, RfError* error )
{
    char name[PATH_MAX];
    uint8_t* bytes;
    size_t size;
    RfPixels pixels = { 0 };
    *out = ( RfTexture ){ 0 };
    RfResult result = read_image( s, number, name, &bytes, &size, error );
    if ( result != RF_OK )
        return result;
    result = rf_decode_image( bytes, size, name, &pixels, error );
    free( bytes );
    if ( result == RF_OK )
        result = rf_make_texture( name, &pixels, s->srgb, out, error );
    rf_destroy_pixels( &pixels );
    if ( result == RF_OK && (double)out->largest > s->most )
        result = rf_fail( error, RF_ERROR_SCENE, "%s: has a value of %g, at most %g can be rendered: darken it", name,
                          (double)out->largest, s->most );
    if ( result != RF_OK )
        rf_destroy_texture( out );
    return result;
}

RfResult rf_place_sequence_image( const RfImageSequence* s, int number, void* memory, RfTexture* out, RfError* error )
{
    RfTexture read;
    char name[PATH_MAX];
    RfResult result = rf_load_sequence_image( s, number, &read, error );
    if ( result != RF_OK )
        return result;
    *out = read;
    const void* from = read.bytes != NULL ? (const void*)read.bytes : (const void*)read.floats;
    size_t bytes = value_count( &read ) * ( read.bytes != NULL ? 1 : sizeof( float ) );
    if ( bytes > s->bytes && rf_sequence_name( s->pattern, number, name, sizeof name, error ) == RF_OK )
        result = rf_fail( error, RF_ERROR_IO, "%s: has grown since the scene was read: render again", name );
    else
        memcpy( memory, from, bytes );
    out->bytes = read.bytes != NULL ? memory : NULL;
    out->floats = read.bytes != NULL ? NULL : memory;
    rf_destroy_texture( &read );
    return result;
}
