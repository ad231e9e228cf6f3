// Names of objects of a glTF document.
#include "scene/json/item_names.h"

#include "base/words.h"

#include <stdio.h>

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
