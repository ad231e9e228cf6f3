// Writes EXR files, and reads back what was written.
#include "image/exr.h"

#include "image/atomic_file.h"
#include "image/exr_stream.h"
#include "image/half.h"

#include <string.h>

// Verifies a written EXR.

// Rounding to half has an error of up to half a unit in the last place: 2^-11 of the value, or
// 2^-25 in the subnormal range.
static bool is_half_of( float half, float value )
{
    value = rf_clamp_half( value );
    if ( isnan( value ) || isinf( value ) )
        return isnan( value ) ? isnan( half ) : half == value;
    float bound = fmaxf( 0x1p-11f * fabsf( value ), 0x1p-25f );
    return fabsf( half - value ) <= bound;
}

// The result of reading back.
typedef struct Check
{
    const RfExrChannel* channels;
    int width;
    bool same;
    size_t values; // number compared
} Check;

static void compare_line( void* user, int c, int x, int y, const float* values, int count )
{
    Check* check = user;
    const RfExrChannel* channel = check->channels + c;
    const float* source = channel->values + (size_t)channel->stride * ( (size_t)y * (size_t)check->width + (size_t)x );
    for ( int i = 0; i < count && check->same; ++i )
    {
        const float* value = source + (size_t)channel->stride * (size_t)i;
        // bits, so that NaN equals itself: NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
        check->same = channel->half ? is_half_of( values[i], *value ) : memcmp( values + i, value, sizeof *value ) == 0;
    }
    check->values += (size_t)count;
}

// Reads the file of the stream back and compares: the last defence against a library or a disk
// that lost data silently. `size` has the size of the channels.
static RfResult verify_exr( const RfExrStream* written, const RfExrChannel* channels, int count, const RfImage* size,
                            RfError* error )
{
    RfExrStream stream = { .path = written->path, .fd = written->fd };
    RfExrPart part;
    RfResult result = rf_open_exr_part( &stream, 0, &part, error );
    if ( result != RF_OK )
        return result;
    const char* names[RF_EXR_MAX_CHANNELS];
    for ( int c = 0; c < count; ++c )
        names[c] = channels[c].name;
    Check check = { channels, size->width, part.width == size->width && part.height == size->height, 0 };
    if ( check.same )
        result = rf_read_exr_lines( &part, names, count, compare_line, &check, error );
    rf_close_exr_part( &part );
    if ( result != RF_OK )
        return result;
    size_t all = (size_t)size->width * (size_t)size->height * (size_t)count;
    if ( !check.same || check.values != all )
        return rf_fail( error, RF_ERROR_IO, "%s: cannot be written: what was read back differs", stream.path );
    return RF_OK;
}

typedef struct Writer
{
    RfExrStream stream;
    exr_context_t context;
    const RfImage* image;
    const RfExrOptions* options;
    RfExrChannel channels[RF_EXR_MAX_CHANNELS]; // all channels, R G B first
    int channel_count;
    exr_encode_pipeline_t pipeline;
    exr_result_t ( *compress )( exr_encode_pipeline_t* ); // the library's function
    bool started;                                         // the pipeline is initialised
} Writer;

const char* const rf_compression_words[] = { [RF_EXR_NONE] = "none", [RF_EXR_ZIP] = "zip", [RF_EXR_PIZ] = "piz", NULL };

RfExrOptions rf_default_exr_options( void ) { return ( RfExrOptions ){ .compression = RF_EXR_ZIP, .half = true }; }

static RfResult check_options( const char* path, const RfImage* image, const RfExrOptions* options, RfError* error )
{
    if ( image->rgb == NULL || image->width < 1 || image->height < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "%s: an image without pixels cannot be written", path );
    if ( image->width > RF_EXR_MAX_SIDE || image->height > RF_EXR_MAX_SIDE )
        return rf_fail( error, RF_ERROR_USAGE, "%s: %dx%d pixels cannot be written: a side has at most %d", path, image->width,
                        image->height, RF_EXR_MAX_SIDE );
    if ( (unsigned)options->compression > RF_EXR_PIZ )
        return rf_fail( error, RF_ERROR_USAGE, "%s: there is no compression %d", path, (int)options->compression );
    if ( options->channel_count < 0 || options->channel_count > RF_EXR_MAX_CHANNELS - 3 )
        return rf_fail( error, RF_ERROR_USAGE, "%s: %d channels cannot be written: at most %d and R, G, B", path,
                        options->channel_count, RF_EXR_MAX_CHANNELS - 3 );
    if ( options->fps_numerator < 0 || ( options->fps_numerator > 0 && options->fps_denominator == 0 ) )
        return rf_fail( error, RF_ERROR_USAGE, "%s: %d/%u frames per second is not possible", path, options->fps_numerator,
                        options->fps_denominator );
    return RF_OK;
}

