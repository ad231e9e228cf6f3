// Adds to the extras of lights in the parsed glTF.
#include "scene/json/light_edit.h"

#include "scene/json/item_names.h"

#include <string.h>

static json_t* member_of( json_t* object, const char* key )
{
    json_t* member = json_object_get( object, key );
    if ( !json_is_object( member ) )
    {
        json_object_set_new( object, key, json_object() );
        member = json_object_get( object, key );
    }
    return member;
}

static RfResult edit_light( const RfField* override, json_t* light )
{
    RfField ies = rf_field_member( override, "ies" );
    const char* file = NULL;
    RfResult result = rf_field_text( &ies, &file );
    json_t* ours = member_of( member_of( light, "extras" ), "reframe" );
    if ( result == RF_OK && ies.json != NULL )
        json_object_del( ours, "profile" );
    bool done = result == RF_OK && ours != NULL && json_object_update( ours, ( json_t* ) override->json ) == 0;
    if ( done && ies.json != NULL )
        done = json_object_set_new( ours, "ies", json_pack( "{s:s}", "beside", file ) ) == 0;
    return done || result != RF_OK ? result : rf_field_no_memory( override );
}

static RfResult edit_by_name( const RfField* override, const char* name, json_t* list )
{
    static const char* const s_keys[] = { "ies", "radius", "soft", "angle", "shape", "size", "spread", "light_group", NULL };
    RfResult result = rf_field_keys( override, s_keys );
    bool found = false;
    for ( size_t i = 0; i < json_array_size( list ) && result == RF_OK; ++i )
    {
        char fallback[RF_ITEM_NAME];
        json_t* light = json_array_get( list, i );
        if ( !json_is_object( light ) || strcmp( rf_item_name( list, "lights", i, fallback ), name ) != 0 )
            continue;
        found = true;
        result = edit_light( override, light );
    }
    return result == RF_OK && !found ? rf_fail_unknown_item( override, "light", name, list ) : result;
}

RfResult rf_edit_lights( const RfField* lights, json_t* root )
{
    json_t* list = json_object_get( json_object_get( json_object_get( root, "extensions" ), "KHR_lights_punctual" ), "lights" );
    if ( lights->json == NULL )
        return RF_OK;
    if ( !json_is_object( lights->json ) )
        return rf_field_must_be( lights, "an object of lights by name" );
    RfResult result = RF_OK;
    const char* name;
    json_t* value;
    json_object_foreach( (json_t*)lights->json, name, value )
    {
        RfField override = rf_field_member( lights, name );
        result = edit_by_name( &override, name, list );
        if ( result != RF_OK )
            break;
    }
    return result;
}
