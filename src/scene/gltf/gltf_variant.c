// KHR_materials_variants: lists the variants of a file, and gives its primitives the materials of the one that is chosen. This
// is done in the document, before anything reads materials.
#include "scene/gltf/gltf_document.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXTENSION "KHR_materials_variants"

// Those that a message names.
#define MAX_NAMED 16

static RfResult list_variants( RfGltf* gltf, const json_t* list )
{
    RfScene* scene = gltf->scene;
    size_t count = json_array_size( list );
    scene->variants = calloc( count + 1, sizeof *scene->variants );
    if ( scene->variants == NULL )
        return rf_gltf_no_memory( gltf, EXTENSION );
    RfResult result = RF_OK;
    for ( size_t i = 0; result == RF_OK && i < count; ++i )
    {
        const json_t* item = json_array_get( list, i );
        RfWhere where = rf_where( EXTENSION ".variants[%zu]", i );
        result = rf_gltf_require( gltf, item, where.text, "name" );
        if ( result == RF_OK )
            result = rf_gltf_copy_name( gltf, item, where.text, where.text, scene->variants + i );
        scene->variant_count += result == RF_OK;
    }
    return result;
}

static RfResult find_chosen( const RfGltf* gltf, const json_t* list, json_int_t* chosen )
{
    const RfScene* scene = gltf->scene;
    const char* wanted = gltf->options->variant;
    char names[MAX_NAMED * 64 + 32] = "";
    char* end = names;
    const json_t* item;
    size_t i;
    json_array_foreach( list, i, item )
    {
        *chosen = (json_int_t)i;
        if ( strcmp( scene->variants[i], wanted ) == 0 ) // as it is listed, where its name is empty too
            return RF_OK;
        if ( i < MAX_NAMED )
            end += snprintf( end, 64, "%s'%.50s'", i > 0 ? ", " : "", scene->variants[i] );
    }
    if ( i > MAX_NAMED )
        snprintf( end, 32, " and %zu more", i - MAX_NAMED );
    return rf_gltf_fail( gltf, RF_ERROR_USAGE, EXTENSION, "none is called '%.80s'%s%s", wanted,
                         i > 0 ? ": there are " : ": there are none", names );
}

// The material of a primitive in the variant; −1: its own.
static RfResult find_material( const RfGltf* gltf, const json_t* primitive, const char* owner, json_int_t chosen, int* material )
{
    const json_t *json, *mappings = NULL, *mapping, *variants, *variant;
    size_t i, k;
    *material = -1;
    RfResult result = rf_gltf_get_extension( gltf, primitive, owner, EXTENSION, &json );
    if ( result != RF_OK || json == NULL )
        return result;
    RfWhere where = rf_where( "%s.extensions." EXTENSION, owner );
    result = rf_gltf_get_array( gltf, json, where.text, "mappings", &mappings );
    json_array_foreach( mappings, i, mapping )
    {
        RfWhere self = rf_where( "%s.mappings[%zu]", where.text, i );
        if ( !json_is_object( mapping ) )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, self.text, "must be an object" );
        if ( result == RF_OK )
            result = rf_gltf_get_array( gltf, mapping, self.text, "variants", &variants );
        if ( result != RF_OK )
            return result;
        json_array_foreach( variants, k, variant )
        {
            if ( !json_is_integer( variant ) || json_integer_value( variant ) != chosen || *material >= 0 )
                continue;
            result = rf_gltf_require( gltf, mapping, self.text, "material" );
            if ( result == RF_OK )
                result = rf_gltf_get_index( gltf, mapping, self.text, "material", RF_GLTF_MATERIALS, material );
        }
    }
    return result;
}

static RfResult dress_mesh( RfGltf* gltf, int index, json_int_t chosen )
{
    json_t* primitive;
    size_t i;
    json_array_foreach( json_object_get( rf_gltf_item( gltf, RF_GLTF_MESHES, index ), "primitives" ), i, primitive )
    {
        int material;
        RfWhere where = rf_where( "meshes[%d].primitives[%zu]", index, i );
        if ( !json_is_object( primitive ) )
            continue; // an error where meshes are read
        RfResult result = find_material( gltf, primitive, where.text, chosen, &material );
        if ( result != RF_OK )
            return result;
        if ( material >= 0 && json_object_set_new( primitive, "material", json_integer( material ) ) != 0 )
            return rf_gltf_no_memory( gltf, where.text );
    }
    return RF_OK;
}

RfResult rf_gltf_choose_variant( RfGltf* gltf )
{
    const json_t *json, *list = NULL;
    json_int_t chosen = -1;
    RfResult result = rf_gltf_get_extension( gltf, gltf->root, "document", EXTENSION, &json );
    if ( result == RF_OK && json != NULL )
        result = rf_gltf_get_array( gltf, json, EXTENSION, "variants", &list );
    if ( result == RF_OK )
        result = list_variants( gltf, list );
    if ( result != RF_OK || gltf->options->variant == NULL )
        return result;
    result = find_chosen( gltf, list, &chosen );
    for ( int i = 0; result == RF_OK && i < gltf->counts[RF_GLTF_MESHES]; ++i )
        result = dress_mesh( gltf, i, chosen );
    return result;
}
