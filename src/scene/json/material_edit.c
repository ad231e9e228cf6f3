// Overrides materials by editing the parsed glTF, so that its reader validates the result.
#include "scene/json/material_edit.h"

#include "base/words.h"
#include "scene/json/item_names.h"
#include "scene/json/json_document.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// The scattering models of extras.reframe.

static const char* const s_bsdfs[] = { "gltf", "lambert", "phong", NULL };

static const char* const s_lobe_keys[] = { "diffuse", "specular", "exponent", NULL };

// Fails with RF_ERROR_MEMORY.
static RfResult edit_no_memory( const RfField* field )
{
    return rf_fail( field->error, RF_ERROR_MEMORY, "%s: %s: no memory left", field->file, field->path );
}

// The member object of that name, created if missing; NULL if out of memory.
static json_t* edit_member( json_t* object, const char* key )
{
    json_t* member = json_object_get( object, key );
    if ( json_is_object( member ) )
        return member;
    json_t* made = json_object();
    return json_object_set_new( object, key, made ) == 0 ? made : NULL;
}

static json_t* find_lobes( const json_t* material )
{
    return json_object_get( json_object_get( material, "extras" ), "reframe" );
}

// The bsdf of a material; "gltf" unless extras.reframe selects another.
static const char* edited_bsdf( const json_t* material )
{
    const json_t* lobes = find_lobes( material );
    const char* bsdf = json_string_value( json_object_get( lobes, "bsdf" ) );
    return bsdf != NULL ? bsdf : "gltf";
}

static bool has_lobe_key( const char* bsdf, const char* key )
{
    return strcmp( bsdf, "phong" ) == 0 || ( strcmp( bsdf, "lambert" ) == 0 && strcmp( key, "diffuse" ) == 0 );
}

// Changes the material to the bsdf that the override selects.
static RfResult change_bsdf( const RfField* override, json_t* material )
{
    int index = 0;
    RfField field = rf_field_member( override, "bsdf" );
    RfResult result = rf_field_choice( &field, s_bsdfs, &index );
    if ( result != RF_OK || field.json == NULL )
        return result;
    if ( index == 0 )
    {
        json_object_del( json_object_get( material, "extras" ), "reframe" );
        return RF_OK;
    }
    for ( int i = 0; s_lobe_keys[i] != NULL && result == RF_OK; ++i )
    {
        if ( has_lobe_key( s_bsdfs[index], s_lobe_keys[i] ) )
            result = rf_field_require( override, s_lobe_keys[i], i == 2 ? "a number from 0 to 1e+06" : "an array of 3 numbers" );
    }
    if ( result != RF_OK )
        return result;
    json_t* extras = edit_member( material, "extras" );
    json_t* lobes = json_pack( "{s:s}", "bsdf", s_bsdfs[index] );
    return extras != NULL && json_object_set_new( extras, "reframe", lobes ) == 0 ? RF_OK : edit_no_memory( &field );
}

static RfResult edit_lobe( const RfField* override, const char* key, json_t* material )
{
    double numbers[3];
    RfField field = rf_field_member( override, key );
    if ( field.json == NULL )
        return RF_OK;
    const char* bsdf = edited_bsdf( material );
    if ( !has_lobe_key( bsdf, key ) )
        return rf_field_fail( &field,
                              "has no effect on bsdf \"%.20s\": add \"bsdf\": \"phong\" with diffuse, specular and "
                              "exponent",
                              bsdf );
    RfResult result = strcmp( key, "exponent" ) == 0 ? rf_field_number( &field, rf_range( 0.0, 1e6 ), numbers )
                                                     : rf_field_numbers( &field, rf_range( 0.0, 1.0 ), 3, numbers );
    if ( result == RF_OK && json_object_set( find_lobes( material ), key, (json_t*)field.json ) != 0 )
        return edit_no_memory( &field );
    return result;
}

static RfResult check_energy( const RfField* override, const json_t* material )
{
    const json_t* lobes = find_lobes( material );
    for ( size_t i = 0; i < 3; ++i )
    {
        double diffuse = json_number_value( json_array_get( json_object_get( lobes, "diffuse" ), i ) );
        double specular = json_number_value( json_array_get( json_object_get( lobes, "specular" ), i ) );
        // the rounding of decimal fractions that sum to one does not violate energy conservation
        if ( diffuse + specular > 1.0 + 1e-6 )
            return rf_field_fail( override, "diffuse + specular reflect %g of the incident light: lower their sum to 1 or less",
                                  diffuse + specular );
    }
    return RF_OK;
}

