// Reads EXR files: the pixels of a part, headers, whole images.
#include "base/try.h"
#include "image/exr.h"

#include "base/file.h"
#include "image/atomic_file.h"
#include "image/exr_stream.h"
#include "image/half.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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
    bool hashes;  // all that is read goes into the hash, see RF_EXR_CHECKSUM
    uint64_t hash;
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
    part->dwa = compression == EXR_COMPRESSION_DWAA || compression == EXR_COMPRESSION_DWAB;
    if ( part->dwa && !rf_has_dwa() )
        return rf_fail( error, RF_ERROR_UNSUPPORTED,
                        "%s: its compression is DWA, which this build of reframe lacks: store it with "
                        "ZIP or PIZ",
                        path );
    if ( (unsigned int)compression > EXR_COMPRESSION_DWAB )
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
    Reader* reader = pipeline->decoding_user_data;
    const uint8_t* next = pipeline->unpacked_buffer;
    uint64_t left = next != NULL ? pipeline->chunk.unpacked_size : 0;
    if ( reader->hashes && reader->part->dwa )
        reader->hash = rf_hash_bytes( reader->hash, pipeline->packed_buffer, (size_t)pipeline->chunk.packed_size );
    for ( int64_t line = 0; line < pipeline->chunk.height; ++line )
    {
        const uint8_t* begin = next;
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
        if ( reader->hashes && !reader->part->dwa )
            reader->hash = rf_hash_bytes( reader->hash, begin, (size_t)( next - begin ) );
    }
    return EXR_ERR_SUCCESS;
}

static exr_result_t decompress_dwa( exr_decode_pipeline_t* pipeline )
{
    const Reader* reader = pipeline->decoding_user_data;
    return rf_decompress_dwa_chunk( pipeline, reader->part->stream );
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
    if ( reader->part->dwa )
        reader->pipeline.decompress_fn = decompress_dwa;
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
        RF_TRY( read_chunk( reader, &chunk, 0, y, error ) );
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
            RF_TRY( read_chunk( reader, &chunk, x, y, error ) );
        }
    }
    return RF_OK;
}

