// OpenEXRCore's reads and writes through callbacks that keep every system error; chunks that are compressed by DWA.
#define _DEFAULT_SOURCE // MAP_ANONYMOUS
#include "image/exr_stream.h"

#include "image/atomic_file.h"
#include "image/dwa.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

bool rf_is_dwa( RfExrCompression compression ) { return compression == RF_EXR_DWAA || compression == RF_EXR_DWAB; }

double rf_dwa_scale( double value )
{
    double size = fabs( value );
    return copysign( size <= 1.0 ? pow( size, 1.0 / 2.2 ) : 1.0 + log( size ) / 2.2, value );
}

double rf_dwa_error_bound( double level, double scale ) { return 16.6e-5 * level + 6.0 * 0x1p-11 * scale + 1e-4; }

#ifdef REFRAME_DWA

bool rf_has_dwa( void ) { return true; }

static exr_result_t take_result( RfDwaResult result, const char* message, RfExrStream* stream )
{
    if ( result == RF_DWA_BROKEN && stream->message[0] == 0 )
        snprintf( stream->message, sizeof stream->message, "%s", message );
    return result == RF_DWA_OK ? EXR_ERR_SUCCESS : result == RF_DWA_MEMORY ? EXR_ERR_OUT_OF_MEMORY : EXR_ERR_CORRUPT_CHUNK;
}

// The channels of a pipeline; NULL: no memory. The caller frees them.
static RfDwaChannel* list_channels( const exr_coding_channel_info_t* channels, int count, const bool* may_change )
{
    RfDwaChannel* list = malloc( (size_t)( count > 0 ? count : 1 ) * sizeof *list );
    for ( int c = 0; list != NULL && c < count; ++c )
        list[c] = ( RfDwaChannel ){
            .name = channels[c].channel_name,
            .type = channels[c].data_type,
            .linear = channels[c].p_linear,
            .exact = may_change != NULL && !may_change[c],
        };
    return list;
}

exr_result_t rf_compress_dwa_chunk( exr_encode_pipeline_t* pipeline, RfExrStream* stream, const bool* may_change, float level )
{
    if ( pipeline->compressed_alloc_size < pipeline->packed_bytes )
    {
        rf_free_exr_buffer( EXR_TRANSCODE_BUFFER_COMPRESSED, pipeline->compressed_buffer );
        pipeline->compressed_alloc_size = 0;
        pipeline->compressed_buffer = rf_alloc_exr_buffer( EXR_TRANSCODE_BUFFER_COMPRESSED, pipeline->packed_bytes );
        if ( pipeline->compressed_buffer == NULL )
            return EXR_ERR_OUT_OF_MEMORY;
        pipeline->compressed_alloc_size = pipeline->packed_bytes;
    }
    RfDwaChannel* channels = list_channels( pipeline->channels, pipeline->channel_count, may_change );
    if ( channels == NULL )
        return EXR_ERR_OUT_OF_MEMORY;
    const RfDwaBlock block = { channels, pipeline->channel_count, pipeline->chunk.width, pipeline->chunk.height, level };
    char message[RF_DWA_MESSAGE_SIZE];
    size_t size = 0;
    RfDwaResult result =
        rf_compress_dwa( &block, pipeline->packed_buffer, pipeline->packed_bytes, pipeline->compressed_buffer, &size, message );
    pipeline->compressed_bytes = size;
    free( channels );
    return take_result( result, message, stream );
}

