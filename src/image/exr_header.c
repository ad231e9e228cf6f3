#include "image/exr.h"
#include "image/exr_stream.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static RfResult read_windows( const RfExrPart* part, RfExrHeader* header, RfError* error )
{
    exr_attr_box2i_t display;
    exr_result_t code = exr_get_display_window( part->context, 0, &display );
    int64_t width = (int64_t)display.max.x - display.min.x + 1, height = (int64_t)display.max.y - display.min.y + 1;
    if ( code != EXR_ERR_SUCCESS )
        return rf_fail_exr( part->stream, code, "its header cannot be read", error );
    if ( width < 1 || height < 1 || width > INT32_MAX || height > INT32_MAX )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: its display window of %lldx%lld pixels is out of bounds",
                        part->stream->path, (long long)width, (long long)height );
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

static void read_camera( const RfExrPart* part, RfExrHeader* header )
{
    exr_attr_m44f_t matrix;
    header->has_world_to_ndc = exr_attr_get_m44f( part->context, 0, "worldToNDC", &matrix ) == EXR_ERR_SUCCESS;
    if ( header->has_world_to_ndc )
        memcpy( header->world_to_ndc, matrix.m, sizeof header->world_to_ndc );
}

static void read_fps( const RfExrPart* part, RfExrHeader* header )
{
    exr_attr_rational_t fps;
    if ( exr_attr_get_rational( part->context, 0, "framesPerSecond", &fps ) != EXR_ERR_SUCCESS || fps.num < 1 || fps.denom < 1 )
        return;
    header->fps_numerator = fps.num;
    header->fps_denominator = fps.denom;
}

static RfResult copy_channels( const RfExrPart* part, RfExrHeader* header, RfError* error )
{
    int count = part->channels->num_channels;
    header->channels = calloc( (size_t)count + 1, sizeof( char* ) );
    for ( int i = 0; header->channels != NULL && i < count; ++i )
    {
        const char* name = part->channels->entries[i].name.str;
        char* copy = malloc( strlen( name ) + 1 );
        if ( copy == NULL )
            break;
        header->channels[header->channel_count++] = strcpy( copy, name );
    }
    if ( header->channels == NULL || header->channel_count < count )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for the names of its channels", part->stream->path );
    return RF_OK;
}

RfResult rf_read_exr_header( const char* path, RfExrHeader* header, RfError* error )
{
    *header = ( RfExrHeader ){ 0 };
    RfExrStream stream;
    RfResult result = rf_open_exr_file( path, &stream, error );
    if ( result != RF_OK )
        return result;
    RfExrPart part;
    result = rf_open_exr_part( &stream, 0, &part, error );
    if ( result == RF_OK )
    {
        result = read_windows( &part, header, error );
        read_camera( &part, header );
        read_fps( &part, header );
        if ( result == RF_OK )
            result = copy_channels( &part, header, error );
        rf_close_exr_part( &part );
    }
    close( stream.fd );
    if ( result != RF_OK )
        rf_destroy_exr_header( header );
    return result;
}

void rf_destroy_exr_header( RfExrHeader* header )
{
    for ( int i = 0; i < header->channel_count; ++i )
        free( header->channels[i] );
    free( header->channels );
    *header = ( RfExrHeader ){ 0 };
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