static RfResult read_lines( Reader* reader, RfError* error )
{
    const RfExrPart* part = reader->part;
    for ( int c = 0; c < reader->count; ++c )
    {
        RF_TRY( rf_check_exr_channel( part->stream, part->channels, reader->names[c], error ) );
    }
    reader->line = malloc( (size_t)part->width * sizeof( float ) );
    if ( reader->line == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory reading it", part->stream->path );
    RfResult result = part->tiled ? read_tiles( reader, error ) : read_scanlines( reader, error );
    if ( reader->started )
        exr_decoding_destroy( part->context, &reader->pipeline );
    free( reader->line );
    return result;
}

RfResult rf_read_exr_lines( const RfExrPart* part, const char* const* names, int count, RfExrLineFn* take, void* user,
                            RfError* error )
{
    Reader reader = { .part = part, .names = names, .count = count, .take = take, .user = user };
    return read_lines( &reader, error );
}

// The text after `kind` in the part's checksum, if that is of this kind; else NULL.
static const char* checksum_of( const RfExrPart* part, const char* kind )
{
    int32_t length = 0;
    const char* text = NULL;
    size_t begin = strlen( kind );
    bool found = exr_attr_get_string( part->context, part->index, RF_EXR_CHECKSUM, &length, &text ) == EXR_ERR_SUCCESS &&
                 text != NULL && strncmp( text, kind, begin ) == 0;
    return found ? text + begin : NULL;
}

RfResult rf_verify_exr_lines( const RfExrPart* part, const char* const* names, int count, RfExrLineFn* take, void* user,
                              bool* same, RfError* error )
{
    Reader reader = { .part = part, .names = names, .count = count, .take = take, .user = user };
    const char* wanted = part->tiled ? NULL : checksum_of( part, part->dwa ? RF_EXR_CHUNKS_SUM : RF_EXR_SAMPLES_SUM );
    char found[RF_EXR_SUM_SIZE];
    reader.hashes = wanted != NULL;
    RfResult result = read_lines( &reader, error );
    snprintf( found, sizeof found, RF_EXR_SUM_FORMAT, (unsigned long long)reader.hash );
    *same = wanted == NULL || strcmp( wanted, found ) == 0;
    return result;
}

static RfResult verify_part( RfExrStream* stream, int index, int* count, bool* same, RfError* error )
{
    RfExrPart part;
    const char* name = NULL;
    RfResult result = rf_open_exr_part( stream, index, &part, error );
    *count = part.count;
    *same = true;
    if ( result != RF_OK )
        return result;
    result = rf_verify_exr_lines( &part, NULL, 0, NULL, NULL, same, error );
    if ( part.count < 2 || exr_get_name( part.context, index, &name ) != EXR_ERR_SUCCESS )
        name = NULL;
    if ( result == RF_OK && !*same )
        rf_fail( error, RF_ERROR_FORMAT,
                 "%s: the pixels%s%.255s do not match their checksum: damaged, or changed by another program", stream->path,
                 name != NULL ? " of part " : "", name != NULL ? name : "" );
    rf_close_exr_part( &part );
    return result;
}

RfResult rf_verify_exr( const char* path, bool* same, RfError* error )
{
    RfExrStream stream;
    *same = true;
    RF_TRY( rf_open_exr_file( path, &stream, error ) );
    RfResult result = RF_OK;
    for ( int i = 0, count = 1; i < count && ( result == RF_OK || result == RF_ERROR_UNSUPPORTED ); ++i )
    {
        RfError reason = { 0 };
        bool is_same;
        RfResult one = verify_part( &stream, i, &count, &is_same, &reason );
        if ( ( one != RF_OK && one != RF_ERROR_UNSUPPORTED ) || ( one != RF_OK && result == RF_OK ) || ( !is_same && *same ) )
            rf_fail( error, reason.code, "%s", reason.text );
        result = one != RF_OK ? one : result;
        *same = *same && is_same;
    }
    close( stream.fd );
    return result;
}

RfResult rf_open_exr_file( const char* path, RfExrStream* stream, RfError* error )
{
    // without O_NONBLOCK, opening a pipe would block; pipes are rejected below
    *stream = ( RfExrStream ){ .path = path, .fd = open( path, O_RDONLY | O_CLOEXEC | O_NONBLOCK ) };
    if ( stream->fd < 0 )
        return rf_fail_io( path, "cannot be read", errno, error );
    struct stat status;
    if ( fstat( stream->fd, &status ) == 0 && S_ISREG( status.st_mode ) )
        return RF_OK;
    close( stream->fd );
    return rf_fail( error, RF_ERROR_IO, "%s: not a regular file", path );
}

RfResult rf_read_exr_colours( const RfExrPart* part, RfColourConversion* conversion, RfError* error )
{
    exr_attr_chromaticities_t read;
    RfChromaticities given;
    exr_result_t code = EXR_ERR_NO_ATTR_BY_NAME;
    *conversion = ( RfColourConversion ){ .needed = false };
    for ( int i = -1; i < part->count && code == EXR_ERR_NO_ATTR_BY_NAME; ++i )
        code = exr_attr_get_chromaticities( part->context, i < 0 ? part->index : i, "chromaticities", &read );
    if ( code == EXR_ERR_NO_ATTR_BY_NAME )
        return RF_OK;
    memcpy( &given, &read, sizeof given );
    if ( code == EXR_ERR_SUCCESS && rf_convert_between( &given, rf_chromaticities_of( RF_REC709 ), conversion ) )
        return RF_OK;
    if ( code != EXR_ERR_SUCCESS )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: its attribute chromaticities cannot be read: correct it",
                        part->stream->path );
    return rf_fail(
        error, RF_ERROR_FORMAT,
        "%.600s: its chromaticities do not define a colour space (red %g %g, green %g %g, blue %g %g, white %g %g): correct or "
        "remove this attribute",
        part->stream->path, (double)given.xy[0][0], (double)given.xy[0][1], (double)given.xy[1][0], (double)given.xy[1][1],
        (double)given.xy[2][0], (double)given.xy[2][1], (double)given.xy[3][0], (double)given.xy[3][1] );
}

