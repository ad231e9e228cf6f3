#include "cli/layer_list.h"

#include "cli/options.h"

#include <stdio.h>
#include <string.h>

// The layer called by `length` characters, or −1.
static int find_layer( const char* word, size_t length )
{
    for ( int l = 0; l < RF_LAYER_COUNT; ++l )
    {
        const char* name = rf_layer_name( (RfLayer)l );
        if ( strlen( name ) == length && strncmp( name, word, length ) == 0 )
            return l;
    }
    return -1;
}

static RfResult fail_unknown( const char* word, size_t length, RfError* error )
{
    const char* names[RF_LAYER_COUNT];
    for ( int l = 0; l < RF_LAYER_COUNT; ++l )
        names[l] = rf_layer_name( (RfLayer)l );
    char copy[32], all[128];
    snprintf( copy, sizeof copy, "%.*s", (int)( length < 31 ? length : 31 ), word );
    const char* nearest = length > 0 ? rf_nearest_word( copy, names, RF_LAYER_COUNT ) : NULL;
    if ( nearest != NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--aov: '%s': no such layer, did you mean %s?", copy, nearest );
    rf_format_layers( RF_ALL_LAYERS, all, sizeof all );
    return rf_fail( error, RF_ERROR_USAGE, "--aov: wants layers of %s, got '%s'", all, copy );
}

RfResult rf_parse_layers( const char* text, unsigned* layers, RfError* error )
{
    *layers = 0;
    while ( text != NULL )
    {
        size_t length = strcspn( text, "," );
        int layer = find_layer( text, length );
        if ( layer < 0 )
            return fail_unknown( text, length, error );
        if ( ( *layers & RF_LAYER_BIT( layer ) ) != 0 )
            return rf_fail( error, RF_ERROR_USAGE, "--aov: %s is given twice", rf_layer_name( (RfLayer)layer ) );
        *layers |= RF_LAYER_BIT( layer );
        text = text[length] == ',' ? text + length + 1 : NULL;
    }
    return RF_OK;
}

void rf_format_layers( unsigned layers, char* text, size_t size )
{
    size_t used = 0;
    text[0] = '\0';
    for ( int l = 0; l < RF_LAYER_COUNT && used < size; ++l )
    {
        if ( ( layers & RF_LAYER_BIT( l ) ) != 0 )
            used += (size_t)snprintf( text + used, size - used, "%s%s", used > 0 ? "," : "", rf_layer_name( (RfLayer)l ) );
    }
}

void rf_list_layer_channels( const RfFrameResult* result, bool half, RfLayerChannels* list )
{
    list->count = 0;
    for ( int l = 0; l < RF_LAYER_COUNT; ++l )
    {
        const char* letters = rf_layer_letters( (RfLayer)l );
        int channels = result->layers[l] != NULL ? rf_layer_channels( (RfLayer)l ) : 0;
        for ( int c = 0; c < channels; ++c )
        {
            char* name = list->names[list->count];
            snprintf( name, sizeof list->names[0], "%s.%c", rf_layer_name( (RfLayer)l ), letters[c] );
            list->channels[list->count++] = ( RfExrChannel ){
                .name = name,
                .values = result->layers[l] + c,
                .stride = channels,
                .half = half && rf_layer_is_half( (RfLayer)l ),
            };
        }
    }
}
