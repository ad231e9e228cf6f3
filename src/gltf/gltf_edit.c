// What a scene file says of materials and lights by their names, or by "materials[3]" where they have none. It is read where the
// values of the document are (gltf_material.c, gltf_light.c), after them.
#include "gltf/gltf_document.h"

#include "base/words.h"
#include "scene/movement.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NAMES_LISTED 12

// The name of an item of a list that is called `plural`.
static const char* item_name( const json_t* list, const char* plural, size_t index, char fallback[RF_ITEM_NAME] )
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
        const char* one = item_name( list, plural, i, fallback );
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

// Gives the edit to all items of its name.
static RfResult set_edit( const RfField* edit, const char* name, const char* kind, const json_t* list, RfField* edits )
{
    char fallback[RF_ITEM_NAME], plural[16];
    bool found = false;
    snprintf( plural, sizeof plural, "%.9ss", kind );
    for ( size_t i = 0; i < json_array_size( list ); ++i )
    {
        if ( strcmp( item_name( list, plural, i, fallback ), name ) != 0 )
            continue;
        found = true;
        edits[i] = *edit;
    }
    return found ? rf_json_result( edit ) : rf_fail_unknown_item( edit, kind, name, list );
}

// Finds the items of a list that `all` has a member for, each of which has some of `keys`.
static RfResult open_edits( RfGltf* gltf, const RfField* all, const char* kind, const json_t* list, const char* const* keys,
                            RfField** edits )
{
    char want[40];
    const char* name;
    json_t* value;
    RfField named = rf_make_field( all->file, all->path, all->json, gltf->error );
    RfResult result = gltf->error->code;
    if ( all->json == NULL )
        return result;
    snprintf( want, sizeof want, "an object of %.9ss by name", kind );
    if ( !json_is_object( all->json ) )
        return rf_field_must_be( &named, want );
    *edits = calloc( json_array_size( list ) + 1, sizeof **edits );
    if ( *edits == NULL )
        return rf_gltf_no_memory( gltf, kind );
    json_object_foreach( (json_t*)all->json, name, value )
    {
        RfField edit = rf_field_member( &named, name );
        rf_field_keys( &edit, keys );
        if ( result == RF_OK )
            result = set_edit( &edit, name, kind, list, *edits );
    }
    return result;
}

RfResult rf_gltf_open_edits( RfGltf* gltf )
{
    static const char* const s_light_keys[] = {
        "ies", "radius", "soft", "angle", "shape", "size", "spread", "light_group", NULL
    };
    static const char* const s_material_keys[] = { "bsdf",
                                                   "diffuse",
                                                   "specular",
                                                   "exponent",
                                                   "doubleSided",
                                                   "alphaMode",
                                                   "baseColorTexture",
                                                   "metallicRoughnessTexture",
                                                   "normalTexture",
                                                   "emissiveTexture",
                                                   "textures",
                                                   "light_group",
                                                   "interpolation",
                                                   "keys" };
    const char* keys[sizeof s_material_keys / sizeof s_material_keys[0] + RF_CHANGED_COUNT + 1] = { NULL };
    int count = (int)( sizeof s_material_keys / sizeof s_material_keys[0] );
    const json_t* punctual = json_object_get( json_object_get( gltf->root, "extensions" ), "KHR_lights_punctual" );
    memcpy( keys, s_material_keys, sizeof s_material_keys );
    for ( RfChangedValue v = rf_next_value( RF_OF_MATERIAL, 0 ); v < RF_CHANGED_COUNT;
          v = rf_next_value( RF_OF_MATERIAL, (int)v + 1 ) )
    {
        if ( ( rf_changed_traits( v )->flags & RF_VALUE_IN_FILE ) != 0 )
            keys[count++] = rf_changed_traits( v )->name;
    }
    RfResult result =
        open_edits( gltf, &gltf->options->materials, "material", gltf->lists[RF_GLTF_MATERIALS], keys, &gltf->material_edits );
    return result == RF_OK ? open_edits( gltf, &gltf->options->lights, "light", json_object_get( punctual, "lights" ),
                                         s_light_keys, &gltf->light_edits )
                           : result;
}
