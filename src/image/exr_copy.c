// Reads an EXR file so that it can be written again with other colours.
#include "base/try.h"
#include "image/colour.h"
#include "image/exr.h"
#include "image/exr_stream.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static RfResult find_compression( const RfExrPart* part, RfExrOptions* options, RfError* error )
{
    static const RfExrCompression ours[] = {
        [EXR_COMPRESSION_NONE] = RF_EXR_NONE, [EXR_COMPRESSION_ZIPS] = RF_EXR_ZIPS, [EXR_COMPRESSION_ZIP] = RF_EXR_ZIP,
        [EXR_COMPRESSION_PIZ] = RF_EXR_PIZ,   [EXR_COMPRESSION_DWAA] = RF_EXR_DWAA, [EXR_COMPRESSION_DWAB] = RF_EXR_DWAB
    };
    exr_compression_t found = EXR_COMPRESSION_ZIP;
    exr_result_t code = exr_get_compression( part->context, part->index, &found );
    if ( code != EXR_ERR_SUCCESS )
        return rf_fail_exr( part->stream, code, "its compression cannot be read", error );
    bool is_ours =
        (size_t)found < sizeof ours / sizeof ours[0] && ( ours[found] != RF_EXR_NONE || found == EXR_COMPRESSION_NONE );
    options->compression = is_ours ? ours[found] : RF_EXR_ZIP;
    exr_get_pixel_aspect_ratio( part->context, part->index, &options->pixel_aspect );
    float level = 0.0f;
    if ( rf_is_dwa( options->compression ) &&
         exr_attr_get_float( part->context, part->index, "dwaCompressionLevel", &level ) == EXR_ERR_SUCCESS )
        options->dwa_level = level;
    return RF_OK;
}

static RfResult find_colour_space( const RfExrPart* part, RfExrOptions* options, RfError* error )
{
    RfColourConversion to_rec709, to_acescg;
    RF_TRY( rf_read_exr_colours( part, &to_rec709, error ) );
    rf_convert_between( rf_chromaticities_of( RF_ACESCG ), rf_chromaticities_of( RF_REC709 ), &to_acescg );
    if ( !to_rec709.needed )
        return RF_OK;
    options->colour_space = RF_ACESCG;
    for ( int i = 0; i < 9; ++i )
    {
        float difference = to_rec709.matrix[i / 3][i % 3] - to_acescg.matrix[i / 3][i % 3];
        if ( difference > 1e-3f || difference < -1e-3f )
            return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: is neither in Rec. 709 nor in ACEScg: convert it first",
                            part->stream->path );
    }
    return RF_OK;
}

// Where R, G and B are, and how they are stored.
static RfResult find_colour( RfExrCopy* copy, const char* path, char names[3][256], int* index, RfError* error )
{
    RfExrStream stream;
    RfExrPart part;
    RfExrChannels colour;
    const char* name = NULL;
    RF_TRY( rf_open_exr_file( path, &stream, error ) );
    RfResult result = rf_open_exr_layer( &stream, NULL, &part, &colour, error );
    if ( result == RF_OK )
    {
        *index = part.index;
        for ( int c = 0; c < 3; ++c )
            snprintf( names[c], 256, "%s", colour.names[c < colour.count ? c : 0] );
        const char* dot = strrchr( names[0], '.' );
        if ( dot != NULL )
            snprintf( copy->layer, sizeof copy->layer, "%.*s", (int)( dot - names[0] ), names[0] );
        if ( exr_get_name( part.context, part.index, &name ) == EXR_ERR_SUCCESS && name != NULL )
            snprintf( copy->part, sizeof copy->part, "%s", name );
        result = find_compression( &part, &copy->options, error );
        if ( result == RF_OK )
            result = find_colour_space( &part, &copy->options, error );
        rf_close_exr_part( &part );
    }
    close( stream.fd );
    if ( result == RF_OK && strcmp( names[0], names[1] ) == 0 )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: is grey: denoising needs R, G and B", path );
    return result;
}

