// Reads the manifests of Cryptomattes.
#include "page/matte_names.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Manifests
{
    json_t* names; // { KEY: the Cryptomatte's name }
    json_t* ids;   // { KEY: { name: "3f2a91c4" } }
} Manifests;

static void take_string( void* user, const char* name, const char* value )
{
    static const char begin[] = "cryptomatte/";
    const Manifests* to = user;
    const char* key = name + sizeof begin - 1;
    if ( strncmp( name, begin, sizeof begin - 1 ) != 0 )
        return;
    const char* slash = strchr( key, '/' );
    if ( slash == NULL || slash - key > 31 )
        return;
    char text[32];
    snprintf( text, sizeof text, "%.*s", (int)( slash - key ), key );
    if ( strcmp( slash, "/name" ) == 0 )
        json_object_set_new( to->names, text, json_string( value ) );
    else if ( strcmp( slash, "/manifest" ) == 0 )
        json_object_set_new( to->ids, text, json_loads( value, 0, NULL ) );
}

static int compare_ids( const void* first, const void* second )
{
    const RfMatteName *a = first, *b = second;
    return ( a->id > b->id ) - ( a->id < b->id );
}

static bool take_names( json_t* ids, RfMatteNames* list )
{
    const char* name;
    json_t* id;
    list->names = malloc( ( json_object_size( ids ) + 1 ) * sizeof *list->names );
    if ( list->names == NULL )
        return false;
    json_object_foreach( ids, name, id )
    {
        const char* text = json_string_value( id );
        RfMatteName* row = list->names + list->count;
        if ( text == NULL )
            continue;
        *row = ( RfMatteName ){ .id = (uint32_t)strtoul( text, NULL, 16 ), .name = strdup( name ) };
        if ( row->name == NULL )
            return false;
        list->count += 1;
    }
    qsort( list->names, (size_t)list->count, sizeof *list->names, compare_ids );
    return true;
}

RfResult rf_read_matte_names( const char* path, const RfFilePass* pass, RfMatteNames* names, RfError* error )
{
    *names = ( RfMatteNames ){ 0 };
    Manifests manifests = { json_object(), json_object() };
    RfResult result = rf_list_exr_strings( path, take_string, &manifests, error );
    const char* key;
    json_t* crypto;
    json_object_foreach( manifests.names, key, crypto )
    {
        const char *name = json_string_value( crypto ), *last = name != NULL ? strrchr( name, '.' ) : NULL;
        json_t* ids = json_object_get( manifests.ids, key );
        if ( result != RF_OK || name == NULL || strcmp( last != NULL ? last + 1 : name, pass->name ) != 0 || ids == NULL ||
             names->names != NULL )
            continue;
        if ( !take_names( ids, names ) )
            result = rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for the names of its Cryptomatte", path );
    }
    json_decref( manifests.names );
    json_decref( manifests.ids );
    return result;
}

void rf_free_matte_names( RfMatteNames* names )
{
    for ( int i = 0; i < names->count; ++i )
        free( names->names[i].name );
    free( names->names );
    *names = ( RfMatteNames ){ 0 };
}

int rf_find_matte_name( const RfMatteNames* names, uint32_t id )
{
    int low = 0, high = names->count;
    while ( low < high )
    {
        int middle = low + ( high - low ) / 2;
        if ( names->names[middle].id < id )
            low = middle + 1;
        else
            high = middle;
    }
    return low < names->count && names->names[low].id == id ? low : -1;
}
