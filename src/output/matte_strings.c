// Cryptomatte's attributes of a file.
#include "output/matte_strings.h"

#include <stdio.h>
#include <stdlib.h>

static void add( RfMatteStrings* to, uint32_t key, const char* what, const char* value )
{
    char* name = to->names[to->count];
    snprintf( name, sizeof to->names[0], "cryptomatte/%07x/%s", key, what );
    to->strings[to->count++] = ( RfExrString ){ name, value };
}

RfResult rf_make_matte_strings( const RfOutput* output, RfMatteStrings* strings, RfError* error )
{
    strings->count = 0;
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
        strings->manifests[k] = NULL;
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
    {
        char* layer = strings->layers[k];
        if ( ( output->settings.cryptomatte & 1u << k ) == 0 )
            continue;
        strings->manifests[k] = rf_cryptomatte_manifest( rf_tracer_scene( output->tracer ), k );
        if ( strings->manifests[k] == NULL )
        {
            rf_free_matte_strings( strings );
            return rf_fail( error, RF_ERROR_MEMORY, "no memory left for the names of Cryptomatte" );
        }
        rf_name_pass_layer( output->settings.files.names, g_rf_cryptomatte_kinds[k].name, layer );
        uint32_t key = rf_murmur3_32( layer ) >> 4;
        add( strings, key, "name", layer );
        add( strings, key, "hash", "MurmurHash3_32" );
        add( strings, key, "conversion", "uint32_to_float32" );
        add( strings, key, "manifest", strings->manifests[k] );
    }
    return RF_OK;
}

void rf_free_matte_strings( RfMatteStrings* strings )
{
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
    {
        free( strings->manifests[k] );
        strings->manifests[k] = NULL;
    }
}
