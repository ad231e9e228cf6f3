// Colour, or any other layer, of files of any program: also of those with several
// parts, and with where it lies.
#include "image/exr.h"
#include "image/exr_channels.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

// The colour of the first part that has any: the error of the first says what is wrong.
static RfResult find_colour( RfExrStream* stream, RfExrPart* part, RfExrChannels* channels, RfError* error )
{
    int count = 1;
    for ( int i = 0; i < count; ++i )
    {
        RfError* first = i == 0 ? error : NULL;
        RfResult result = rf_open_exr_part( stream, i, part, first );
        count = part->count;
        if ( result != RF_OK )
            continue;
        if ( rf_find_exr_channels( stream, part->channels, channels, first ) == RF_OK )
            return RF_OK;
        rf_close_exr_part( part );
    }
    return error != NULL ? error->code : RF_ERROR_FORMAT;
}

static RfResult find_layer( RfExrStream* stream, const char* layer, RfExrPart* part, RfExrChannels* channels, RfError* error )
{
    char text[512] = "";
    int count = 1;
    for ( int i = 0; i < count; ++i )
    {
        RfResult result = rf_open_exr_part( stream, i, part, error );
        if ( result != RF_OK && part->count <= 1 )
            return result;
        count = part->count;
        if ( result != RF_OK )
            continue;
        if ( rf_find_exr_layer( part, layer, channels ) )
            return RF_OK;
        rf_list_exr_channels( part->channels, text, sizeof text );
        rf_close_exr_part( part );
    }
    return rf_fail( error, RF_ERROR_FORMAT, "%s: has no layer %s; it has %s", stream->path, layer, text[0] != 0 ? text : "none" );
}

static void take_value( void* user, int channel, int x, int y, const float* values, int count )
{
    RfImage* image = user;
    float* out = image->rgb + 3 * ( (size_t)y * (size_t)image->width + (size_t)x ) + channel;
    for ( int i = 0; i < count; ++i )
        out[3 * i] = values[i];
}

static RfResult read_part( const RfExrPart* part, const RfExrChannels* channels, RfImage* image, RfError* error )
{
    RfResult result = rf_create_image( part->width, part->height, image, error );
    // a channel that is named twice is read into the first of its places
    if ( result == RF_OK )
        result = rf_read_exr_lines( part, channels->names, channels->count, take_value, image, error );
    int like[3] = { 0, channels->count == 1 ? 0 : 1, channels->count == 1 ? 0 : 2 };
    for ( int c = channels->count - 1; c > 0; --c )
    {
        for ( int d = c - 1; d >= 0; --d )
            like[c] = strcmp( channels->names[d], channels->names[c] ) == 0 ? d : like[c];
    }
    size_t pixels = (size_t)part->width * (size_t)part->height;
    for ( size_t i = 0; result == RF_OK && i < pixels; ++i )
    {
        image->rgb[3 * i + 1] = image->rgb[3 * i + (size_t)like[1]];
        image->rgb[3 * i + 2] = image->rgb[3 * i + (size_t)like[2]];
    }
    if ( result != RF_OK )
        rf_destroy_image( image );
    return result;
}

RfResult rf_read_exr_layer( const char* path, const char* layer, RfImage* image, RfExrWindow* window, RfError* error )
{
    RfError local; // whose code is looked at
    error = error != NULL ? error : &local;
    *image = ( RfImage ){ 0 };
    RfExrStream stream;
    RfResult result = rf_open_exr_file( path, &stream, error );
    if ( result != RF_OK )
        return result;
    RfExrPart part;
    RfExrChannels channels;
    result = layer != NULL ? find_layer( &stream, layer, &part, &channels, error ) : find_colour( &stream, &part, &channels, error );
    if ( result == RF_OK )
    {
        result = read_part( &part, &channels, image, error );
        *window = ( RfExrWindow ){ part.window.min.x, part.window.min.y, part.width, part.height };
        rf_close_exr_part( &part );
    }
    close( stream.fd );
    return result;
}
