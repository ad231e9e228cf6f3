// Reads EXR files: images and attributes.
#include "image/atomic_file.h"
#include "image/exr.h"
#include "image/exr_channels.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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

static void take_colour( void* user, int channel, int x, int y, const float* values, int count )
{
    RfImage* image = user;
    float* out = image->rgb + 3 * ( (size_t)y * (size_t)image->width + (size_t)x ) + channel;
    for ( int i = 0; i < count; ++i )
        out[3 * i] = values[i];
}

static void spread_luminance( RfImage* image )
{
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for ( size_t i = 0; i < pixels; ++i )
        image->rgb[3 * i + 1] = image->rgb[3 * i + 2] = image->rgb[3 * i];
}

RfResult rf_read_exr_stream( RfExrStream* stream, RfImage* image, RfError* error )
{
    *image = ( RfImage ){ 0 };
    RfExrPart part;
    RfResult result = rf_open_exr_part( stream, 0, &part, error );
    if ( result != RF_OK )
        return result;
    RfExrChannels channels;
    result = rf_find_exr_channels( stream, part.channels, RF_REMEDY_NONE, &channels, error );
    if ( result == RF_OK )
        result = rf_create_image( part.width, part.height, image, error );
    if ( result == RF_OK )
        result = rf_read_exr_lines( &part, channels.names, channels.count, take_colour, image, error );
    if ( result == RF_OK && channels.count == 1 )
        spread_luminance( image );
    rf_close_exr_part( &part );
    if ( result != RF_OK )
        rf_destroy_image( image );
    return result;
}

RfResult rf_read_exr( const char* path, RfImage* image, RfError* error )
{
    *image = ( RfImage ){ 0 };
    RfExrStream stream;
    RfResult result = rf_open_exr_file( path, &stream, error );
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
    RfResult result = rf_open_exr_file( path, &stream, error );
    if ( result != RF_OK )
        return result;
    exr_context_t context = NULL;
    exr_result_t code = rf_start_exr( &stream, &context );
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
