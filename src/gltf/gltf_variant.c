// KHR_materials_variants: lists the variants of a file, and finds the materials of primitives in the one that is chosen.
#include "gltf/gltf_document.h"

#include "base/words.h"

#include <string.h>

#define EXTENSION "KHR_materials_variants"

// Those that a message names.
#define MAX_NAMED 16

static RfResult list_variants( RfGltf* gltf, const RfField* list )
{
    RfScene* scene = gltf->scene;
    size_t count = json_array_size( list->json );
    RF_TRY( rf_gltf_allocate( gltf, EXTENSION, &scene->variants, count, sizeof *scene->variants ) );
    RfResult result = RF_OK;
    for ( size_t i = 0; result == RF_OK && i < count; ++i )
    {
        RfField item = rf_field_item( list, i );
        result = rf_gltf_require( &item, "name", NULL );
        if ( result == RF_OK )
            result = rf_gltf_copy_name( &item, item.path, scene->variants + i );
        scene->variant_count += result == RF_OK;
    }
    return result;
}

static RfResult find_chosen( const RfGltf* gltf, const json_t* list, int64_t* chosen )
{
    const RfScene* scene = gltf->scene;
    const char* wanted = gltf->options->variant;
    char names[MAX_NAMED * 64 + 32] = "";
    const json_t* item;
    size_t i;
    json_array_foreach( list, i, item )
    {
        *chosen = (int64_t)i;
        if ( strcmp( scene->variants[i], wanted ) == 0 ) // as it is listed, where its name is empty too
            return RF_OK;
        if ( i < MAX_NAMED )
            rf_append( names, sizeof names, "%s'%.50s'", i > 0 ? ", " : "", scene->variants[i] );
    }
    if ( i > MAX_NAMED )
        rf_append( names, sizeof names, " and %zu more", i - MAX_NAMED );
    return rf_gltf_fail( gltf, RF_ERROR_USAGE, EXTENSION, "none is called '%.80s'%s%s", wanted,
                         i > 0 ? ": there are " : ": there are none", names );
}

RfResult rf_gltf_material_of( const RfGltf* gltf, const RfField* primitive, int* material )
{
    const json_t* variant;
    size_t k;
    RfField extension = gltf->variant >= 0 ? rf_gltf_extension( primitive, EXTENSION ) : *primitive,
            mappings = gltf->variant >= 0 ? rf_get_array( &extension, "mappings" ) : extension;
    *material = -1;
    for ( size_t i = 0; i < json_array_size( mappings.json ); ++i )
    {
        RfField mapping = rf_field_item( &mappings, i );
        if ( !json_is_object( mapping.json ) )
            return rf_field_fail( &mapping, "must be an object" );
        RfField variants = rf_get_array( &mapping, "variants" );
        json_array_foreach( variants.json, k, variant )
        {
            if ( !json_is_integer( variant ) || json_integer_value( variant ) != gltf->variant || *material >= 0 )
                continue;
            rf_gltf_require( &mapping, "material", NULL );
            *material = rf_gltf_get_index( gltf, &mapping, "material", RF_GLTF_MATERIALS );
        }
    }
    if ( *material < 0 )
        *material = rf_gltf_get_index( gltf, primitive, "material", RF_GLTF_MATERIALS );
    return rf_json_result( primitive );
}

RfResult rf_gltf_choose_variant( RfGltf* gltf )
{
    RfField root = rf_gltf_root( gltf );
    RfField json = rf_gltf_field( gltf, EXTENSION, rf_gltf_extension( &root, EXTENSION ).json ),
            list = rf_get_array( &json, "variants" );
    RfResult result = rf_json_result( &root ) == RF_OK ? list_variants( gltf, &list ) : rf_json_result( &root );
    return result == RF_OK && gltf->options->variant != NULL ? find_chosen( gltf, list.json, &gltf->variant ) : result;
}
