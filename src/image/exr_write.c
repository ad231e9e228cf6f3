// Writes EXR files, and reads back what was written.
#include "base/try.h"
#include "image/exr.h"

#include "base/file.h"
#include "image/atomic_file.h"
#include "image/colour.h"
#include "image/exr_stream.h"
#include "image/half.h"

#include <errno.h>
#include <float.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

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

// The value of a pixel that the file has, where the channel's is at `value`.
static float stored( const RfExrChannel* channel, const RfColourConversion* conversion, const float* value )
{
    RfColourKind kind = channel->meaning == RF_EXR_VARIANCE ? RF_COLOUR_VARIANCE : RF_COLOUR_LIGHT;
    bool converts = conversion->needed && channel->meaning != RF_EXR_DATA;
    float is = converts ? rf_convert_component( conversion, kind, channel->component, value - channel->component ) : *value;
    return channel->negated ? -is : is;
}

// A part of the file that is written.
typedef struct Part
{
    const char* name;
    RfExrCompression compression;
    int first, count; // of the writer's channels, by name
    uint64_t hash;    // of what is written, for its checksum
} Part;

typedef struct Writer
{
    RfExrStream stream;
    exr_context_t context;
    const RfImage* image;
    const RfExrOptions* options;
    RfExrChannel channels[RF_EXR_MAX_CHANNELS]; // all channels, by part and name
    int channel_count;
    Part parts[RF_EXR_MAX_CHANNELS];
    int part_count;
    int part;                          // that is being written
    bool changes[RF_EXR_MAX_CHANNELS]; // channels that DWA changes
    bool not_finite;                   // one of these has a NaN or an infinite value
    char colour[3][256];               // names of R, G and B
    RfColourConversion conversion;     // to the file's colour space
    exr_encode_pipeline_t pipeline;
    exr_result_t ( *compress )( exr_encode_pipeline_t* ); // the library's function
    bool started;                                         // the pipeline is initialised
} Writer;

// The result of reading back.
typedef struct Check
{
    const RfExrChannel* channels;
    const RfColourConversion* conversion;
    const bool* changes; // by DWA
    int width;
    bool same;
    size_t values;                       // number compared
    double sums[RF_EXR_MAX_CHANNELS][2]; // of channels that DWA changes: squares of values and of errors, in its scale
} Check;

static float clamp_dwa( float value ) { return fminf( fmaxf( value, -RF_DWA_MOST ), RF_DWA_MOST ); }

static void add_error( double sums[2], float value, float read )
{
    double wanted = rf_dwa_scale( (double)clamp_dwa( value ) ), error = rf_dwa_scale( (double)read ) - wanted;
    sums[0] += wanted * wanted;
    sums[1] += error * error;
}

// The colours that DWA has changed are off by no more than it may: in blocks of 8 by 8 pixels, of which an image may have a part only.
static bool is_dwa_within( const Check* check, const RfExrPart* part, int count, float level )
{
    double pixels = ceil( part->width / 8.0 ) * 8.0 * ceil( part->height / 8.0 ) * 8.0, most = 0.0;
    for ( int c = 0; c < count; ++c )
        most = fmax( most, check->sums[c][0] );
    double bound = rf_dwa_error_bound( (double)level, sqrt( most / pixels ) );
    bool within = true;
    for ( int c = 0; c < count; ++c )
        within = within && check->sums[c][1] <= bound * bound * pixels; // false for NaN
    return within;
}

static void compare_line( void* user, int c, int x, int y, const float* values, int count )
{
    Check* check = user;
    const RfExrChannel* channel = check->channels + c;
    const float* source = channel->values + (size_t)channel->stride * ( (size_t)y * (size_t)check->width + (size_t)x );
    for ( int i = 0; i < count && check->same; ++i )
    {
        float value = stored( channel, check->conversion, source + (size_t)channel->stride * (size_t)i );
        if ( check->changes[c] )
        {
            add_error( check->sums[c], value, values[i] );
            continue;
        }
        // bits, so that NaN equals itself: NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
        check->same = channel->half ? is_half_of( values[i], value ) : memcmp( values + i, &value, sizeof value ) == 0;
    }
    check->values += (size_t)count;
}

