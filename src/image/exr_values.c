// Reads channels by name, from whichever parts hold them.
#include "image/exr.h"
#include "image/exr_stream.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// The channels of one part and their positions in the interleaved output.
typedef struct Interleaved
{
    float* values;
    int width, channels;
    const char* names[RF_EXR_MAX_CHANNELS];
    int places[RF_EXR_MAX_CHANNELS];
    int count;
} Interleaved;

static void take_channel( void* user, int channel, int x, int y, const float* values, int count )
{
    const Interleaved* to = user;
    float* out = to->values + (size_t)to->channels * ( (size_t)y * (size_t)to->width + (size_t)x ) + to->places[channel];
    for ( int i = 0; i < count; ++i )
        out[(size_t)i * (size_t)to->channels] = values[i];
}

static RfResult read_part( RfExrStream* stream, int index, Interleaved* to, RfError* error )
{
    RfExrPart part;
    RfResult result = rf_open_exr_part( stream, index, &part, error );
    if ( result != RF_OK )
        return result;
    result = rf_read_exr_lines( &part, to->names, to->count, take_channel, to, error );
    rf_close_exr_part( &part );
    return result;
}

// Reads part by part, each with its requested channels.
static RfResult read_parts( RfExrStream* stream, const RfExrName* const* wanted, int count, Interleaved* to, RfError* error )
{
    RfResult result = RF_OK;
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        bool is_done = false;
        for ( int k = 0; k < i; ++k )
            is_done |= wanted[k]->part == wanted[i]->part;
        if ( is_done )
            continue;
        to->count = 0;
        for ( int k = i; k < count; ++k )
        {
            if ( wanted[k]->part != wanted[i]->part )
                continue;
            to->names[to->count] = wanted[k]->own;
            to->places[to->count++] = k;
        }
        result = read_part( stream, wanted[i]->part, to, error );
    }
    return result;
}

static RfResult find_wanted( const char* path, const RfExrHeader* header, const char* const* names, int count,
                             const RfExrName** wanted, RfError* error )
{
    for ( int i = 0; i < count; ++i )
    {
        wanted[i] = rf_find_exr_name( header, names[i], strlen( names[i] ) );
        if ( wanted[i] == NULL )
            return rf_fail( error, RF_ERROR_FORMAT, "%s: has no channel %s", path, names[i] );
        const RfExrWindow *first = &wanted[0]->window, *now = &wanted[i]->window;
        if ( memcmp( first, now, sizeof *now ) != 0 )
            return rf_fail( error, RF_ERROR_FORMAT,
                            "%.400s: %.64s has %dx%d pixels from (%d, %d) on, %.64s %dx%d from (%d, %d) on: "
                            "store all parts with the same data window",
                            path, names[0], first->width, first->height, first->x, first->y, names[i], now->width, now->height,
                            now->x, now->y );
    }
    return RF_OK;
}

static RfResult read_wanted( const char* path, const RfExrName* const* wanted, int count, float** values, RfError* error )
{
    const RfExrWindow* window = &wanted[0]->window;
    RfExrStream stream;
    RfResult result = rf_open_exr_file( path, &stream, error );
    if ( result != RF_OK )
        return result;
    Interleaved to = { .width = window->width, .channels = count };
    to.values = malloc( (size_t)window->width * (size_t)window->height * (size_t)count * sizeof( float ) );
    if ( to.values == NULL )
        result = rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for %dx%d pixels", path, window->width, window->height );
    else
        result = read_parts( &stream, wanted, count, &to, error );
    close( stream.fd );
    if ( result == RF_OK )
        *values = to.values;
    else
        free( to.values );
    return result;
}

RfResult rf_read_exr_channels( const char* path, const char* const* names, int count, RfExrWindow* window, float** values,
                               RfError* error )
{
    *values = NULL;
    *window = ( RfExrWindow ){ 0 };
    if ( count < 1 || count > RF_EXR_MAX_CHANNELS )
        return rf_fail( error, RF_ERROR_USAGE, "%s: cannot read %d channels: ask for 1 to %d", path, count, RF_EXR_MAX_CHANNELS );
    RfExrHeader header;
    const RfExrName* wanted[RF_EXR_MAX_CHANNELS];
    RfResult result = rf_read_exr_header( path, NULL, &header, error );
    if ( result != RF_OK )
        return result;
    result = find_wanted( path, &header, names, count, wanted, error );
    if ( result == RF_OK )
        result = read_wanted( path, wanted, count, values, error );
    if ( result == RF_OK )
        *window = wanted[0]->window;
    rf_destroy_exr_header( &header );
    return result;
}