static int lines_per_chunk( RfExrCompression compression )
{
    return compression == RF_EXR_NONE ? 1 : compression == RF_EXR_ZIP ? 16 : 32;
}

// Memory of OpenEXRCore per byte of a chunk: packed 1, compressed 1.1, copy to be compressed
// 1, and at most as much for reading back; measured from 16 to 32768 pixels with 3.1.5. Plus
// one line of a channel for reading back.
size_t rf_exr_work_bytes( int width, int height, RfExrCompression compression, int pixel_bytes )
{
    int lines = lines_per_chunk( compression );
    size_t chunk = (size_t)width * (size_t)pixel_bytes * (size_t)( height < lines ? height : lines );
    return chunk + ( compression != RF_EXR_NONE ? chunk / 4 * 9 : 0 ) + (size_t)width * sizeof( float );
}

static exr_compression_t core_compression( RfExrCompression compression )
{
    return compression == RF_EXR_NONE  ? EXR_COMPRESSION_NONE
           : compression == RF_EXR_ZIP ? EXR_COMPRESSION_ZIP
                                       : EXR_COMPRESSION_PIZ;
}

static exr_result_t add_channels( Writer* writer )
{
    exr_result_t code = EXR_ERR_SUCCESS;
    for ( int c = 0; c < writer->channel_count && code == EXR_ERR_SUCCESS; ++c )
    {
        const RfExrChannel* channel = writer->channels + c;
        exr_pixel_type_t type = channel->half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
        code = exr_add_channel( writer->context, 0, channel->name, type,
                                c < 3 ? EXR_PERCEPTUALLY_LOGARITHMIC : EXR_PERCEPTUALLY_LINEAR, 1, 1 );
    }
    return code;
}

static void list_channels( Writer* writer )
{
    static const char* const names[3] = { "R", "G", "B" };
    const RfExrOptions* options = writer->options;
    for ( int c = 0; c < 3; ++c )
        writer->channels[c] = ( RfExrChannel ){ names[c], writer->image->rgb + c, 3, options->half };
    for ( int c = 0; c < options->channel_count; ++c )
        writer->channels[3 + c] = options->channels[c];
    writer->channel_count = 3 + options->channel_count;
}

static exr_result_t set_camera( exr_context_t context, const RfExrOptions* options )
{
    exr_attr_m44f_t world_to_camera, world_to_ndc;
    memcpy( world_to_camera.m, options->world_to_camera, sizeof world_to_camera.m );
    memcpy( world_to_ndc.m, options->world_to_ndc, sizeof world_to_ndc.m );
    exr_result_t code = exr_attr_set_m44f( context, 0, "worldToCamera", &world_to_camera );
    bool has_ndc = false;
    for ( int i = 0; i < 16; ++i )
        has_ndc = has_ndc || options->world_to_ndc[i] < 0.0f || options->world_to_ndc[i] > 0.0f;
    return code == EXR_ERR_SUCCESS && has_ndc ? exr_attr_set_m44f( context, 0, "worldToNDC", &world_to_ndc ) : code;
}

static exr_result_t set_attributes( Writer* writer )
{
    static const exr_attr_chromaticities_t rec709 = { 0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f };
    const RfExrOptions* options = writer->options;
    exr_result_t code = exr_attr_set_chromaticities( writer->context, 0, "chromaticities", &rec709 );
    if ( code == EXR_ERR_SUCCESS && options->fps_numerator > 0 )
    {
        exr_attr_rational_t fps = { .num = options->fps_numerator, .denom = options->fps_denominator };
        code = exr_attr_set_rational( writer->context, 0, "framesPerSecond", &fps );
    }
    if ( code == EXR_ERR_SUCCESS && options->has_camera )
        code = set_camera( writer->context, options );
    for ( int i = 0; i < options->string_count && code == EXR_ERR_SUCCESS; ++i )
        code = exr_attr_set_string( writer->context, 0, options->strings[i].name, options->strings[i].value );
    return code;
}