// Reads a part of the file back and compares: the last defence against a library or a disk that lost data silently.
static RfResult verify_part( const Writer* writer, int index, RfError* error )
{
    const Part* written = writer->parts + index;
    RfExrStream stream = { .path = writer->stream.path, .fd = writer->stream.fd };
    RfExrPart part;
    RF_TRY( rf_open_exr_part( &stream, index, &part, error ) );
    const RfImage* size = writer->image;
    const char* names[RF_EXR_MAX_CHANNELS];
    for ( int c = 0; c < written->count; ++c )
        names[c] = writer->channels[written->first + c].name;
    Check check = {
        .channels = writer->channels + written->first,
        .conversion = &writer->conversion,
        .changes = writer->changes + written->first,
        .width = size->width,
        .same = part.width == size->width && part.height == size->height,
    };
    bool same = true;
    RfResult result = RF_OK;
    if ( check.same )
        result = rf_verify_exr_lines( &part, names, written->count, compare_line, &check, &same, error );
    bool within = is_dwa_within( &check, &part, written->count, writer->options->dwa_level );
    rf_close_exr_part( &part );
    if ( result != RF_OK )
        return result;
    size_t all = (size_t)size->width * (size_t)size->height * (size_t)written->count;
    if ( !check.same || !same || !within || check.values != all )
        return rf_fail( error, RF_ERROR_IO, "%s: cannot be written: what was read back differs", stream.path );
    return RF_OK;
}

const char* const rf_compression_words[] = { [RF_EXR_NONE] = "none",
                                             [RF_EXR_ZIP] = "zip",
                                             [RF_EXR_PIZ] = "piz",
                                             [RF_EXR_ZIPS] = "zips",
                                             [RF_EXR_DWAA] = "dwaa",
                                             [RF_EXR_DWAB] = "dwab",
                                             NULL };

RfExrOptions rf_default_exr_options( void )
{
    return ( RfExrOptions ){ .compression = RF_EXR_ZIP, .dwa_level = RF_EXR_DWA_LEVEL, .half = true };
}

static RfResult check_options( const char* path, const RfImage* image, const RfExrOptions* options, RfError* error )
{
    if ( image->rgb == NULL || image->width < 1 || image->height < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "%s: an image without pixels cannot be written", path );
    if ( image->width > RF_EXR_MAX_SIDE || image->height > RF_EXR_MAX_SIDE )
        return rf_fail( error, RF_ERROR_USAGE, "%s: %dx%d pixels cannot be written: a side has at most %d", path, image->width,
                        image->height, RF_EXR_MAX_SIDE );
    if ( (unsigned)options->compression > RF_EXR_DWAB )
        return rf_fail( error, RF_ERROR_USAGE, "%s: unknown compression %d", path, (int)options->compression );
    if ( rf_is_dwa( options->compression ) && !rf_has_dwa() )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: this build of reframe lacks DWA: choose ZIP or PIZ", path );
    if ( rf_is_dwa( options->compression ) && !( options->dwa_level >= 0.0f && options->dwa_level <= RF_EXR_MAX_DWA_LEVEL ) )
        return rf_fail( error, RF_ERROR_USAGE, "%s: a level of DWA is 0 to %g, not %g", path, (double)RF_EXR_MAX_DWA_LEVEL,
                        (double)options->dwa_level );
    if ( (unsigned)options->colour_space > RF_ACESCG )
        return rf_fail( error, RF_ERROR_USAGE, "%s: unknown colour space %d", path, (int)options->colour_space );
    if ( options->channel_count < 0 || options->channel_count > RF_EXR_MAX_CHANNELS - 3 )
        return rf_fail( error, RF_ERROR_USAGE, "%s: %d channels cannot be written: at most %d and R, G, B", path,
                        options->channel_count, RF_EXR_MAX_CHANNELS - 3 );
    if ( options->fps_numerator < 0 || ( options->fps_numerator > 0 && options->fps_denominator == 0 ) )
        return rf_fail( error, RF_ERROR_USAGE, "%s: %d/%u frames per second is not possible", path, options->fps_numerator,
                        options->fps_denominator );
    const RfExrWindow* display = &options->display;
    if ( display->width < 0 || display->height < 0 || ( display->width == 0 ) != ( display->height == 0 ) )
        return rf_fail( error, RF_ERROR_USAGE, "%s: a display window of %dx%d pixels is not possible", path, display->width,
                        display->height );
    return RF_OK;
}

