// Names of objects of a glTF document, and edits of them.
#include "scene/json/item_names.h"

#include "base/words.h"

#include <stdio.h>
#include <string.h>

#define NAMES_LISTED 12

const char* rf_item_name( const json_t* list, const char* plural, size_t index, char fallback[RF_ITEM_NAME] )
{
    const char* name = json_string_value( json_object_get( json_array_get( list, index ), "name" ) );
    snprintf( fallback, RF_ITEM_NAME, "%.9s[%zu]", plural, index );
    return name != NULL && name[0] != 0 ? name : fallback;
}

RfResult rf_fail_unknown_item( const RfField* field, const char* kind, const char* name, const json_t* list )
{
    char text[400], plural[16], fallback[RF_ITEM_NAME], nearest[128] = "";
    size_t used = 0, count = json_array_size( list );
    text[0] = 0;
    snprintf( plural, sizeof plural, "%.9ss", kind );
    for ( size_t i = 0; i < count; ++i )
    {
        const char* one = rf_item_name( list, plural, i, fallback );
        if ( nearest[0] == 0 && rf_nearest_word( name, &one, 1 ) != NULL )
            snprintf( nearest, sizeof nearest, "did you mean '%.60s'? ", one );
        if ( i < NAMES_LISTED && used < sizeof text )
            used += (size_t)snprintf( text + used, sizeof text - used, "%s'%.24s'", i > 0 ? ", " : "", one );
    }
    if ( count > NAMES_LISTED )
        return rf_field_fail( field, "the scene has no such %s: %sthere are %s and %zu more", kind, nearest, text,
                              count - NAMES_LISTED );
    return rf_field_fail( field, "the scene has no such %s: %sthere are %s", kind, nearest, count > 0 ? text : "none" );
}

static RfResult edit_by_name( const RfField* edit, const char* name, const char* kind, const json_t* list, RfEditItem* run,
                              void* user )
{
    char fallback[RF_ITEM_NAME], plural[16];
    RfResult result = RF_OK;
    bool found = false;
    snprintf( plural, sizeof plural, "%.9ss", kind );
    for ( size_t i = 0; i < json_array_size( list ) && result == RF_OK; ++i )
    {
        json_t* item = json_array_get( list, i );
        if ( !json_is_object( item ) || strcmp( rf_item_name( list, plural, i, fallback ), name ) != 0 )
            continue;
        found = true;
        result = run( edit, item, i, user );
    }
    return result == RF_OK && !found ? rf_fail_unknown_item( edit, kind, name, list ) : result;
}

RfResult rf_edit_items( const RfField* edits, const char* kind, const json_t* list, const char* const* keys, RfEditItem* run,
                        void* user )
{
    char want[40];
    const char* name;
    json_t* value;
    RfResult result = rf_json_result( edits );
    if ( edits->json == NULL )
        return result;
    snprintf( want, sizeof want, "an object of %.9ss by name", kind );
    if ( !json_is_object( edits->json ) )
        return rf_field_must_be( edits, want );
    json_object_foreach( (json_t*)edits->json, name, value )
    {
        RfField edit = rf_field_member( edits, name );
        if ( result == RF_OK )
            result = rf_field_keys( &edit, keys );
        if ( result == RF_OK )
            result = edit_by_name( &edit, name, kind, list, run, user );
    }
    return result;
}

json_t* rf_edit_member( json_t* object, const char* key )
{
    json_t* member = json_object_get( object, key );
    if ( json_is_object( member ) )
        return member;
    json_t* made = json_object();
    return json_object_set_new( object, key, made ) == 0 ? made : NULL;
}