exr_result_t rf_decompress_dwa_chunk( exr_decode_pipeline_t* pipeline, RfExrStream* stream )
{
    const exr_chunk_info_t* chunk = &pipeline->chunk;
    if ( pipeline->packed_buffer == pipeline->unpacked_buffer )
        return EXR_ERR_SUCCESS; // stored as it is
    if ( chunk->packed_size >= chunk->unpacked_size )
    {
        memcpy( pipeline->unpacked_buffer, pipeline->packed_buffer, chunk->unpacked_size );
        return EXR_ERR_SUCCESS;
    }
    uint64_t size = 0;
    for ( int c = 0; c < pipeline->channel_count; ++c )
    {
        const exr_coding_channel_info_t* channel = pipeline->channels + c;
        size += (uint64_t)chunk->width * (uint64_t)chunk->height * (uint64_t)channel->bytes_per_element;
        if ( channel->x_samples > 1 || channel->y_samples > 1 )
            return take_result( RF_DWA_BROKEN, "has subsampled channels, with DWA: store it with ZIP or PIZ", stream );
    }
    if ( size != chunk->unpacked_size || chunk->packed_size > INT32_MAX )
        return EXR_ERR_CORRUPT_CHUNK;
    RfDwaChannel* channels = list_channels( pipeline->channels, pipeline->channel_count, NULL );
    if ( channels == NULL )
        return EXR_ERR_OUT_OF_MEMORY;
    const RfDwaBlock block = { channels, pipeline->channel_count, chunk->width, chunk->height, 0.0f };
    char message[RF_DWA_MESSAGE_SIZE];
    RfDwaResult result = rf_decompress_dwa( &block, pipeline->packed_buffer, (size_t)chunk->packed_size,
                                            pipeline->unpacked_buffer, (size_t)size, message );
    free( channels );
    return take_result( result, message, stream );
}

#else

bool rf_has_dwa( void ) { return false; }

exr_result_t rf_compress_dwa_chunk( exr_encode_pipeline_t* pipeline, RfExrStream* stream, const bool* may_change, float level )
{
    (void)pipeline;
    (void)stream;
    (void)may_change;
    (void)level;
    return EXR_ERR_FEATURE_NOT_IMPLEMENTED;
}

exr_result_t rf_decompress_dwa_chunk( exr_decode_pipeline_t* pipeline, RfExrStream* stream )
{
    (void)pipeline;
    (void)stream;
    return EXR_ERR_FEATURE_NOT_IMPLEMENTED;
}

#endif

// The stream that the thread writes. The library calls back with its context locked, where asking for
// the user data would wait for itself for ever.
static _Thread_local RfExrStream* s_written;

static void keep( RfExrStream* stream, const char* message )
{
    if ( stream != NULL && stream->message[0] == 0 && message != NULL )
        snprintf( stream->message, sizeof stream->message, "%s", message );
}

static void keep_read_message( exr_const_context_t context, exr_result_t code, const char* message )
{
    (void)code;
    void* user = NULL;
    if ( context != NULL && exr_get_user_data( context, &user ) == EXR_ERR_SUCCESS )
        keep( user, message );
}

static void keep_write_message( exr_const_context_t context, exr_result_t code, const char* message )
{
    (void)context;
    (void)code;
    keep( s_written, message );
}

void rf_begin_exr_write( RfExrStream* stream ) { s_written = stream; }

void rf_end_exr_write( void ) { s_written = NULL; }

static int64_t read_bytes( exr_const_context_t context, void* user, void* buffer, uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t report )
{
    (void)context;
    (void)report;
    RfExrStream* stream = user;
    if ( stream->bytes != NULL )
    {
        uint64_t left = offset < stream->size ? stream->size - offset : 0;
        uint64_t count = size < left ? size : left; // the library handles a short read
        memcpy( buffer, stream->bytes + ( count > 0 ? offset : 0 ), (size_t)count );
        return (int64_t)count;
    }
    char* next = buffer;
    uint64_t done = 0;
    while ( done < size && offset + done <= INT64_MAX )
    {
        ssize_t count = pread( stream->fd, next + done, size - done, (off_t)( offset + done ) );
        if ( count < 0 && errno == EINTR )
            continue;
        if ( count < 0 )
        {
            stream->io_error = stream->io_error != 0 ? stream->io_error : errno;
            return -1;
        }
        if ( count == 0 )
            break; // end of file: the library handles a short read
        done += (uint64_t)count;
    }
    return (int64_t)done;
}

