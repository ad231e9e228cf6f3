// Adds to the extras of lights in the parsed glTF.
#include "scene/json/light_edit.h"

#include "scene/json/item_names.h"

static RfResult edit_light( const RfField* override, json_t* light, size_t index, void* user )
{
    (void)index, (void)user;
    RfField ies = rf_field_member( override, "ies" );
    const char* file = NULL;
    RfResult result = rf_field_text( &ies, &file );
    json_t* ours = rf_edit_member( rf_edit_member( light, "extras" ), "reframe" );
    if ( result == RF_OK && ies.json != NULL )
        json_object_del( ours, "profile" );
    bool done = result == RF_OK && ours != NULL && json_object_update( ours, ( json_t* ) override->json ) == 0;
    if ( done && ies.json != NULL )
        done = json_object_set_new( ours, "ies", json_pack( "{s:s}", "beside", file ) ) == 0;
    return done || result != RF_OK ? result : rf_field_no_memory( override );
}

RfResult rf_edit_lights( const RfField* lights, json_t* root )
{
    static const char* const s_keys[] = { "ies", "radius", "soft", "angle", "shape", "size", "spread", "light_group", NULL };
    const json_t* punctual = json_object_get( json_object_get( root, "extensions" ), "KHR_lights_punctual" );
    return rf_edit_items( lights, "light", json_object_get( punctual, "lights" ), s_keys, edit_light, NULL );
}
