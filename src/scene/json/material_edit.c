// Overrides materials by editing the parsed glTF, so that its reader validates the result.
#include "scene/json/material_edit.h"

#include "base/words.h"
#include "scene/json/item_names.h"
#include "scene/gltf/gltf_document.h"
#include "base/json.h"
#include "scene/json/keys.h"
#include "scene/json/sequence_json.h"
#include "scene/light_groups.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// The scattering models of extras.reframe.

static const char* const s_bsdfs[] = { "gltf", "lambert", "phong", NULL };

static const char* const s_lobe_keys[] = { "diffuse", "specular", "exponent", NULL };

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
    for ( int i = 0; s_lobe_keys[i] != NULL && result == RF_OK; ++i )
    {
        if ( has_lobe_key( s_bsdfs[index], s_lobe_keys[i] ) )
            result = rf_field_require( override, s_lobe_keys[i], i == 2 ? "a number from 0 to 1e+06" : "an array of 3 numbers" );
    }
    if ( result != RF_OK )
        return result;
    // what is of any model stays
    json_t* old = find_lobes( material );
    json_t* lobes = json_pack( "{s:O*, s:O*}", "light_group", json_object_get( old, "light_group" ), "pass_index",
                               json_object_get( old, "pass_index" ) );
    if ( index == 0 && json_object_size( lobes ) == 0 )
    {
        json_decref( lobes );
        json_object_del( json_object_get( material, "extras" ), "reframe" );
        return RF_OK;
    }
    json_t* extras = rf_edit_member( material, "extras" );
    bool done = index == 0 || json_object_set_new( lobes, "bsdf", json_string( s_bsdfs[index] ) ) == 0;
    return extras != NULL && json_object_set_new( extras, "reframe", lobes ) == 0 && done ? RF_OK : rf_field_no_memory( &field );
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
        return rf_field_no_memory( &field );
    return result;
}

static RfResult edit_light_group( const RfField* override, json_t* material )
{
    const char* name;
    RfResult result = rf_read_light_group( override, &name );
    if ( result != RF_OK || name == NULL )
        return result;
    json_t* extras = rf_edit_member( material, "extras" );
    json_t* ours = extras != NULL ? rf_edit_member( extras, "reframe" ) : NULL;
    bool done = ours != NULL && json_object_set_new( ours, "light_group", json_string( name ) ) == 0;
    return done ? RF_OK : rf_field_no_memory( override );
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
    FLAG,
    ALPHA_MODE,
    SEQUENCE,
    NOT_COPIED, // handled by name
} Type;

// The destination of a key of an override that is no number: those are rows of rf_changed_traits.
typedef struct Entry
{
    const char* key;
    Type type;
    const char* parent; // member object of the material, or NULL: the material itself
    bool gltf_only;     // has no effect if extras.reframe selects another bsdf
} Entry;

#define PBR "pbrMetallicRoughness"

static const Entry s_entries[] = {
    { "bsdf", NOT_COPIED, NULL, false },          { "diffuse", NOT_COPIED, NULL, false },
    { "specular", NOT_COPIED, NULL, false },      { "exponent", NOT_COPIED, NULL, false },
    { "doubleSided", FLAG, NULL, false },         { "alphaMode", ALPHA_MODE, NULL, false },
    { "baseColorTexture", SEQUENCE, PBR, false }, { "metallicRoughnessTexture", SEQUENCE, PBR, true },
    { "normalTexture", SEQUENCE, NULL, false },   { "emissiveTexture", SEQUENCE, NULL, false },
    { "textures", NOT_COPIED, NULL, false },      { "light_group", NOT_COPIED, NULL, false },
    { "interpolation", NOT_COPIED, NULL, false }, { "keys", NOT_COPIED, NULL, false },
};

#define ENTRY_COUNT ( (int)( sizeof s_entries / sizeof s_entries[0] ) )

// Values of materials that scene files have.
static RfChangedValue next_value( int from, unsigned flag )
{
    RfChangedValue v = rf_next_value( RF_OF_MATERIAL, from );
    while ( v < RF_CHANGED_COUNT && ( rf_changed_traits( v )->flags & flag ) == 0 )
        v = rf_next_value( RF_OF_MATERIAL, (int)v + 1 );
    return v;
}

// How a value is read from a scene file.
static RfKeyed keyed_of( RfChangedValue value )
{
    const RfChangedTraits* traits = rf_changed_traits( value );
    bool own = traits->file_high > 0.0;
    return ( RfKeyed ){ traits->name,
                        RF_VALUE,
                        traits->components,
                        own ? traits->file_low : traits->low,
                        own ? traits->file_high : traits->high,
                        1,
                        NULL };
}

