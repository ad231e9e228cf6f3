#include "cli/options/aov_list.h"

#include "cli/options/options.h"

#include <stdio.h>
#include <string.h>

// The layer called by `length` characters, or −1.
static int find_layer( const char* word, size_t length )
{
    for ( int l = 0; l < RF_AOV_COUNT; ++l )
    {
        const char* name = rf_aov_name( (RfAov)l );
        if ( strlen( name ) == length && strncmp( name, word, length ) == 0 )
            return l;
    }
    return -1;
}

static RfResult fail_unknown( const char* word, size_t length, RfError* error )
{
    const char* names[RF_AOV_COUNT];
    for ( int l = 0; l < RF_AOV_COUNT; ++l )
        names[l] = rf_aov_name( (RfAov)l );
    char copy[32], all[128];
    snprintf( copy, sizeof copy, "%.*s", (int)( length < 31 ? length : 31 ), word );
    const char* nearest = length > 0 ? rf_nearest_word( copy, names, RF_AOV_COUNT ) : NULL;
    if ( nearest != NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--aov: '%s': no such layer, did you mean %s?", copy, nearest );
    rf_format_aovs( RF_ALL_AOVS, all, sizeof all );
    return rf_fail( error, RF_ERROR_USAGE, "--aov: wants layers of %s, got '%s'", all, copy );
}

RfResult rf_parse_aovs( const char* text, unsigned* layers, RfError* error )
{
    *layers = 0;
    while ( text != NULL )
    {
        size_t length = strcspn( text, "," );
        int layer = find_layer( text, length );
        if ( layer < 0 )
            return fail_unknown( text, length, error );
        if ( ( *layers & RF_AOV_BIT( layer ) ) != 0 )
            return rf_fail( error, RF_ERROR_USAGE, "--aov: %s is given twice", rf_aov_name( (RfAov)layer ) );
        *layers |= RF_AOV_BIT( layer );
        text = text[length] == ',' ? text + length + 1 : NULL;
    }
    return RF_OK;
}

void rf_format_aovs( unsigned layers, char* text, size_t size )
{
    size_t used = 0;
    text[0] = '\0';
    for ( int l = 0; l < RF_AOV_COUNT && used < size; ++l )
    {
        if ( ( layers & RF_AOV_BIT( l ) ) != 0 )
            used += (size_t)snprintf( text + used, size - used, "%s%s", used > 0 ? "," : "", rf_aov_name( (RfAov)l ) );
    }
}

void rf_list_aov_channels( const RfFrameResult* result, bool half, RfAovChannels* list )
{
    list->count = 0;
    for ( int l = 0; l < RF_AOV_COUNT; ++l )
    {
        const char* letters = rf_aov_letters( (RfAov)l );
        int channels = result->layers[l] != NULL ? rf_aov_channels( (RfAov)l ) : 0;
        for ( int c = 0; c < channels; ++c )
        {
            char* name = list->names[list->count];
            snprintf( name, sizeof list->names[0], "%s.%c", rf_aov_name( (RfAov)l ), letters[c] );
            list->channels[list->count++] = ( RfExrChannel ){
                .name = name,
                .values = result->layers[l] + c,
                .stride = channels,
                .half = half && rf_aov_is_half( (RfAov)l ),
            };
        }
    }
}