static exr_result_t set_window( Writer* writer, exr_compression_t compression )
{
    const RfExrOptions* options = writer->options;
    exr_attr_box2i_t window = { .min = { .x = options->x, .y = options->y },
                                .max = { .x = options->x + ( writer->image->width - 1 ),
                                         .y = options->y + ( writer->image->height - 1 ) } };
    const exr_attr_v2f_t center = { .x = 0.0f, .y = 0.0f };
    float aspect = writer->options->pixel_aspect > 0.0f ? writer->options->pixel_aspect : 1.0f;
    return exr_initialize_required_attr( writer->context, 0, &window, &window, aspect, &center, 1.0f, EXR_LINEORDER_INCREASING_Y,
                                         compression );
}

static exr_result_t write_header( Writer* writer )
{
    int index = 0;
    exr_compression_t compression = core_compression( writer->options->compression );
    exr_context_t context = writer->context;
    exr_result_t code = EXR_ERR_SUCCESS;
    // attribute names beyond 31 characters need a flag that old readers reject
    for ( int i = 0; i < writer->options->string_count && code == EXR_ERR_SUCCESS; ++i )
    {
        if ( strlen( writer->options->strings[i].name ) > 31 )
            code = exr_set_longname_support( context, 1 );
    }
    if ( code == EXR_ERR_SUCCESS )
        code = exr_add_part( context, NULL, EXR_STORAGE_SCANLINE, &index );
    if ( code == EXR_ERR_SUCCESS )
        code = set_window( writer, compression );
    if ( code == EXR_ERR_SUCCESS )
        code = add_channels( writer );
    if ( code == EXR_ERR_SUCCESS )
        code = set_attributes( writer );
    return code == EXR_ERR_SUCCESS ? exr_write_header( context ) : code;
}

static int find_channel( const Writer* writer, const char* name )
{
    int c = 0;
    while ( strcmp( writer->channels[c].name, name ) != 0 )
        ++c;
    return c;
}

// Points the pipeline, whose channels are sorted by name, at the values of line y.
static void set_channel_sources( Writer* writer, int y )
{
    for ( int i = 0; i < writer->pipeline.channel_count; ++i )
    {
        exr_coding_channel_info_t* info = writer->pipeline.channels + i;
        const RfExrChannel* channel = writer->channels + find_channel( writer, info->channel_name );
        size_t before = (size_t)channel->stride * (size_t)writer->image->width * (size_t)y;
        info->encode_from_ptr = (const uint8_t*)( channel->values + before );
        info->user_data_type = EXR_PIXEL_FLOAT;
        info->user_bytes_per_element = sizeof( float );
        info->user_pixel_stride = channel->stride * (int32_t)sizeof( float );
        info->user_line_stride = info->user_pixel_stride * writer->image->width;
    }
}

// Packs one line of a channel as stored. Stored values are little-endian, like the supported
// machines.
static uint8_t* pack_line( const exr_coding_channel_info_t* channel, const float* values, uint8_t* packed )
{
    int stride = channel->user_pixel_stride / (int)sizeof( float );
    for ( int x = 0; x < channel->width; ++x, values += stride, packed += channel->bytes_per_element )
    {
        uint16_t half = channel->data_type == EXR_PIXEL_HALF ? rf_float_to_half( rf_clamp_half( *values ) ) : 0;
        memcpy( packed, channel->data_type == EXR_PIXEL_HALF ? (const void*)&half : values, (size_t)channel->bytes_per_element );
    }
    return packed;
}

// Replaces the library's packing routine, which does not clamp; clamped copies of all lines of
// a chunk would need more memory than the packed ones.
static exr_result_t pack( exr_encode_pipeline_t* pipeline )
{
    uint8_t* packed = pipeline->packed_buffer;
    for ( int32_t line = 0; line < pipeline->chunk.height; ++line )
    {
        for ( int i = 0; i < pipeline->channel_count; ++i )
        {
            const exr_coding_channel_info_t* channel = pipeline->channels + i;
            const uint8_t* from = channel->encode_from_ptr + (size_t)line * (size_t)channel->user_line_stride;
            packed = pack_line( channel, (const float*)(const void*)from, packed );
        }
    }
    pipeline->packed_bytes = (size_t)( packed - (uint8_t*)pipeline->packed_buffer );
    return EXR_ERR_SUCCESS;
}

