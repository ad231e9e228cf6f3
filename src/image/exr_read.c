#include "image/atomic_file.h"
#include "image/exr.h"
#include "image/exr_channels.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define MAX_PIXELS ( (int64_t)1 << 28 )

typedef struct Reader
{
    RfExrStream* stream;
    exr_context_t context;
    exr_attr_box2i_t window;
    bool tiled;
    RfExrChannels channels;
    RfImage* image;
    int64_t x, y; // where the present chunk begins in the image
    exr_decode_pipeline_t pipeline;
    bool started; // the pipeline has been initialised
} Reader;

static const char* compression_name( exr_compression_t compression )
{
    static const char* const names[] = { "none", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB" };
    unsigned int index = (unsigned int)compression;
    return index < sizeof names / sizeof names[0] ? names[index] : "unknown";
}

// Looks at what kind of part it is; refuses what we cannot read by its name.
static RfResult check_part( Reader* reader, RfError* error )
{
    const char* path = reader->stream->path;
    exr_storage_t storage;
    exr_result_t code = exr_get_storage( reader->context, 0, &storage );
    exr_compression_t compression = EXR_COMPRESSION_LAST_TYPE;
    if ( code == EXR_ERR_SUCCESS )
        code = exr_get_compression( reader->context, 0, &compression );
    if ( code == EXR_ERR_SUCCESS )
        code = exr_get_data_window( reader->context, 0, &reader->window );
    if ( code != EXR_ERR_SUCCESS )
        return rf_fail_exr( reader->stream, code, "its header cannot be read", error );
    if ( storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: holds deep pixels: flatten it first", path );
    // The 3.1.5 core library has no DWA; it would fail at the first chunk.
    if ( (unsigned int)compression >= EXR_COMPRESSION_DWAA )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: its compression is %s: store it with ZIP or PIZ", path,
                        compression_name( compression ) );
    reader->tiled = storage == EXR_STORAGE_TILED;
    return RF_OK;
}

static RfResult create_target( Reader* reader, RfError* error )
{
    int64_t width = (int64_t)reader->window.max.x - reader->window.min.x + 1;
    int64_t height = (int64_t)reader->window.max.y - reader->window.min.y + 1;
    int64_t most = reader->stream->max_bytes > 0 ? (int64_t)( reader->stream->max_bytes / ( 3 * sizeof( float ) ) ) : MAX_PIXELS;
    if ( width < 1 || height < 1 || width > most || height > most / width )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: its data window of %lldx%lld pixels is out of bounds",
                        reader->stream->path, (long long)width, (long long)height );
    return rf_create_image( (int)width, (int)height, reader->image, error );
}

static float half_to_float( uint16_t half )
{
    uint32_t exponent = half >> 10 & 31u, mantissa = half & 1023u;
    if ( exponent == 0 )
        return ( half & 0x8000u ? -0x1p-24f : 0x1p-24f ) * (float)mantissa;
    uint32_t bits = ( half & 0x8000u ) << 16 | mantissa << 13 | ( exponent == 31 ? 255u : exponent + 112u ) << 23;
    float value;
    memcpy( &value, &bits, sizeof value );
    return value;
}

// Little-endian samples, as in the file, to every third float.
static void convert_line( const uint8_t* samples, int count, exr_pixel_type_t type, float* out )
{
    for ( int i = 0; i < count; ++i, out += 3 )
    {
        uint16_t half;
        uint32_t whole;
        if ( type == EXR_PIXEL_HALF )
        {
            memcpy( &half, samples + 2 * i, sizeof half );
            *out = half_to_float( half );
        }
        else if ( type == EXR_PIXEL_UINT )
        {
            memcpy( &whole, samples + 4 * i, sizeof whole );
            *out = (float)whole;
        }
        else
            memcpy( out, samples + 4 * i, sizeof *out );
    }
}

// One line of colour c; false where it lies outside the image.
static bool unpack_line( const Reader* reader, const exr_coding_channel_info_t* channel, int c,
                         const uint8_t* samples, int64_t line )
{
    const RfImage* image = reader->image;
    int64_t y = reader->y + line;
    if ( reader->x + channel->width > image->width || y >= image->height )
        return false;
    float* out = image->rgb + 3 * ( y * image->width + reader->x ) + c;
    convert_line( samples, channel->width, (exr_pixel_type_t)channel->data_type, out );
    return true;
}