RfResult rf_read_exr_string( const char* path, const char* name, char* value, size_t size, RfError* error )
{
    if ( size > 0 )
        value[0] = 0;
    RfExrStream stream;
    RF_TRY( rf_open_exr_file( path, &stream, error ) );
    exr_context_t context = NULL;
    exr_result_t code = rf_start_exr( &stream, &context );
    RfResult result = RF_OK;
    if ( code != EXR_ERR_SUCCESS )
        result = rf_fail_exr( &stream, code, "not a readable EXR file", error );
    else
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

double rf_read_exr_number( const char* path, const char* name )
{
    char text[64], *end;
    if ( rf_read_exr_string( path, name, text, sizeof text, NULL ) != RF_OK )
        return NAN;
    double value = strtod( text, &end );
    return end != text && *end == '\0' && isfinite( value ) ? value : NAN;
}

static RfExrWindow window_of( const RfExrPart* part )
{
    return ( RfExrWindow ){ part->window.min.x, part->window.min.y, part->width, part->height };
}

static RfResult read_windows( const RfExrPart* part, RfExrHeader* header, RfError* error )
{
    exr_attr_box2i_t display;
    exr_result_t code = exr_get_display_window( part->context, part->index, &display );
    int64_t width = (int64_t)display.max.x - display.min.x + 1, height = (int64_t)display.max.y - display.min.y + 1;
    if ( code != EXR_ERR_SUCCESS )
        return rf_fail_exr( part->stream, code, "its header cannot be read", error );
    if ( width < 1 || height < 1 || width > INT32_MAX || height > INT32_MAX )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: its display window of %lldx%lld pixels is out of bounds", part->stream->path,
                        (long long)width, (long long)height );
    header->part = part->index;
    header->x = part->window.min.x;
    header->y = part->window.min.y;
    header->width = part->width;
    header->height = part->height;
    header->display_x = display.min.x;
    header->display_y = display.min.y;
    header->display_width = (int)width;
    header->display_height = (int)height;
    return RF_OK;
}

// Attributes missing in this part are looked up in the others, since all parts belong to one
// image.
static void read_camera( const RfExrPart* part, RfExrHeader* header )
{
    exr_attr_m44f_t matrix;
    for ( int i = -1; i < part->count && !header->has_world_to_ndc; ++i )
        header->has_world_to_ndc =
            exr_attr_get_m44f( part->context, i < 0 ? part->index : i, "worldToNDC", &matrix ) == EXR_ERR_SUCCESS;
    if ( header->has_world_to_ndc )
        memcpy( header->world_to_ndc, matrix.m, sizeof header->world_to_ndc );
}

static void read_fps( const RfExrPart* part, RfExrHeader* header )
{
    exr_attr_rational_t fps;
    for ( int i = -1; i < part->count && header->fps_numerator == 0; ++i )
    {
        if ( exr_attr_get_rational( part->context, i < 0 ? part->index : i, "framesPerSecond", &fps ) != EXR_ERR_SUCCESS ||
             fps.num < 1 || fps.denom < 1 )
            continue;
        header->fps_numerator = fps.num;
        header->fps_denominator = fps.denom;
    }
}

static bool copy_name( const RfExrPart* part, const exr_attr_chlist_entry_t* channel, RfExrName* name )
{
    const char* own = channel->name.str;
    const char* before = NULL;
    if ( part->count < 2 || exr_get_name( part->context, part->index, &before ) != EXR_ERR_SUCCESS )
        before = NULL;
    size_t length = before != NULL ? strlen( before ) : 0;
    if ( before != NULL && strncmp( own, before, length ) == 0 && own[length] == '.' )
        before = NULL; // the layer is the part: it is there already
    size_t begin = before != NULL ? strlen( before ) + 1 : 0, size = begin + strlen( own ) + 1;
    *name = ( RfExrName ){ .text = malloc( size ),
                           .part = part->index,
                           .half = channel->pixel_type == EXR_PIXEL_HALF,
                           .whole = channel->pixel_type == EXR_PIXEL_UINT,
                           .window = window_of( part ) };
    if ( name->text == NULL )
        return false;
    snprintf( name->text, size, "%s%s%s", before != NULL ? before : "", before != NULL ? "." : "", own );
    name->own = name->text + begin;
    return true;
}

