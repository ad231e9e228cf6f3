// Chunks of EXR files that are compressed by DWA.
#include "image/exr_dwa.h"

#include "image/dwa.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