static RfResult check_value( const RfField* field, const Entry* entry )
{
    static const char* const s_modes[] = { "OPAQUE", "MASK", "BLEND", NULL };
    bool flag;
    int mode;
    return entry->type == FLAG ? rf_field_bool( field, &flag ) : rf_field_choice( field, s_modes, &mode );
}

// Appends an object to a list of the document, and gives its number.
static bool append( json_t* root, const char* list, json_t* object, json_int_t* number )
{
    if ( json_object_get( root, list ) == NULL )
        json_object_set_new( root, list, json_array() );
    json_t* items = json_object_get( root, list );
    *number = (json_int_t)json_array_size( items );
    if ( items != NULL && !json_is_array( items ) ) // which the reader says
    {
        json_decref( object );
        return true;
    }
    return json_array_append_new( items, object ) == 0;
}

// Adds an image that is a sequence and its texture, which takes the place of that which the material has there, with its
// coordinates and its sampler. The glTF reader finds the files (scene/gltf/gltf_sequence.c).
static RfResult add_sequence( const RfField* field, const char* key, json_t* home, json_t* root )
{
    RfImageSequence sequence;
    const char* frames;
    RfResult result = rf_read_sequence( field, &sequence, &frames );
    if ( result != RF_OK )
        return result;
    json_int_t image, texture, old = -1;
    json_t* info = json_object_get( home, key );
    if ( json_is_integer( json_object_get( info, "index" ) ) )
        old = json_integer_value( json_object_get( info, "index" ) );
    json_t* before = old >= 0 ? json_array_get( json_object_get( root, "textures" ), (size_t)old ) : NULL;
    json_t* after = json_object();
    info = json_is_object( info ) ? json_copy( info ) : json_object();
    bool done =
        append( root, "images", json_pack( "{s:s, s:{s:O}}", "name", field->path, "extras", "reframe", field->json ), &image );
    done = done && json_object_set_new( after, "source", json_integer( image ) ) == 0;
    if ( json_object_get( before, "sampler" ) != NULL )
        json_object_set( after, "sampler", json_object_get( before, "sampler" ) );
    done = append( root, "textures", after, &texture ) && done;
    done = done && json_object_set_new( info, "index", json_integer( texture ) ) == 0;
    return json_object_set_new( home, key, info ) == 0 && done ? RF_OK : rf_field_no_memory( field );
}