static bool copy_names( const RfExrPart* part, RfExrHeader* header )
{
    int count = part->channels->num_channels;
    RfExrName* moved = realloc( header->channels, ( (size_t)header->channel_count + (size_t)count + 1 ) * sizeof *moved );
    if ( moved == NULL )
        return false;
    header->channels = moved;
    for ( int i = 0; i < count; ++i )
    {
        if ( !copy_name( part, part->channels->entries + i, moved + header->channel_count ) )
            return false;
        ++header->channel_count;
    }
    return true;
}

// Lists the channels of all parts, except parts whose pixels cannot be read.
static RfResult list_channels( RfExrStream* stream, RfExrHeader* header, RfError* error )
{
    bool is_done = true;
    for ( int i = 0, count = 1; i < count && is_done; ++i )
    {
        RfExrPart part;
        RfResult result = rf_open_exr_part( stream, i, &part, NULL );
        count = part.count;
        if ( result != RF_OK )
            continue;
        is_done = copy_names( &part, header );
        rf_close_exr_part( &part );
    }
    return is_done ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for the names of its channels", stream->path );
}

// Opens the part with the layer or the colour, else the first readable part. If there is none,
// the error is that of part 0.
static RfResult open_part( RfExrStream* stream, const char* layer, RfExrPart* part, RfError* error )
{
    RfExrChannels channels;
    if ( rf_open_exr_layer( stream, layer, part, &channels, NULL ) == RF_OK )
        return RF_OK;
    RfResult result = rf_open_exr_part( stream, 0, part, error );
    for ( int i = 1; i < part->count && result != RF_OK; ++i )
        result = rf_open_exr_part( stream, i, part, NULL );
    return result;
}

RfResult rf_read_exr_header( const char* path, const char* layer, RfExrHeader* header, RfError* error )
{
    *header = ( RfExrHeader ){ 0 };
    RfExrStream stream;
    RF_TRY( rf_open_exr_file( path, &stream, error ) );
    RfExrPart part;
    RfResult result = open_part( &stream, layer, &part, error );
    if ( result == RF_OK )
    {
        result = read_windows( &part, header, error );
        read_camera( &part, header );
        read_fps( &part, header );
        rf_close_exr_part( &part );
        if ( result == RF_OK )
            result = list_channels( &stream, header, error );
    }
    close( stream.fd );
    if ( result != RF_OK )
        rf_destroy_exr_header( header );
    return result;
}

void rf_destroy_exr_header( RfExrHeader* header )
{
    for ( int i = 0; i < header->channel_count; ++i )
        free( header->channels[i].text );
    free( header->channels );
    *header = ( RfExrHeader ){ 0 };
}

static bool is_name( const char* text, const char* name, size_t length )
{
    return strlen( text ) == length && memcmp( text, name, length ) == 0;
}

const RfExrName* rf_find_exr_name( const RfExrHeader* header, const char* name, size_t length )
{
    const RfExrName* found = NULL;
    for ( int i = 0; i < header->channel_count; ++i )
    {
        const RfExrName* channel = header->channels + i;
        if ( is_name( channel->text, name, length ) )
            return channel;
        if ( is_name( channel->own, name, length ) &&
             ( found == NULL || ( channel->part == header->part && found->part != header->part ) ) )
            found = channel;
    }
    return found;
}

RfResult rf_list_exr_strings( const char* path, RfExrStringFn* take, void* user, RfError* error )
{
    RfExrStream stream;
    RF_TRY( rf_open_exr_file( path, &stream, error ) );
    RfExrPart part;
    RfResult result = rf_open_exr_part( &stream, 0, &part, error );
    int32_t count = 0;
    if ( result == RF_OK )
        exr_get_attribute_count( part.context, 0, &count );
    for ( int32_t i = 0; i < count; ++i )
    {
        const exr_attribute_t* attribute = NULL;
        if ( exr_get_attribute_by_index( part.context, 0, EXR_ATTR_LIST_FILE_ORDER, i, &attribute ) == EXR_ERR_SUCCESS &&
             attribute->type == EXR_ATTR_STRING && attribute->string != NULL && attribute->string->str != NULL )
            take( user, attribute->name, attribute->string->str );
    }
    if ( result == RF_OK )
        rf_close_exr_part( &part );
    close( stream.fd );
    return result;
}