// Stores a chunk uncompressed unless compression makes it smaller. OpenEXRCore up to 3.4.7
// does so only if it gets larger, and when reading, takes compressed data of exactly the
// original size for uncompressed (github.com/AcademySoftwareFoundation/openexr/issues/2306).
static exr_result_t compress( exr_encode_pipeline_t* pipeline )
{
    const Writer* writer = pipeline->encoding_user_data;
    exr_result_t code = writer->compress( pipeline );
    if ( code == EXR_ERR_SUCCESS && pipeline->compressed_bytes == pipeline->packed_bytes &&
         pipeline->compressed_buffer != pipeline->packed_buffer )
        memcpy( pipeline->compressed_buffer, pipeline->packed_buffer, pipeline->packed_bytes );
    return code;
}

static exr_result_t choose_routines( Writer* writer )
{
    exr_result_t code = exr_encoding_choose_default_routines( writer->context, 0, &writer->pipeline );
    writer->pipeline.convert_and_pack_fn = pack;
    if ( code != EXR_ERR_SUCCESS || writer->pipeline.compress_fn == NULL || writer->pipeline.compress_fn == compress )
        return code;
    writer->compress = writer->pipeline.compress_fn;
    writer->pipeline.compress_fn = compress;
    writer->pipeline.encoding_user_data = writer;
    return code;
}

static exr_result_t write_chunk( Writer* writer, int y )
{
    exr_chunk_info_t chunk = { 0 };
    exr_result_t code = exr_write_scanline_chunk_info( writer->context, 0, writer->options->y + y, &chunk );
    if ( code != EXR_ERR_SUCCESS )
        return code;
    code = writer->started ? exr_encoding_update( writer->context, 0, &chunk, &writer->pipeline )
                           : exr_encoding_initialize( writer->context, 0, &chunk, &writer->pipeline );
    writer->started = true;
    writer->pipeline.alloc_fn = rf_alloc_exr_buffer;
    writer->pipeline.free_fn = rf_free_exr_buffer;
    if ( code == EXR_ERR_SUCCESS )
    {
        set_channel_sources( writer, y );
        code = choose_routines( writer );
    }
    return code == EXR_ERR_SUCCESS ? exr_encoding_run( writer->context, 0, &writer->pipeline ) : code;
}

static exr_result_t write_chunks( Writer* writer )
{
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk( writer->context, 0, &lines );
    if ( code != EXR_ERR_SUCCESS || lines < 1 )
        return code != EXR_ERR_SUCCESS ? code : EXR_ERR_UNKNOWN;
    for ( int64_t y = 0; y < writer->image->height && code == EXR_ERR_SUCCESS; y += lines )
        code = write_chunk( writer, (int)y );
    return code;
}

static RfResult write_stream( Writer* writer, RfError* error )
{
    rf_begin_exr_write( &writer->stream );
    exr_context_initializer_t initializer = rf_exr_initializer( &writer->stream );
    exr_result_t code = exr_start_write( &writer->context, writer->stream.path, EXR_WRITE_FILE_DIRECTLY, &initializer );
    if ( code == EXR_ERR_SUCCESS )
        code = write_header( writer );
    if ( code == EXR_ERR_SUCCESS )
        code = write_chunks( writer );
    if ( writer->started )
        exr_encoding_destroy( writer->context, &writer->pipeline );
    exr_result_t finish_code = writer->context != NULL ? exr_finish( &writer->context ) : EXR_ERR_SUCCESS;
    rf_end_exr_write();
    code = code != EXR_ERR_SUCCESS ? code : finish_code;
    if ( code != EXR_ERR_SUCCESS || writer->stream.io_error != 0 )
        return rf_fail_exr( &writer->stream, code, "cannot be written", error );
    return RF_OK;
}

RfResult rf_write_exr( const char* path, const RfImage* image, const RfExrOptions* options, RfError* error )
{
    RfResult result = check_options( path, image, options, error );
    if ( result != RF_OK )
        return result;
    RfAtomicFile file;
    result = rf_open_atomic_file( path, &file, error );
    if ( result != RF_OK )
        return result;
    Writer writer = { .stream = { .path = path, .fd = file.fd }, .image = image, .options = options };
    list_channels( &writer );
    result = write_stream( &writer, error );
    if ( result == RF_OK )
        result = verify_exr( &writer.stream, writer.channels, writer.channel_count, image, error );
    if ( result == RF_OK )
        return rf_commit_atomic_file( &file, error );
    rf_discard_atomic_file( &file );
    return result;
}