// Copies bsdf, diffuse, specular and exponent of an override into the material.
static RfResult edit_lobes( const RfField* override, json_t* material )
{
    RfResult result = change_bsdf( override, material );
    for ( int i = 0; s_lobe_keys[i] != NULL && result == RF_OK; ++i )
        result = edit_lobe( override, s_lobe_keys[i], material );
    return result == RF_OK ? check_energy( override, material ) : result;
}

typedef enum Type
{
    NUMBERS,
    FLAG,
    ALPHA_MODE,
    NOT_COPIED, // handled by name
} Type;

// The destination of a key of an override.
typedef struct Entry
{
    const char* key;
    Type type;
    int count; // of numbers
    double low, high;
    const char* parent;    // member object of the material, or NULL: the material itself
    const char* extension; // or in this one of its extensions
    bool gltf_only;        // has no effect if extras.reframe selects another bsdf
} Entry;

#define PBR "pbrMetallicRoughness"

static const Entry s_entries[] = {
    { "bsdf", NOT_COPIED, 0, 0, 0, NULL, NULL, false },
    { "diffuse", NOT_COPIED, 0, 0, 0, NULL, NULL, false },
    { "specular", NOT_COPIED, 0, 0, 0, NULL, NULL, false },
    { "exponent", NOT_COPIED, 0, 0, 0, NULL, NULL, false },
    { "baseColorFactor", NUMBERS, 4, 0, 1, PBR, NULL, true },
    { "metallicFactor", NUMBERS, 1, 0, 1, PBR, NULL, true },
    { "roughnessFactor", NUMBERS, 1, 0, 1, PBR, NULL, true },
    { "specularFactor", NUMBERS, 1, 0, 1, NULL, "KHR_materials_specular", true },
    { "specularColorFactor", NUMBERS, 3, 0, 1e6, NULL, "KHR_materials_specular", true },
    { "ior", NUMBERS, 1, 1, 100, NULL, "KHR_materials_ior", true },
    { "transmissionFactor", NUMBERS, 1, 0, 1, NULL, "KHR_materials_transmission", true },
    { "thicknessFactor", NUMBERS, 1, 0, 1e15, NULL, "KHR_materials_volume", true },
    { "attenuationDistance", NUMBERS, 1, 1e-15, 1e15, NULL, "KHR_materials_volume", true },
    { "attenuationColor", NUMBERS, 3, 0, 1, NULL, "KHR_materials_volume", true },
    { "clearcoatFactor", NUMBERS, 1, 0, 1, NULL, "KHR_materials_clearcoat", true },
    { "clearcoatRoughnessFactor", NUMBERS, 1, 0, 1, NULL, "KHR_materials_clearcoat", true },
    { "emissiveFactor", NUMBERS, 3, 0, 1, NULL, NULL, false },
    { "emissiveStrength", NUMBERS, 1, 0, 1e15, NULL, "KHR_materials_emissive_strength", false },
    { "doubleSided", FLAG, 0, 0, 0, NULL, NULL, false },
    { "alphaMode", ALPHA_MODE, 0, 0, 0, NULL, NULL, false },
    { "alphaCutoff", NUMBERS, 1, 0, 1e6, NULL, NULL, false },
    { "textures", NOT_COPIED, 0, 0, 0, NULL, NULL, false },
};

#define ENTRY_COUNT ( sizeof s_entries / sizeof s_entries[0] )

static RfResult check_value( const RfField* field, const Entry* entry )
{
    static const char* const s_modes[] = { "OPAQUE", "MASK", "BLEND", NULL };
    double numbers[4];
    bool flag;
    int mode;
    RfRange range = rf_range( entry->low, entry->high );
    if ( entry->type == FLAG )
        return rf_field_bool( field, &flag );
    if ( entry->type == ALPHA_MODE )
        return rf_field_choice( field, s_modes, &mode );
    return entry->count == 1 ? rf_field_number( field, range, numbers ) : rf_field_numbers( field, range, entry->count, numbers );
}

static RfResult copy_value( const RfField* field, const Entry* entry, json_t* material )
{
    RfResult result = check_value( field, entry );
    if ( result != RF_OK )
        return result;
    json_t* home = material;
    if ( entry->parent != NULL )
        home = edit_member( material, entry->parent );
    else if ( entry->extension != NULL )
    {
        home = edit_member( material, "extensions" );
        home = home != NULL ? edit_member( home, entry->extension ) : NULL;
    }
    if ( home == NULL || json_object_set( home, entry->key, (json_t*)field->json ) != 0 )
        return edit_no_memory( field );
    return RF_OK;
}