static const exr_compression_t s_core_compressions[] = {
    [RF_EXR_NONE] = EXR_COMPRESSION_NONE, [RF_EXR_ZIP] = EXR_COMPRESSION_ZIP,   [RF_EXR_PIZ] = EXR_COMPRESSION_PIZ,
    [RF_EXR_ZIPS] = EXR_COMPRESSION_ZIPS, [RF_EXR_DWAA] = EXR_COMPRESSION_DWAA, [RF_EXR_DWAB] = EXR_COMPRESSION_DWAB,
};

static const int s_lines_per_chunk[] = {
    [RF_EXR_NONE] = 1, [RF_EXR_ZIP] = 16, [RF_EXR_PIZ] = 32, [RF_EXR_ZIPS] = 1, [RF_EXR_DWAA] = 32, [RF_EXR_DWAB] = 256
};

// Memory of OpenEXRCore per byte of a chunk: packed 1, compressed 1.1, copy to be compressed
// 1, and at most as much for reading back; measured from 16 to 32768 pixels with 3.1.5. Of the C++ library with DWA 5 to 6, and
// tables. Plus one line of a channel for reading back.
size_t rf_exr_work_bytes( int width, int height, RfExrCompression compression, int pixel_bytes )
{
    int lines = s_lines_per_chunk[compression];
    size_t chunk = (size_t)width * (size_t)pixel_bytes * (size_t)( height < lines ? height : lines );
    size_t line = (size_t)width * sizeof( float );
    if ( rf_is_dwa( compression ) )
        return chunk / 4 * 25 + ( (size_t)2 << 20 ) + line;
    return chunk + ( compression != RF_EXR_NONE ? chunk / 4 * 9 : 0 ) + line;
}

static exr_result_t add_channels( Writer* writer )
{
    const Part* part = writer->parts + writer->part;
    exr_result_t code = EXR_ERR_SUCCESS;
    for ( int c = part->first; c < part->first + part->count && code == EXR_ERR_SUCCESS; ++c )
    {
        const RfExrChannel* channel = writer->channels + c;
        exr_pixel_type_t type = channel->half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
        bool is_colour = false;
        for ( int i = 0; i < 3; ++i )
            is_colour = is_colour || channel->name == writer->colour[i];
        code = exr_add_channel( writer->context, writer->part, channel->name, type,
                                is_colour ? EXR_PERCEPTUALLY_LOGARITHMIC : EXR_PERCEPTUALLY_LINEAR, 1, 1 );
    }
    return code;
}

// The part of this name, a new one where there is none.
static int part_called( Writer* writer, const char* name )
{
    int p = 0;
    while ( p < writer->part_count && strcmp( writer->parts[p].name, name ) != 0 )
        ++p;
    if ( p == writer->part_count )
        writer->parts[writer->part_count++] = ( Part ){ .name = name, .compression = writer->options->compression };
    return p;
}

// Puts a channel of part p behind those of the parts before it and of the names before its own.
static void insert_channel( Writer* writer, int p, const RfExrChannel* channel )
{
    const Part* part = writer->parts + p;
    int c = part->first + part->count;
    memmove( writer->channels + c + 1, writer->channels + c, (size_t)( writer->channel_count - c ) * sizeof *channel );
    for ( ; c > part->first && strcmp( writer->channels[c - 1].name, channel->name ) > 0; --c )
        writer->channels[c] = writer->channels[c - 1];
    writer->channels[c] = *channel;
    ++writer->channel_count;
    ++writer->parts[p].count;
    for ( int later = p + 1; later < writer->part_count; ++later )
        ++writer->parts[later].first;
}

static const char* last_word( const char* name )
{
    const char* dot = strrchr( name, '.' );
    return dot != NULL ? dot + 1 : name;
}

// Whether the channel is one of R, G and B of a layer, all three of which may change.
static bool is_dwa_colour( const Writer* writer, const Part* part, const RfExrChannel* channel )
{
    const char* word = last_word( channel->name );
    size_t length = (size_t)( word - channel->name );
    if ( strlen( word ) != 1 || strchr( "RGB", word[0] ) == NULL )
        return false;
    int found = 0;
    for ( int c = part->first; c < part->first + part->count; ++c )
    {
        const RfExrChannel* other = writer->channels + c;
        const char* its = last_word( other->name );
        found += (size_t)( its - other->name ) == length && strncmp( other->name, channel->name, length ) == 0 &&
                 strlen( its ) == 1 && strchr( "RGB", its[0] ) != NULL && other->lossy && other->half == channel->half;
    }
    return found == 3;
}