static RfResult copy_value( const RfField* field, const Entry* entry, json_t* material, json_t* root )
{
    RfResult result = entry->type == SEQUENCE ? RF_OK : check_value( field, entry );
    json_t* home = entry->parent != NULL ? rf_edit_member( material, entry->parent ) : material;
    if ( result != RF_OK || home == NULL )
        return result != RF_OK ? result : rf_field_no_memory( field );
    if ( entry->type == SEQUENCE )
        return add_sequence( field, entry->key, home, root );
    return json_object_set( home, entry->key, (json_t*)field->json ) == 0 ? RF_OK : rf_field_no_memory( field );
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

#define MOST_KEYED 8

static RfResult add_override( const RfField* field, RfChangedValue value, size_t material, RfMaterialKeys* keys )
{
    RfOverride override = { .value = value, .material = (int)material };
    RfKeyed kind = keyed_of( value );
    RfResult result = rf_read_keyed( field, &kind, override.numbers );
    RfOverride* grown = realloc( keys->overrides, ( (size_t)keys->override_count + 1 ) * sizeof *grown );
    if ( grown == NULL )
        return rf_field_no_memory( field );
    keys->overrides = grown;
    keys->overrides[keys->override_count++] = override;
    return result;
}

static bool add_change( const RfChange* change, RfMaterialKeys* keys )
{
    RfChange* grown = realloc( keys->changes, ( (size_t)keys->count + 1 ) * sizeof *grown );
    if ( grown == NULL )
        return false;
    keys->changes = grown;
    keys->changes[keys->count++] = *change;
    return true;
}

// Reads the keys of a material of this number.
static RfResult read_keys( const RfField* override, json_t* root, size_t material, bool is_gltf, RfMaterialKeys* keys )
{
    RfChannel channels[MOST_KEYED];
    RfKeyed kinds[MOST_KEYED];
    RfChangedValue values[MOST_KEYED];
    int count = 0;
    bool in_frames;
    for ( RfChangedValue v = next_value( 0, RF_VALUE_KEYED ); v < RF_CHANGED_COUNT && count < MOST_KEYED;
          v = next_value( (int)v + 1, RF_VALUE_KEYED ) )
    {
        kinds[count] = keyed_of( v );
        values[count++] = v;
    }
    RfFps fps = keys->fps.numerator > 0 ? keys->fps : rf_gltf_document_fps( root );
    RfField field = rf_field_member( override, "keys" );
    RfResult result = rf_read_keys( override, fps, kinds, count, channels, &in_frames );
    for ( int i = 0; i < count; ++i )
    {
        RfChange change = { .value = values[i], .of = (int)material, .channel = channels[i] };
        bool of_model = ( rf_changed_traits( values[i] )->flags & RF_VALUE_OF_MODEL ) != 0, given = change.channel.count > 0;
        if ( result == RF_OK && given && of_model && !is_gltf )
            result = rf_field_fail( &field, "%s has no effect on another bsdf: add \"bsdf\": \"gltf\"", kinds[i].name );
        bool added = result == RF_OK && given && add_change( &change, keys );
        if ( result == RF_OK && given && !added )
            result = rf_field_no_memory( &field );
        if ( !added )
            rf_destroy_channel( channels + i );
    }
    keys->in_frames = keys->in_frames || in_frames;
    return result;
}

void rf_destroy_material_keys( RfMaterialKeys* keys )
{
    for ( int i = 0; i < keys->count; ++i )
        rf_destroy_channel( &keys->changes[i].channel );
    free( keys->changes );
    free( keys->overrides );
    *keys = ( RfMaterialKeys ){ .fps = keys->fps };
}

static RfResult fail_other_bsdf( const RfField* field, const char* bsdf )
{
    return rf_field_fail( field, "has no effect on bsdf \"%.20s\": add \"bsdf\": \"gltf\"", bsdf );
}

// What materials are edited in, and what their values go to.
typedef struct Editing
{
    json_t* root;
    RfMaterialKeys* keys;
} Editing;

static RfResult edit_material( const RfField* override, json_t* material, size_t index, void* user )
{
    const Editing* editing = user;
    RfResult result = edit_lobes( override, material );
    if ( result == RF_OK )
        result = edit_light_group( override, material );
    if ( result == RF_OK )
        result = edit_textures( override, material );
    const char* bsdf = edited_bsdf( material );
    bool is_gltf = strcmp( bsdf, "gltf" ) == 0;
    for ( int i = 0; i < ENTRY_COUNT && result == RF_OK; ++i )
    {
        RfField field = rf_field_member( override, s_entries[i].key );
        if ( s_entries[i].type == NOT_COPIED || field.json == NULL )
            continue;
        result = s_entries[i].gltf_only && !is_gltf ? fail_other_bsdf( &field, bsdf )
                                                    : copy_value( &field, s_entries + i, material, editing->root );
    }
    for ( RfChangedValue v = next_value( 0, RF_VALUE_IN_FILE ); v < RF_CHANGED_COUNT && result == RF_OK;
          v = next_value( (int)v + 1, RF_VALUE_IN_FILE ) )
    {
        RfField field = rf_field_member( override, rf_changed_traits( v )->name );
        if ( field.json == NULL )
            continue;
        bool of_model = ( rf_changed_traits( v )->flags & RF_VALUE_OF_MODEL ) != 0;
        result = of_model && !is_gltf ? fail_other_bsdf( &field, bsdf ) : add_override( &field, v, index, editing->keys );
    }
    return result == RF_OK ? read_keys( override, editing->root, index, is_gltf, editing->keys ) : result;
}

RfResult rf_edit_materials( const RfField* materials, json_t* root, RfMaterialKeys* keys, RfGltfOptions* options )
{
    const char* names[ENTRY_COUNT + RF_CHANGED_COUNT + 1] = { NULL };
    int count = 0;
    Editing editing = { root, keys };
    for ( int i = 0; i < ENTRY_COUNT; ++i )
        names[count++] = s_entries[i].key;
    for ( RfChangedValue v = next_value( 0, RF_VALUE_IN_FILE ); v < RF_CHANGED_COUNT;
          v = next_value( (int)v + 1, RF_VALUE_IN_FILE ) )
        names[count++] = rf_changed_traits( v )->name;
    RfResult result =
        rf_edit_items( materials, "material", json_object_get( root, "materials" ), names, edit_material, &editing );
    options->changes = keys->changes;
    options->change_count = keys->count;
    options->overrides = keys->overrides;
    options->override_count = keys->override_count;
    return result;
}