// Takes the colour out of a decompressed chunk: line by line, the samples of
// each channel in turn. The library's own routines for this write through the
// NULL that should skip a channel when there are 3 or 4 (seen in 3.1.5), so we
// do it ourselves, and check against buffer and image what the file claims.
static exr_result_t unpack_colour( exr_decode_pipeline_t* pipeline )
{
    const Reader* reader = pipeline->decoding_user_data;
    const uint8_t* next = pipeline->unpacked_buffer;
    uint64_t left = next != NULL ? pipeline->chunk.unpacked_size : 0;
    for ( int64_t line = 0; line < pipeline->chunk.height; ++line )
    {
        for ( int i = 0; i < pipeline->channel_count; ++i )
        {
            const exr_coding_channel_info_t* channel = pipeline->channels + i;
            if ( channel->y_samples > 1 && ( pipeline->chunk.start_y + line ) % channel->y_samples != 0 )
                continue; // this line of a subsampled channel is not stored
            uint64_t bytes = (uint64_t)channel->width * (uint64_t)channel->bytes_per_element;
            int c = rf_exr_channel_index( &reader->channels, channel->channel_name );
            if ( channel->width < 0 || bytes > left )
                return EXR_ERR_CORRUPT_CHUNK;
            if ( c >= 0 && !unpack_line( reader, channel, c, next, line ) )
                return EXR_ERR_CORRUPT_CHUNK;
            next += bytes;
            left -= bytes;
        }
    }
    return EXR_ERR_SUCCESS;
}

// Reads the chunk whose first pixel is (x, y) of the data window.
static RfResult read_chunk( Reader* reader, const exr_chunk_info_t* chunk, int64_t x, int64_t y, RfError* error )
{
    exr_result_t code = reader->started
                            ? exr_decoding_update( reader->context, 0, chunk, &reader->pipeline )
                            : exr_decoding_initialize( reader->context, 0, chunk, &reader->pipeline );
    reader->started = true;
    if ( code == EXR_ERR_SUCCESS )
        code = exr_decoding_choose_default_routines( reader->context, 0, &reader->pipeline );
    reader->x = x;
    reader->y = y;
    reader->pipeline.decoding_user_data = reader;
    reader->pipeline.unpack_and_convert_fn = unpack_colour;
    if ( code == EXR_ERR_SUCCESS )
        code = exr_decoding_run( reader->context, 0, &reader->pipeline );
    if ( code != EXR_ERR_SUCCESS )
        return rf_fail_exr( reader->stream, code, "its pixels cannot be read", error );
    return RF_OK;
}

static RfResult read_scanlines( Reader* reader, RfError* error )
{
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk( reader->context, 0, &lines );
    if ( code != EXR_ERR_SUCCESS || lines < 1 )
        return rf_fail_exr( reader->stream, code, "its header cannot be read", error );
    for ( int64_t y = 0; y < reader->image->height; y += lines )
    {
        exr_chunk_info_t chunk = { 0 };
        code = exr_read_scanline_chunk_info( reader->context, 0, (int)( reader->window.min.y + y ), &chunk );
        if ( code != EXR_ERR_SUCCESS )
            return rf_fail_exr( reader->stream, code, "its pixels cannot be read", error );
        RfResult result = read_chunk( reader, &chunk, 0, y, error );
        if ( result != RF_OK )
            return result;
    }
    return RF_OK;
}

static RfResult read_tiles( Reader* reader, RfError* error )
{
    int32_t width = 0, height = 0;
    exr_result_t code = exr_get_tile_sizes( reader->context, 0, 0, 0, &width, &height );
    if ( code != EXR_ERR_SUCCESS || width < 1 || height < 1 )
        return rf_fail_exr( reader->stream, code, "its tiles cannot be read", error );
    for ( int64_t y = 0; y < reader->image->height; y += height )
    {
        for ( int64_t x = 0; x < reader->image->width; x += width )
        {
            exr_chunk_info_t chunk = { 0 };
            code = exr_read_tile_chunk_info( reader->context, 0, (int)( x / width ), (int)( y / height ), 0, 0,
                                             &chunk );
            if ( code != EXR_ERR_SUCCESS )
                return rf_fail_exr( reader->stream, code, "its tiles cannot be read", error );
            RfResult result = read_chunk( reader, &chunk, x, y, error );
            if ( result != RF_OK )
                return result;
        }
    }
    return RF_OK;
}

