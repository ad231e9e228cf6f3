#include "image/exr.h"
#include "image/exr_channels.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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

static bool copy_name( const RfExrPart* part, const char* own, RfExrName* name )
{
    const char* before = NULL;
    if ( part->count < 2 || exr_get_name( part->context, part->index, &before ) != EXR_ERR_SUCCESS )
        before = NULL;
    size_t begin = before != NULL ? strlen( before ) + 1 : 0, size = begin + strlen( own ) + 1;
    *name = ( RfExrName ){ .text = malloc( size ), .part = part->index, .window = window_of( part ) };
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
        if ( !copy_name( part, part->channels->entries[i].name.str, moved + header->channel_count ) )
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
    return is_done ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for the names of its channels", stream->path );
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
    RfResult result = rf_open_exr_file( path, &stream, error );
    if ( result != RF_OK )
        return result;
    RfExrPart part;
    result = open_part( &stream, layer, &part, error );
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
    RfResult result = rf_open_exr_file( path, &stream, error );
    if ( result != RF_OK )
        return result;
    RfExrPart part;
    result = rf_open_exr_part( &stream, 0, &part, error );
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