// Takes the animations of a value out, which stands still then.
static void stop_channels( json_t* channels, const char* pointer )
{
    for ( size_t i = json_array_size( channels ); i-- > 0; )
    {
        const json_t* target = json_object_get( json_array_get( channels, i ), "target" );
        const json_t* extension = json_object_get( json_object_get( target, "extensions" ), "KHR_animation_pointer" );
        const char* own = json_string_value( json_object_get( extension, "pointer" ) );
        if ( own != NULL && strcmp( own, pointer ) == 0 )
            json_array_remove( channels, i );
    }
}

static void stop_value( json_t* root, size_t material, const Entry* entry )
{
    char pointer[160];
    const json_t* animations = json_object_get( root, "animations" );
    const char *home = entry->parent != NULL ? entry->parent : entry->extension,
               *before = entry->extension != NULL ? "extensions/" : "";
    snprintf( pointer, sizeof pointer, "/materials/%zu/%s%s%s%s", material, before, home != NULL ? home : "",
              home != NULL ? "/" : "", entry->key );
    for ( size_t i = 0; i < json_array_size( animations ); ++i )
        stop_channels( json_object_get( json_array_get( animations, i ), "channels" ), pointer );
}

// Removes textures from an object and its member objects, to the depth at which glTF has them.
static void drop_textures( json_t* object, int depth )
{
    const char* key;
    void* next;
    json_t* value;
    json_object_foreach_safe( object, next, key, value )
    {
        if ( rf_ends_with( key, "Texture" ) )
            json_object_del( object, key );
        else if ( json_is_object( value ) && depth > 0 && strcmp( key, "extras" ) != 0 )
            drop_textures( value, depth - 1 );
    }
}

static RfResult edit_textures( const RfField* override, json_t* material )
{
    bool keep = true;
    RfField field = rf_field_member( override, "textures" );
    RfResult result = rf_field_bool( &field, &keep );
    if ( result == RF_OK && !keep )
        drop_textures( material, 2 );
    return result;
}

static RfResult edit_material( const RfField* override, json_t* root, size_t index )
{
    json_t* material = json_array_get( json_object_get( root, "materials" ), index );
    RfResult result = edit_lobes( override, material );
    if ( result == RF_OK )
        result = edit_textures( override, material );
    bool is_gltf = strcmp( edited_bsdf( material ), "gltf" ) == 0;
    for ( size_t i = 0; i < ENTRY_COUNT && result == RF_OK; ++i )
    {
        const Entry* entry = s_entries + i;
        RfField field = rf_field_member( override, entry->key );
        if ( entry->type == NOT_COPIED || field.json == NULL )
            continue;
        if ( entry->gltf_only && !is_gltf )
            return rf_field_fail( &field, "has no effect on bsdf \"%.20s\": add \"bsdf\": \"gltf\"", edited_bsdf( material ) );
        result = copy_value( &field, entry, material );
        if ( result == RF_OK )
            stop_value( root, index, entry );
    }
    return result;
}

static RfResult edit_by_name( const RfField* override, const char* name, json_t* root )
{
    const json_t* list = json_object_get( root, "materials" );
    const char* keys[ENTRY_COUNT + 1] = { NULL };
    for ( size_t i = 0; i < ENTRY_COUNT; ++i )
        keys[i] = s_entries[i].key;
    RfResult result = rf_field_keys( override, keys );
    bool found = false;
    for ( size_t i = 0; i < json_array_size( list ) && result == RF_OK; ++i )
    {
        char fallback[RF_ITEM_NAME];
        if ( !json_is_object( json_array_get( list, i ) ) || strcmp( rf_item_name( list, "materials", i, fallback ), name ) != 0 )
            continue;
        found = true;
        result = edit_material( override, root, i );
    }
    return result == RF_OK && !found ? rf_fail_unknown_item( override, "material", name, list ) : result;
}

RfResult rf_edit_materials( const RfField* materials, json_t* root )
{
    if ( materials->json == NULL )
        return RF_OK;
    if ( !json_is_object( materials->json ) )
        return rf_field_must_be( materials, "an object of materials by name" );
    RfResult result = RF_OK;
    const char* name;
    json_t* value;
    json_object_foreach( (json_t*)materials->json, name, value )
    {
        RfField override = rf_field_member( materials, name );
        result = edit_by_name( &override, name, root );
        if ( result != RF_OK )
            break;
    }
    return result;
}
