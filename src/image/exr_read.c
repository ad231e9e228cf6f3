// Reads the pixels of an EXR, chunk by chunk and line by line.
#include "image/exr_channels.h"
#include "image/half.h"

#include <stdlib.h>
#include <string.h>

#define MAX_PIXELS ( (int64_t)1 << 28 )

typedef struct Reader
{
    const RfExrPart* part;
    const char* const* names; // of the requested channels
    int count;
    RfExrLineFn* take;
    void* user;
    float* line;  // width floats
    int64_t x, y; // origin of the current chunk in the image
    exr_decode_pipeline_t pipeline;
    bool started; // the pipeline is initialised
} Reader;

static const char* compression_name( exr_compression_t compression )
{
    static const char* const names[] = { "none", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB" };
    unsigned int index = (unsigned int)compression;
    return index < sizeof names / sizeof names[0] ? names[index] : "unknown";
}

// Checks the type of a part and rejects what cannot be read, by name.
static RfResult check_part( RfExrPart* part, RfError* error )
{
    const char* path = part->stream->path;
    exr_storage_t storage;
    exr_result_t code = exr_get_storage( part->context, part->index, &storage );
    exr_compression_t compression = EXR_COMPRESSION_LAST_TYPE;
    if ( code == EXR_ERR_SUCCESS )
        code = exr_get_compression( part->context, part->index, &compression );
    if ( code == EXR_ERR_SUCCESS )
        code = exr_get_data_window( part->context, part->index, &part->window );
    if ( code == EXR_ERR_SUCCESS )
        code = exr_get_channels( part->context, part->index, &part->channels );
    if ( code != EXR_ERR_SUCCESS )
        return rf_fail_exr( part->stream, code, "its header cannot be read", error );
    if ( storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: holds deep pixels: flatten it first", path );
    // OpenEXRCore 3.1.5 does not support DWA and would fail at the first chunk.
    if ( (unsigned int)compression >= EXR_COMPRESSION_DWAA )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: its compression is %s: store it with ZIP or PIZ", path,
                        compression_name( compression ) );
    part->tiled = storage == EXR_STORAGE_TILED;
    return RF_OK;
}

static RfResult check_window( RfExrPart* part, RfError* error )
{
    int64_t width = (int64_t)part->window.max.x - part->window.min.x + 1;
    int64_t height = (int64_t)part->window.max.y - part->window.min.y + 1;
    int64_t most = part->stream->max_bytes > 0 ? (int64_t)( part->stream->max_bytes / ( 3 * sizeof( float ) ) ) : MAX_PIXELS;
    if ( width < 1 || height < 1 || width > most || height > most / width )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: its data window of %lldx%lld pixels is out of bounds", part->stream->path,
                        (long long)width, (long long)height );
    part->width = (int)width;
    part->height = (int)height;
    return RF_OK;
}

RfResult rf_open_exr_part( RfExrStream* stream, int index, RfExrPart* part, RfError* error )
{
    *part = ( RfExrPart ){ .stream = stream, .index = index };
    exr_result_t code = rf_start_exr( stream, &part->context );
    if ( code != EXR_ERR_SUCCESS )
        return rf_fail_exr( stream, code, "not a readable EXR file", error );
    if ( exr_get_count( part->context, &part->count ) != EXR_ERR_SUCCESS )
        part->count = 1;
    RfResult result = check_part( part, error );
    if ( result == RF_OK )
        result = check_window( part, error );
    if ( result != RF_OK )
        rf_close_exr_part( part );
    return result;
}

void rf_close_exr_part( RfExrPart* part ) { exr_finish( &part->context ); }

