// Reads the colour or any other layer, with its data window, from files of any program,
// including multi-part files.
#include "image/exr.h"
#include "image/exr_channels.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

// Opens the colour of a part; on failure channels->count is the number of colour layers.
static RfResult open_colour( RfExrStream* stream, int index, RfExrPart* part, RfExrChannels* channels, RfError* error )
{
    *channels = ( RfExrChannels ){ 0 };
    RfResult result = rf_open_exr_part( stream, index, part, error );
    if ( result != RF_OK )
        return result;
    result = rf_find_exr_channels( stream, part->channels, "name one by --layer", channels, error );
    if ( result != RF_OK )
        rf_close_exr_part( part );
    return result;
}

// Finds the first part with three colour channels, else the first with Y, since a Y may also
// belong to X and Y of a vector. On failure reports the first part that has several colour
// layers, else the first part.
static RfResult find_colour( RfExrStream* stream, RfExrPart* part, RfExrChannels* channels, RfError* error )
{
    int count = 1, grey = -1;
    bool has_several = false;
    RfError first = { 0 };
    for ( int i = 0; i < count; ++i )
    {
        RfError here = { 0 };
        RfResult result = open_colour( stream, i, part, channels, &here );
        count = part->count;
        if ( result == RF_OK && channels->count == 3 )
            return RF_OK;
        if ( result == RF_OK )
        {
            grey = grey < 0 ? i : grey;
            rf_close_exr_part( part );
            continue;
        }
        if ( first.code == RF_OK || ( channels->count > 1 && !has_several ) )
            first = here;
        has_several |= channels->count > 1;
    }
    if ( grey >= 0 && !has_several )
        return open_colour( stream, grey, part, channels, error );
    return rf_fail( error, first.code, "%s", first.text );
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

RfResult rf_open_exr_layer( RfExrStream* stream, const char* layer, RfExrPart* part, RfExrChannels* channels, RfError* error )
{
    return layer != NULL ? find_layer( stream, layer, part, channels, error ) : find_colour( stream, part, channels, error );
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
    // duplicate channels are read once, then copied
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
    *image = ( RfImage ){ 0 };
    RfExrStream stream;
    RfResult result = rf_open_exr_file( path, &stream, error );
    if ( result != RF_OK )
        return result;
    RfExrPart part;
    RfExrChannels channels;
    result = rf_open_exr_layer( &stream, layer, &part, &channels, error );
    if ( result == RF_OK )
    {
        result = read_part( &part, &channels, image, error );
        *window = ( RfExrWindow ){ part.window.min.x, part.window.min.y, part.width, part.height };
        rf_close_exr_part( &part );
    }
    close( stream.fd );
    return result;
}