// Which channels of a part DWA changes. Readers go by rules that are in the file, for the last word of a name and the type: R of
// halves changes, R of floats does not, but not R of halves in one layer alone.
static RfResult settle_dwa( Writer* writer, Part* part, RfError* error )
{
    int count = 0, end = part->first + part->count;
    for ( int c = part->first; c < end; ++c )
        count += writer->changes[c] = is_dwa_colour( writer, part, writer->channels + c );
    part->compression = count > 0 ? part->compression : RF_EXR_ZIP;
    for ( int c = part->first; c < end && count > 0; ++c )
    {
        for ( int k = part->first; k < end; ++k )
        {
            const RfExrChannel *change = writer->channels + c, *keep = writer->channels + k;
            if ( writer->changes[c] && !writer->changes[k] && change->half == keep->half &&
                 strcmp( last_word( change->name ), last_word( keep->name ) ) == 0 )
                return rf_fail(
                    error, RF_ERROR_USAGE,
                    "%s: DWA cannot keep %.100s as it is in one part with %.100s, both of %d bits: store them in parts",
                    writer->stream.path, keep->name, change->name, keep->half ? 16 : 32 );
        }
    }
    return RF_OK;
}

static RfResult list_channels( Writer* writer, RfError* error )
{
    static const char letters[3] = { 'R', 'G', 'B' };
    const RfExrOptions* options = writer->options;
    const char *colour = options->part != NULL ? options->part : "rgba", *path = writer->stream.path;
    writer->parts[writer->part_count++] = ( Part ){ .name = colour, .compression = options->compression };
    for ( int i = 0; i < 3 + options->channel_count; ++i )
    {
        RfExrChannel channel;
        if ( i < 3 )
        {
            snprintf( writer->colour[i], sizeof writer->colour[i], "%s%s%c", options->layer != NULL ? options->layer : "",
                      options->layer != NULL ? "." : "", letters[i] );
            channel = ( RfExrChannel ){
                .name = writer->colour[i],
                .values = writer->image->rgb + i,
                .stride = 3,
                .half = options->half,
                .lossy = true,
                .meaning = RF_EXR_COLOUR,
                .component = i,
            };
        }
        else
            channel = options->channels[i - 3];
        if ( strlen( channel.name ) > 255 || ( i < 3 && options->layer != NULL && strlen( options->layer ) > 253 ) )
            return rf_fail( error, RF_ERROR_USAGE, "%s: the name of a channel is too long: '%.100s...': at most 255 bytes", path,
                            channel.name );
        int p = channel.part != NULL ? part_called( writer, channel.part ) : 0;
        if ( writer->parts[p].count == 0 )
            writer->parts[p].first = writer->channel_count;
        insert_channel( writer, p, &channel );
    }
    rf_convert_between( rf_chromaticities_of( RF_REC709 ), rf_chromaticities_of( options->colour_space ), &writer->conversion );
    RfResult result = RF_OK;
    for ( int p = 0; p < writer->part_count && rf_is_dwa( options->compression ) && result == RF_OK; ++p )
        result = settle_dwa( writer, writer->parts + p, error );
    return result;
}

// Whether value i of a channel is beyond what the file holds. Infinity is kept.
static bool is_clipped( const Writer* writer, int c, size_t i )
{
    const RfExrChannel* channel = writer->channels + c;
    float size = fabsf( stored( channel, &writer->conversion, channel->values + (size_t)channel->stride * i ) );
    return size > ( writer->changes[c] ? RF_DWA_MOST : RF_HALF_MAX ) && size <= FLT_MAX;
}

static void mark_clipped( const Writer* writer, const char* name, bool clipped[RF_EXR_MAX_CHANNELS] )
{
    for ( int i = 0; i < writer->channel_count; ++i )
        clipped[i] = clipped[i] || name == ( i < 3 ? writer->colour[i] : writer->options->channels[i - 3].name );
}