// Converts little-endian samples of the file to floats.
static void convert_line( const uint8_t* samples, int count, exr_pixel_type_t type, float* out )
{
    for ( int i = 0; i < count; ++i, ++out )
    {
        uint16_t half;
        uint32_t whole;
        if ( type == EXR_PIXEL_HALF )
        {
            memcpy( &half, samples + 2 * i, sizeof half );
            *out = rf_half_to_float( half );
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

static int channel_index( const Reader* reader, const char* name )
{
    for ( int c = 0; c < reader->count; ++c )
    {
        if ( strcmp( reader->names[c], name ) == 0 )
            return c;
    }
    return -1;
}

// Unpacks one line of channel c; false if it is outside the image.
static bool unpack_line( const Reader* reader, const exr_coding_channel_info_t* channel, int c, const uint8_t* samples,
                         int64_t line )
{
    const RfExrPart* part = reader->part;
    int64_t y = reader->y + line;
    if ( reader->x + channel->width > part->width || y >= part->height )
        return false;
    convert_line( samples, channel->width, (exr_pixel_type_t)channel->data_type, reader->line );
    reader->take( reader->user, c, (int)reader->x, (int)y, reader->line, channel->width );
    return true;
}

// Unpacks a decompressed chunk line by line; within a line the samples of each channel are
// contiguous. The library's own unpacking routines for 3 or 4 channels write through the NULL
// pointer that should skip a channel (seen in 3.1.5), so we use our own, with bounds checks of
// buffer and image.
static exr_result_t unpack_channels( exr_decode_pipeline_t* pipeline )
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
                continue; // a subsampled channel does not store this line
            uint64_t bytes = (uint64_t)channel->width * (uint64_t)channel->bytes_per_element;
            int c = channel_index( reader, channel->channel_name );
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

// Reads the chunk at (x, y) relative to the data window.
static RfResult read_chunk( Reader* reader, const exr_chunk_info_t* chunk, int64_t x, int64_t y, RfError* error )
{
    exr_result_t code = reader->started
                            ? exr_decoding_update( reader->part->context, reader->part->index, chunk, &reader->pipeline )
                            : exr_decoding_initialize( reader->part->context, reader->part->index, chunk, &reader->pipeline );
    reader->started = true;
    reader->pipeline.alloc_fn = rf_alloc_exr_buffer;
    reader->pipeline.free_fn = rf_free_exr_buffer;
    if ( code == EXR_ERR_SUCCESS )
        code = exr_decoding_choose_default_routines( reader->part->context, reader->part->index, &reader->pipeline );
    reader->x = x;
    reader->y = y;
    reader->pipeline.decoding_user_data = reader;
    reader->pipeline.unpack_and_convert_fn = unpack_channels;
    if ( code == EXR_ERR_SUCCESS )
        code = exr_decoding_run( reader->part->context, reader->part->index, &reader->pipeline );
    if ( code != EXR_ERR_SUCCESS )
        return rf_fail_exr( reader->part->stream, code, "its pixels cannot be read", error );
    return RF_OK;
}

static RfResult read_scanlines( Reader* reader, RfError* error )
{
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk( reader->part->context, reader->part->index, &lines );
    if ( code != EXR_ERR_SUCCESS || lines < 1 )
        return rf_fail_exr( reader->part->stream, code, "its header cannot be read", error );
    for ( int64_t y = 0; y < reader->part->height; y += lines )
    {
        exr_chunk_info_t chunk = { 0 };
        code = exr_read_scanline_chunk_info( reader->part->context, reader->part->index, (int)( reader->part->window.min.y + y ),
                                             &chunk );
        if ( code != EXR_ERR_SUCCESS )
            return rf_fail_exr( reader->part->stream, code, "its pixels cannot be read", error );
        RfResult result = read_chunk( reader, &chunk, 0, y, error );
        if ( result != RF_OK )
            return result;
    }
    return RF_OK;
}

static RfResult read_tiles( Reader* reader, RfError* error )
{
    int32_t width = 0, height = 0;
    exr_result_t code = exr_get_tile_sizes( reader->part->context, reader->part->index, 0, 0, &width, &height );
    if ( code != EXR_ERR_SUCCESS || width < 1 || height < 1 )
        return rf_fail_exr( reader->part->stream, code, "its tiles cannot be read", error );
    for ( int64_t y = 0; y < reader->part->height; y += height )
    {
        for ( int64_t x = 0; x < reader->part->width; x += width )
        {
            exr_chunk_info_t chunk = { 0 };
            code = exr_read_tile_chunk_info( reader->part->context, reader->part->index, (int)( x / width ), (int)( y / height ),
                                             0, 0, &chunk );
            if ( code != EXR_ERR_SUCCESS )
                return rf_fail_exr( reader->part->stream, code, "its tiles cannot be read", error );
            RfResult result = read_chunk( reader, &chunk, x, y, error );
            if ( result != RF_OK )
                return result;
        }
    }
    return RF_OK;
}

RfResult rf_read_exr_lines( const RfExrPart* part, const char* const* names, int count, RfExrLineFn* take, void* user,
                            RfError* error )
{
    Reader reader = { .part = part, .names = names, .count = count, .take = take, .user = user };
    for ( int c = 0; c < count; ++c )
    {
        RfResult result = rf_check_exr_channel( part->stream, part->channels, names[c], error );
        if ( result != RF_OK )
            return result;
    }
    reader.line = malloc( (size_t)part->width * sizeof( float ) );
    if ( reader.line == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left to read it", part->stream->path );
    RfResult result = part->tiled ? read_tiles( &reader, error ) : read_scanlines( &reader, error );
    if ( reader.started )
        exr_decoding_destroy( part->context, &reader.pipeline );
    free( reader.line );
    return result;
}