static void spread_luminance( RfImage* image )
{
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for ( size_t i = 0; i < pixels; ++i )
        image->rgb[3 * i + 1] = image->rgb[3 * i + 2] = image->rgb[3 * i];
}

static RfResult read_part( Reader* reader, RfError* error )
{
    const exr_attr_chlist_t* list = NULL;
    RfResult result = check_part( reader, error );
    if ( result != RF_OK )
        return result;
    exr_result_t code = exr_get_channels( reader->context, 0, &list );
    if ( code != EXR_ERR_SUCCESS )
        return rf_fail_exr( reader->stream, code, "its header cannot be read", error );
    result = rf_find_exr_channels( reader->stream, list, &reader->channels, error );
    if ( result == RF_OK )
        result = create_target( reader, error );
    if ( result == RF_OK )
        result = reader->tiled ? read_tiles( reader, error ) : read_scanlines( reader, error );
    if ( result == RF_OK && reader->channels.count == 1 )
        spread_luminance( reader->image );
    return result;
}

static RfResult start_read( RfExrStream* stream, exr_context_t* context, RfError* error )
{
    exr_context_initializer_t initializer = rf_exr_initializer( stream );
    exr_result_t code = exr_start_read( context, stream->path, &initializer );
    if ( code != EXR_ERR_SUCCESS )
        return rf_fail_exr( stream, code, "is no EXR that can be read", error );
    return RF_OK;
}

RfResult rf_read_exr_stream( RfExrStream* stream, RfImage* image, RfError* error )
{
    *image = ( RfImage ){ 0 };
    Reader reader = { .stream = stream, .image = image };
    RfResult result = start_read( stream, &reader.context, error );
    if ( result != RF_OK )
        return result;
    result = read_part( &reader, error );
    if ( reader.started )
        exr_decoding_destroy( reader.context, &reader.pipeline );
    exr_finish( &reader.context );
    if ( result != RF_OK )
        rf_destroy_image( image );
    return result;
}

static RfResult open_file( const char* path, RfExrStream* stream, RfError* error )
{
    // not to wait for ever at a pipe, which is refused below
    *stream = ( RfExrStream ){ .path = path, .fd = open( path, O_RDONLY | O_CLOEXEC | O_NONBLOCK ) };
    if ( stream->fd < 0 )
        return rf_fail_io( path, "cannot be read", errno, error );
    struct stat status;
    if ( fstat( stream->fd, &status ) == 0 && S_ISREG( status.st_mode ) )
        return RF_OK;
    close( stream->fd );
    return rf_fail( error, RF_ERROR_IO, "%s: is no regular file", path );
}

RfResult rf_read_exr( const char* path, RfImage* image, RfError* error )
{
    *image = ( RfImage ){ 0 };
    RfExrStream stream;
    RfResult result = open_file( path, &stream, error );
    if ( result != RF_OK )
        return result;
    result = rf_read_exr_stream( &stream, image, error );
    close( stream.fd );
    return result;
}

RfResult rf_read_exr_string( const char* path, const char* name, char* value, size_t size, RfError* error )
{
    if ( size > 0 )
        value[0] = 0;
    RfExrStream stream;
    RfResult result = open_file( path, &stream, error );
    if ( result != RF_OK )
        return result;
    exr_context_t context = NULL;
    result = start_read( &stream, &context, error );
    if ( result == RF_OK )
    {
        int32_t length = 0;
        const char* text = NULL;
        if ( exr_attr_get_string( context, 0, name, &length, &text ) != EXR_ERR_SUCCESS || text == NULL || length < 0 )
            result = rf_fail( error, RF_ERROR_FORMAT, "%s: has no string attribute '%s'", path, name );
        else if ( size > 0 )
            snprintf( value, size, "%.*s", (int)length, text );
        exr_finish( &context );
    }
    close( stream.fd );
    return result;
}