size_t rf_count_clipped( const RfImage* image, const RfExrOptions* options, bool clipped[RF_EXR_MAX_CHANNELS] )
{
    Writer writer = { .stream = { .path = "" }, .image = image, .options = options };
    size_t pixels = (size_t)image->width * (size_t)image->height, count = 0;
    int found[RF_EXR_MAX_CHANNELS], found_count = 0;
    memset( clipped, 0, RF_EXR_MAX_CHANNELS * sizeof *clipped );
    if ( list_channels( &writer, NULL ) != RF_OK )
        return 0; // nothing is written
    for ( int c = 0; c < writer.channel_count; ++c )
    {
        bool any = false;
        for ( size_t i = 0; i < pixels && !any && ( writer.channels[c].half || writer.changes[c] ); ++i )
            any = is_clipped( &writer, c, i );
        if ( any )
            mark_clipped( &writer, writer.channels[c].name, clipped );
        found[found_count] = c;
        found_count += any;
    }
    for ( size_t i = 0; i < pixels && found_count > 0; ++i )
    {
        bool any = false;
        for ( int k = 0; k < found_count && !any; ++k )
            any = is_clipped( &writer, found[k], i );
        count += any;
    }
    return count;
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

static exr_result_t set_attribute( Writer* writer, const RfExrAttribute* attribute )
{
    exr_attr_m44f_t matrix;
    const exr_attr_timecode_t timecode = { .time_and_flags = attribute->timecode[0], .user_data = attribute->timecode[1] };
    memcpy( matrix.m, attribute->values, sizeof matrix.m );
    if ( attribute->type == RF_EXR_TIMECODE )
        return exr_attr_set_timecode( writer->context, writer->part, attribute->name, &timecode );
    if ( writer->part > 0 )
        return EXR_ERR_SUCCESS;
    return attribute->type == RF_EXR_FLOAT ? exr_attr_set_float( writer->context, 0, attribute->name, attribute->values[0] )
                                           : exr_attr_set_m44f( writer->context, 0, attribute->name, &matrix );
}

// The display window, the shape of a pixel, chromaticities and time code are those of the whole file and in each part ("Multi-Part
// OpenEXR Files", technical introduction to OpenEXR); readers look for the rest in the first.
static exr_result_t set_attributes( Writer* writer )
{
    const RfExrOptions* options = writer->options;
    exr_attr_chromaticities_t chromaticities;
    memcpy( &chromaticities, rf_chromaticities_of( options->colour_space ), sizeof chromaticities );
    exr_result_t code = exr_attr_set_chromaticities( writer->context, writer->part, "chromaticities", &chromaticities );
    for ( int i = 0; i < options->attribute_count && code == EXR_ERR_SUCCESS; ++i )
        code = set_attribute( writer, options->attributes + i );
    if ( code == EXR_ERR_SUCCESS && rf_is_dwa( writer->parts[writer->part].compression ) )
        code = exr_attr_set_float( writer->context, writer->part, "dwaCompressionLevel", options->dwa_level );
    if ( writer->part > 0 )
        return code;
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

// Copies what is not set yet from the part of the same name, or else the first, of the file options->like.
static exr_result_t copy_attributes( Writer* writer )
{
    exr_context_t from = NULL;
    RfExrStream stream;
    if ( writer->options->like == NULL )
        return EXR_ERR_SUCCESS;
    if ( rf_open_exr_file( writer->options->like, &stream, NULL ) != RF_OK )
        return EXR_ERR_FILE_ACCESS;
    exr_result_t code = rf_start_exr( &stream, &from );
    int count = 0, index = 0;
    if ( code == EXR_ERR_SUCCESS )
        code = exr_get_count( from, &count );
    for ( int p = 0; p < count; ++p )
    {
        const char* name = NULL;
        if ( exr_get_name( from, p, &name ) == EXR_ERR_SUCCESS && name != NULL &&
             strcmp( name, writer->parts[writer->part].name ) == 0 )
            index = p;
    }
    if ( code == EXR_ERR_SUCCESS )
        code = exr_copy_unset_attributes( writer->context, writer->part, from, index );
    if ( from != NULL )
        exr_finish( &from );
    close( stream.fd );
    return code;
}

static exr_result_t set_window( Writer* writer )
{
    const RfExrOptions* options = writer->options;
    exr_attr_box2i_t window = { .min = { .x = options->x, .y = options->y },
                                .max = { .x = options->x + ( writer->image->width - 1 ),
                                         .y = options->y + ( writer->image->height - 1 ) } };
    const RfExrWindow* asked = &options->display;
    exr_attr_box2i_t display = { .min = { .x = asked->x, .y = asked->y },
                                 .max = { .x = asked->x + ( asked->width - 1 ), .y = asked->y + ( asked->height - 1 ) } };
    const exr_attr_v2f_t center = { .x = 0.0f, .y = 0.0f };
    float aspect = writer->options->pixel_aspect > 0.0f ? writer->options->pixel_aspect : 1.0f;
    return exr_initialize_required_attr( writer->context, writer->part, asked->width > 0 ? &display : &window, &window, aspect,
                                         &center, 1.0f, EXR_LINEORDER_INCREASING_Y,
                                         s_core_compressions[writer->parts[writer->part].compression] );
}

#define CHECKSUM_SIZE 32

static void format_checksum( const Part* part, char text[CHECKSUM_SIZE] )
{
    snprintf( text, CHECKSUM_SIZE, "%s" RF_EXR_SUM_FORMAT,
              rf_is_dwa( part->compression ) ? RF_EXR_CHUNKS_SUM : RF_EXR_SAMPLES_SUM, (unsigned long long)part->hash );
}

static exr_result_t write_part_header( Writer* writer )
{
    int index = 0;
    exr_result_t code = exr_add_part( writer->context, writer->part_count > 1 ? writer->parts[writer->part].name : NULL,
                                      EXR_STORAGE_SCANLINE, &index );
    if ( code == EXR_ERR_SUCCESS )
        code = set_window( writer );
    if ( code == EXR_ERR_SUCCESS )
        code = add_channels( writer );
    if ( code == EXR_ERR_SUCCESS )
        code = set_attributes( writer );
    char text[CHECKSUM_SIZE];
    format_checksum( writer->parts + writer->part, text );
    if ( code == EXR_ERR_SUCCESS )
        code = exr_attr_set_string( writer->context, writer->part, RF_EXR_CHECKSUM, text );
    return code == EXR_ERR_SUCCESS ? copy_attributes( writer ) : code;
}

// Names beyond 31 characters need a flag that old readers reject.
static bool has_long_name( const Writer* writer )
{
    bool has = false;
    for ( int i = 0; i < writer->options->string_count; ++i )
        has = has || strlen( writer->options->strings[i].name ) > 31;
    for ( int i = 0; i < writer->options->attribute_count; ++i )
        has = has || strlen( writer->options->attributes[i].name ) > 31;
    for ( int c = 0; c < writer->channel_count; ++c )
        has = has || strlen( writer->channels[c].name ) > 31;
    return has;
}

static exr_result_t write_header( Writer* writer )
{
    exr_result_t code = has_long_name( writer ) ? exr_set_longname_support( writer->context, 1 ) : EXR_ERR_SUCCESS;
    for ( writer->part = 0; writer->part < writer->part_count && code == EXR_ERR_SUCCESS; ++writer->part )
        code = write_part_header( writer );
    return code == EXR_ERR_SUCCESS ? exr_write_header( writer->context ) : code;
}

// Points the pipeline, whose channels are sorted by name, at the values of line y.
static void set_channel_sources( Writer* writer, int y )
{
    const Part* part = writer->parts + writer->part;
    for ( int i = 0; i < writer->pipeline.channel_count; ++i )
    {
        exr_coding_channel_info_t* info = writer->pipeline.channels + i;
        const RfExrChannel* channel = writer->channels + part->first + i;
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
static uint8_t* pack_line( const RfExrChannel* source, const RfColourConversion* conversion,
                           const exr_coding_channel_info_t* channel, const float* values, bool changes, uint8_t* packed )
{
    for ( int x = 0; x < channel->width; ++x, values += source->stride, packed += channel->bytes_per_element )
    {
        float value = stored( source, conversion, values );
        value = changes ? clamp_dwa( value ) : value;
        uint16_t half = channel->data_type == EXR_PIXEL_HALF ? rf_float_to_half( rf_clamp_half( value ) ) : 0;
        memcpy( packed, channel->data_type == EXR_PIXEL_HALF ? (const void*)&half : &value, (size_t)channel->bytes_per_element );
    }
    return packed;
}

// DWA turns NaN and infinite values to 0.
static bool is_finite_line( const float* values, const exr_coding_channel_info_t* channel )
{
    bool finite = true;
    for ( int x = 0; x < channel->width; ++x )
        finite = finite && isfinite( values[(size_t)x * (size_t)channel->user_pixel_stride / sizeof( float )] );
    return finite;
}

// Replaces the library's packing routine, which does not clamp; clamped copies of all lines of
// a chunk would need more memory than the packed ones.
static exr_result_t pack( exr_encode_pipeline_t* pipeline )
{
    Writer* writer = pipeline->encoding_user_data;
    Part* part = writer->parts + writer->part;
    const RfExrChannel* sources = writer->channels + part->first;
    const bool* changes = writer->changes + part->first;
    uint8_t* packed = pipeline->packed_buffer;
    for ( int32_t line = 0; line < pipeline->chunk.height; ++line )
    {
        const uint8_t* begin = packed;
        for ( int i = 0; i < pipeline->channel_count; ++i )
        {
            const exr_coding_channel_info_t* channel = pipeline->channels + i;
            const uint8_t* from = channel->encode_from_ptr + (size_t)line * (size_t)channel->user_line_stride;
            const float* values = (const float*)(const void*)from;
            if ( changes[i] && !is_finite_line( values, channel ) )
            {
                writer->not_finite = true;
                return EXR_ERR_INVALID_ARGUMENT;
            }
            packed = pack_line( sources + i, &writer->conversion, channel, values, changes[i], packed );
        }
        if ( !rf_is_dwa( part->compression ) )
            part->hash = rf_hash_bytes( part->hash, begin, (size_t)( packed - begin ) );
    }
    pipeline->packed_bytes = (size_t)( packed - (uint8_t*)pipeline->packed_buffer );
    return EXR_ERR_SUCCESS;
}

// Stores a chunk uncompressed unless compression makes it smaller. OpenEXRCore up to 3.4.7
// does so only if it gets larger, and when reading, takes compressed data of exactly the
// original size for uncompressed (github.com/AcademySoftwareFoundation/openexr/issues/2306).
static exr_result_t compress( exr_encode_pipeline_t* pipeline )
{
    Writer* writer = pipeline->encoding_user_data;
    Part* part = writer->parts + writer->part;
    exr_result_t code;
    if ( rf_is_dwa( part->compression ) )
    {
        code = rf_compress_dwa_chunk( pipeline, &writer->stream, writer->changes + part->first, writer->options->dwa_level );
        if ( code == EXR_ERR_SUCCESS )
            part->hash = rf_hash_bytes( part->hash, pipeline->compressed_buffer, pipeline->compressed_bytes );
        return code;
    }
    code = writer->compress( pipeline );
    if ( code == EXR_ERR_SUCCESS && pipeline->compressed_bytes == pipeline->packed_bytes &&
         pipeline->compressed_buffer != pipeline->packed_buffer )
        memcpy( pipeline->compressed_buffer, pipeline->packed_buffer, pipeline->packed_bytes );
    return code;
}

static exr_result_t choose_routines( Writer* writer )
{
    exr_result_t code = exr_encoding_choose_default_routines( writer->context, writer->part, &writer->pipeline );
    writer->pipeline.convert_and_pack_fn = pack;
    writer->pipeline.encoding_user_data = writer;
    if ( code != EXR_ERR_SUCCESS || writer->pipeline.compress_fn == NULL || writer->pipeline.compress_fn == compress )
        return code;
    writer->compress = writer->pipeline.compress_fn;
    writer->pipeline.compress_fn = compress;
    return code;
}

static exr_result_t write_chunk( Writer* writer, int y )
{
    exr_chunk_info_t chunk = { 0 };
    exr_result_t code = exr_write_scanline_chunk_info( writer->context, writer->part, writer->options->y + y, &chunk );
    if ( code != EXR_ERR_SUCCESS )
        return code;
    code = writer->started ? exr_encoding_update( writer->context, writer->part, &chunk, &writer->pipeline )
                           : exr_encoding_initialize( writer->context, writer->part, &chunk, &writer->pipeline );
    writer->started = true;
    writer->pipeline.alloc_fn = rf_alloc_exr_buffer;
    writer->pipeline.free_fn = rf_free_exr_buffer;
    if ( code == EXR_ERR_SUCCESS )
    {
        set_channel_sources( writer, y );
        code = choose_routines( writer );
    }
    return code == EXR_ERR_SUCCESS ? exr_encoding_run( writer->context, writer->part, &writer->pipeline ) : code;
}

static exr_result_t write_chunks( Writer* writer )
{
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk( writer->context, writer->part, &lines );
    if ( code != EXR_ERR_SUCCESS || lines < 1 )
        return code != EXR_ERR_SUCCESS ? code : EXR_ERR_UNKNOWN;
    for ( int64_t y = 0; y < writer->image->height && code == EXR_ERR_SUCCESS; y += lines )
        code = write_chunk( writer, (int)y );
    if ( writer->started )
        exr_encoding_destroy( writer->context, &writer->pipeline );
    writer->started = false;
    return code;
}

static RfResult write_stream( Writer* writer, RfError* error )
{
    rf_begin_exr_write( &writer->stream );
    exr_context_initializer_t initializer = rf_exr_initializer( &writer->stream );
    exr_result_t code = exr_start_write( &writer->context, writer->stream.path, EXR_WRITE_FILE_DIRECTLY, &initializer );
    if ( code == EXR_ERR_SUCCESS )
        code = write_header( writer );
    for ( writer->part = 0; writer->part < writer->part_count && code == EXR_ERR_SUCCESS; ++writer->part )
        code = write_chunks( writer );
    exr_result_t finish_code = writer->context != NULL ? exr_finish( &writer->context ) : EXR_ERR_SUCCESS;
    rf_end_exr_write();
    code = code != EXR_ERR_SUCCESS ? code : finish_code;
    if ( writer->not_finite && writer->stream.io_error == 0 )
        return rf_fail( error, RF_ERROR_USAGE,
                        "%s: cannot be written: its colours have NaN or infinite values, which DWA would turn "
                        "to 0: choose ZIP or PIZ",
                        writer->stream.path );
    if ( code != EXR_ERR_SUCCESS || writer->stream.io_error != 0 )
        return rf_fail_exr( &writer->stream, code, "cannot be written", error );
    return RF_OK;
}

#define SEARCHED ( (size_t)1 << 16 ) // bytes at a time

// The offset of the next such bytes in the file, -1 where there are none or it cannot be read.
static off_t find_bytes( int fd, off_t from, const char* bytes, size_t size )
{
    char block[SEARCHED];
    for ( ssize_t count; ( count = pread( fd, block, sizeof block, from ) ) >= (ssize_t)size; from += count - (ssize_t)size + 1 )
    {
        const char* end = block + count - size + 1;
        for ( const char* at = block; ( at = memchr( at, bytes[0], (size_t)( end - at ) ) ) != NULL; ++at )
        {
            if ( memcmp( at, bytes, size ) == 0 )
                return from + ( at - block );
            if ( at + 1 == end )
                break;
        }
    }
    return -1;
}

// Puts the checksums, which are known only now, into the headers, where an attribute is its name, its type, a size and the value.
static RfResult write_checksums( Writer* writer, RfError* error )
{
    static const char attribute[] = RF_EXR_CHECKSUM "\0string";
    RfExrStream* stream = &writer->stream;
    off_t at = 0;
    errno = EIO; // where no call says otherwise
    for ( int p = 0; p < writer->part_count && at >= 0; ++p )
    {
        char text[CHECKSUM_SIZE];
        format_checksum( writer->parts + p, text );
        at = find_bytes( stream->fd, at, attribute, sizeof attribute );
        at += at >= 0 ? (off_t)( sizeof attribute + sizeof( int32_t ) ) : 0;
        if ( at >= 0 && pwrite( stream->fd, text, strlen( text ), at ) != (ssize_t)strlen( text ) )
            at = -1;
    }
    return at >= 0 ? RF_OK : rf_fail_io( stream->path, "cannot be written", errno, error );
}

RfResult rf_write_exr( const char* path, const RfImage* image, const RfExrOptions* options, RfError* error )
{
    RF_TRY( check_options( path, image, options, error ) );
    Writer writer = { .stream = { .path = path }, .image = image, .options = options };
    RF_TRY( list_channels( &writer, error ) );
    RfAtomicFile file;
    RF_TRY( rf_open_atomic_file( path, &file, error ) );
    writer.stream.fd = file.fd;
    RfResult result = write_stream( &writer, error );
    if ( result == RF_OK )
        result = write_checksums( &writer, error );
    for ( int p = 0; p < writer.part_count && result == RF_OK; ++p )
        result = verify_part( &writer, p, error );
    return rf_end_atomic_file( &file, result, error );
}