static RfResult check_channels( const char* path, const RfExrHeader* header, RfError* error )
{
    if ( header->channel_count > RF_EXR_MAX_CHANNELS - 16 )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: has %d channels, at most %d can be written again", path,
                        header->channel_count, RF_EXR_MAX_CHANNELS - 16 );
    for ( int i = 0; i < header->channel_count; ++i )
    {
        if ( header->channels[i].whole )
            return rf_fail( error, RF_ERROR_UNSUPPORTED,
                            "%.600s: its channel %.200s has whole numbers, which cannot be written again", path,
                            header->channels[i].text );
    }
    return RF_OK;
}

// The name of a channel's part: what its full name has before its own, or both begin with.
static void find_part_name( const RfExrName* channel, const RfExrCopy* copy, char name[256] )
{
    size_t before = (size_t)( channel->own - channel->text );
    if ( before > 0 )
        snprintf( name, 256, "%.*s", (int)before - 1, channel->text );
    else
        snprintf( name, 256, "%s", copy->part );
}

static bool is_colour_letter( const char* name )
{
    const char *dot = strrchr( name, '.' ), *word = dot != NULL ? dot + 1 : name;
    return strlen( word ) == 1 && strchr( "RGB", word[0] ) != NULL;
}

static void list_channels( RfExrCopy* copy, char colour[3][256], int part )
{
    RfExrHeader* header = &copy->header;
    RfExrOptions* options = &copy->options;
    for ( int i = 0; i < header->channel_count; ++i )
    {
        const RfExrName* from = header->channels + i;
        bool is_colour = false;
        for ( int c = 0; c < 3; ++c )
            is_colour = is_colour || ( from->part == part && strcmp( from->own, colour[c] ) == 0 );
        if ( is_colour )
        {
            options->half = from->half;
            continue;
        }
        find_part_name( from, copy, copy->parts[i] );
        copy->channels[options->channel_count++] = ( RfExrChannel ){
            .name = from->own,
            .values = copy->values + i,
            .stride = header->channel_count,
            .half = from->half,
            .lossy = from->half && is_colour_letter( from->own ), // by the rules that readers of DWA have
            .part = from->part != part ? copy->parts[i] : NULL,
        };
    }
    options->channels = copy->channels;
}

RfResult rf_read_exr_copy( const char* path, RfExrCopy* copy, RfError* error )
{
    char colour[3][256];
    const char* names[RF_EXR_MAX_CHANNELS];
    int part = 0;
    RfExrWindow window;
    *copy = ( RfExrCopy ){ .options = rf_default_exr_options() };
    copy->options.like = path;
    RF_TRY( find_colour( copy, path, colour, &part, error ) );
    RF_TRY( rf_read_exr_header( path, NULL, &copy->header, error ) );
    RF_TRY( check_channels( path, &copy->header, error ) );
    copy->parts = calloc( RF_EXR_MAX_CHANNELS, sizeof *copy->parts );
    if ( copy->parts == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its channels", path );
    for ( int i = 0; i < copy->header.channel_count; ++i )
        names[i] = copy->header.channels[i].text;
    RF_TRY( rf_read_exr_channels( path, names, copy->header.channel_count, &window, &copy->values, error ) );
    list_channels( copy, colour, part );
    RfExrOptions* options = &copy->options;
    const RfExrHeader* header = &copy->header;
    options->layer = copy->layer[0] != '\0' ? copy->layer : NULL;
    options->part = copy->part[0] != '\0' ? copy->part : NULL;
    options->x = header->x;
    options->y = header->y;
    options->display = ( RfExrWindow ){ header->display_x, header->display_y, header->display_width, header->display_height };
    return RF_OK;
}

void rf_free_exr_copy( RfExrCopy* copy )
{
    rf_destroy_exr_header( &copy->header );
    free( copy->values );
    free( copy->parts );
    *copy = ( RfExrCopy ){ .values = NULL };
}
