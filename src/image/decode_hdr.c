// Radiance HDR by stb_image; its other formats are compiled out.
#include "base/try.h"
#include "image/decode_formats.h"

#include <stdlib.h>
#include <string.h>

#define STBI_ONLY_HDR
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS RF_DECODE_MAX_SIDE
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
// stb_image declares static functions for formats that are compiled out
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>

typedef struct Source
{
    const RfEncoded* in;
    size_t at;
    bool cut_off; // the decoder read past the end
} Source;

// stb_image does not detect the end of its input and loops forever on zeros in place of
// missing data. Past the end it gets bytes of 255, which make progress in every state of its
// parser; the result is discarded.
static int read_bytes( void* user, char* data, int size )
{
    Source* source = user;
    size_t want = (size_t)size, left = source->in->size - source->at;
    size_t got = want < left ? want : left;
    memcpy( data, source->in->bytes + source->at, got );
    source->at += got;
    if ( got > 0 && want > 4 )
        return (int)got; // fills a buffer as far as the data goes
    memset( data + got, 255, want - got );
    source->cut_off = source->cut_off || got < want;
    return size;
}

static void skip_bytes( void* user, int size )
{
    Source* source = user;
    size_t left = source->in->size - source->at;
    source->at += size > 0 && (size_t)size < left ? (size_t)size : left;
}

static int at_end( void* user )
{
    const Source* source = user;
    return source->at >= source->in->size;
}

RfResult rf_decode_hdr( const RfEncoded* in, RfPixels* out, RfError* error )
{
    if ( in->size > 0x7fffffff )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: more than 2 GiB of HDR: scale it down", in->name );
    int width = 0, height = 0, channels = 0;
    if ( stbi_info_from_memory( in->bytes, (int)in->size, &width, &height, &channels ) == 0 )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: damaged HDR: its header cannot be read", in->name );
    out->type = RF_PIXELS_FLOAT;
    out->channels = 3;
    // for its checks; stb_image allocates its own memory
    RF_TRY( rf_create_pixels( in, width, height, out, error ) );
    free( out->data );
    Source source = { .in = in };
    stbi_io_callbacks io = { read_bytes, skip_bytes, at_end };
    out->data = stbi_loadf_from_callbacks( &io, &source, &width, &height, &channels, 3 );
    if ( source.cut_off )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: damaged HDR: truncated", in->name );
    if ( out->data == NULL || width != out->width || height != out->height )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: damaged HDR: %s", in->name,
                        out->data == NULL ? stbi_failure_reason() : "its size changes" );
    return RF_OK;
}