static int64_t write_bytes( exr_const_context_t context, void* user, const void* buffer, uint64_t size, uint64_t offset,
                            exr_stream_error_func_ptr_t report )
{
    (void)context;
    (void)report;
    RfExrStream* stream = user;
    const char* next = buffer;
    uint64_t done = 0;
    while ( done < size )
    {
        ssize_t count = pwrite( stream->fd, next + done, size - done, (off_t)( offset + done ) );
        if ( count < 0 && errno == EINTR )
            continue;
        if ( count <= 0 )
        {
            stream->io_error = stream->io_error != 0 ? stream->io_error : count < 0 ? errno : EIO;
            return -1;
        }
        done += (uint64_t)count;
    }
    return (int64_t)done;
}

static int64_t query_size( exr_const_context_t context, void* user )
{
    (void)context;
    RfExrStream* stream = user;
    if ( stream->bytes != NULL )
        return (int64_t)stream->size;
    struct stat status;
    return fstat( stream->fd, &status ) == 0 ? (int64_t)status.st_size : -1;
}

exr_context_initializer_t rf_exr_initializer( RfExrStream* stream )
{
    int side = stream->max_side > 0 ? stream->max_side : RF_EXR_MAX_SIDE;
    errno = 0; // see rf_fail_exr
    return ( exr_context_initializer_t ){
        .size = sizeof( exr_context_initializer_t ),
        .error_handler_fn = s_written == stream ? keep_write_message : keep_read_message,
        .user_data = stream,
        .read_fn = read_bytes,
        .size_fn = query_size,
        .write_fn = write_bytes,
        .max_image_width = side,
        .max_image_height = side,
        .max_tile_width = side,
        .max_tile_height = side,
        .zip_level = -2, // the library's default
        .dwa_quality = -1.0f,
        // missing chunks are an error; do not search the file for them
        .flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION,
    };
}

#ifdef REFRAME_SANITIZED // the sanitizer detects overruns only in blocks of malloc

void* rf_alloc_exr_buffer( exr_transcoding_pipeline_buffer_id_t id, size_t bytes )
{
    (void)id;
    return malloc( bytes );
}

void rf_free_exr_buffer( exr_transcoding_pipeline_buffer_id_t id, void* buffer )
{
    (void)id;
    free( buffer );
}

#else

#define BUFFER_HEAD 64 // header before each buffer, which holds the size of the mapping

void* rf_alloc_exr_buffer( exr_transcoding_pipeline_buffer_id_t id, size_t bytes )
{
    (void)id;
    if ( bytes > SIZE_MAX - BUFFER_HEAD )
        return NULL;
    size_t all = bytes + BUFFER_HEAD;
    void* block = mmap( NULL, all, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0 );
    if ( block == MAP_FAILED )
        return NULL;
    memcpy( block, &all, sizeof all );
    return (char*)block + BUFFER_HEAD;
}

void rf_free_exr_buffer( exr_transcoding_pipeline_buffer_id_t id, void* buffer )
{
    (void)id;
    if ( buffer == NULL )
        return;
    void* block = (char*)buffer - BUFFER_HEAD;
    size_t all;
    memcpy( &all, block, sizeof all );
    munmap( block, all );
}

#endif

exr_result_t rf_start_exr( RfExrStream* stream, exr_context_t* context )
{
    exr_context_initializer_t initializer = rf_exr_initializer( stream );
    exr_result_t code = exr_start_read( context, stream->path, &initializer );
    // the library leaves attributes out for which it has no memory
    if ( code != EXR_ERR_SUCCESS || errno != ENOMEM )
        return code;
    exr_finish( context );
    return EXR_ERR_OUT_OF_MEMORY;
}

RfResult rf_fail_exr( const RfExrStream* stream, exr_result_t code, const char* what, RfError* error )
{
    if ( stream->io_error != 0 )
        return rf_fail_io( stream->path, what, stream->io_error, error );
    // zlib's lack of memory comes out as damaged data
    if ( code == EXR_ERR_OUT_OF_MEMORY || errno == ENOMEM )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: %s: out of memory: close other programs", stream->path, what );
    const char* why = stream->message[0] != 0 ? stream->message : exr_get_default_error_message( code );
    RfResult result = code == EXR_ERR_FEATURE_NOT_IMPLEMENTED ? RF_ERROR_UNSUPPORTED : RF_ERROR_FORMAT;
    return rf_fail( error, result, "%s: %s: %s", stream->path, what, why );
}
