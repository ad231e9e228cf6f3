// Materials: glTF's metallic-roughness model as a Lambert base under a GGX lobe, with
// KHR_materials_specular, _ior and _emissive_strength.

#include "scene/gltf/gltf_materials.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct Factors
{
    RfFactors lobes;
    double emissive[3];
    double strength;
} Factors;

static Factors default_factors( void )
{
    return ( Factors ){
        .lobes = { .base = { 1, 1, 1, 1 },
                   .metallic = 1,
                   .roughness = 1,
                   .specular = 1,
                   .specular_color = { 1, 1, 1 },
                   .ior = 1.5 },
        .strength = 1,
    };
}

static RfResult get_factors( const RfGltf* gltf, const json_t* json, const char* where, const char* key, int count,
                             double* values )
{
    RfResult result = count > 1 ? rf_gltf_get_numbers( gltf, json, where, key, count, values )
                                : rf_gltf_get_number( gltf, json, where, key, values );
    for ( int i = 0; result == RF_OK && i < count; ++i )
    {
        if ( ( values[i] >= 0.0 && values[i] <= 1.0 ) == false )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s is %g, it wants 0 to 1", key, values[i] );
    }
    return result;
}

static RfResult read_metallic_roughness( const RfGltf* gltf, const json_t* material, const char* owner, RfFactors* out )
{
    const json_t* json = NULL;
    RfResult result = rf_gltf_get_object( gltf, material, owner, "pbrMetallicRoughness", &json );
    if ( result != RF_OK || json == NULL )
        return result;
    RfWhere where = rf_where( "%s.pbrMetallicRoughness", owner );
    result = get_factors( gltf, json, where.text, "baseColorFactor", 4, out->base );
    if ( result == RF_OK )
        result = get_factors( gltf, json, where.text, "metallicFactor", 1, &out->metallic );
    if ( result == RF_OK )
        result = get_factors( gltf, json, where.text, "roughnessFactor", 1, &out->roughness );
    return result;
}

static RfResult read_specular( const RfGltf* gltf, const json_t* material, const char* owner, RfFactors* out )
{
    const json_t* json;
    RfResult result = rf_gltf_get_extension( gltf, material, owner, "KHR_materials_specular", &json );
    if ( result != RF_OK || json == NULL )
        return result;
    RfWhere where = rf_where( "%s.extensions.KHR_materials_specular", owner );
    result = get_factors( gltf, json, where.text, "specularFactor", 1, &out->specular );
    if ( result == RF_OK )
        result = rf_gltf_get_numbers( gltf, json, where.text, "specularColorFactor", 3, out->specular_color );
    // a colour may exceed one: the resulting reflectance is clamped
    for ( int i = 0; result == RF_OK && i < 3; ++i )
    {
        if ( out->specular_color[i] < 0.0 )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "specularColorFactor is below 0" );
    }
    return result;
}

static RfResult read_ior( const RfGltf* gltf, const json_t* material, const char* owner, RfFactors* out )
{
    const json_t* json;
    RfResult result = rf_gltf_get_extension( gltf, material, owner, "KHR_materials_ior", &json );
    if ( result != RF_OK || json == NULL )
        return result;
    RfWhere where = rf_where( "%s.extensions.KHR_materials_ior", owner );
    result = rf_gltf_get_number( gltf, json, where.text, "ior", &out->ior );
    // by the extension, 0 means total reflection
    if ( result == RF_OK && out->ior != 0.0 && out->ior < 1.0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "ior is %g, it wants 0, or 1 and above", out->ior );
    return result;
}

static RfResult read_emission( const RfGltf* gltf, const json_t* material, const char* owner, Factors* out )
{
    RfResult result = get_factors( gltf, material, owner, "emissiveFactor", 3, out->emissive );
    const json_t* json = NULL;
    if ( result == RF_OK )
        result = rf_gltf_get_extension( gltf, material, owner, "KHR_materials_emissive_strength", &json );
    if ( result != RF_OK || json == NULL )
        return result;
    RfWhere where = rf_where( "%s.extensions.KHR_materials_emissive_strength", owner );
    result = rf_gltf_get_number( gltf, json, where.text, "emissiveStrength", &out->strength );
    if ( result == RF_OK && ( out->strength >= 0.0 ) == false )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "emissiveStrength is %g, it wants 0 or more", out->strength );
    return result == RF_OK ? rf_gltf_check_limit( gltf, where.text, "emissiveStrength", out->strength, RF_GLTF_MAX_EMISSION )
                           : result;
}

static void apply_factors( const Factors* in, RfMaterial* out )
{
    rf_derive_lobes( &in->lobes, out );
    out->kind = in->lobes.metallic == 0.0 && in->lobes.specular == 0.0 ? RF_BSDF_LAMBERT : RF_BSDF_GGX;
    out->emission = rf_vec3( (float)( in->emissive[0] * in->strength ), (float)( in->emissive[1] * in->strength ),
                             (float)( in->emissive[2] * in->strength ) );
}

static RfResult load_material( RfGltf* gltf, int index, RfMaterial* out )
{
    RfWhere where = rf_where( "materials[%d]", index );
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_MATERIALS, index );
    RfResult result = rf_gltf_copy_name( gltf, json, where.text, where.text, &out->name );
    if ( result != RF_OK )
        return result;
    Factors factors = default_factors();
    result = read_metallic_roughness( gltf, json, where.text, &factors.lobes );
    if ( result == RF_OK )
        result = read_specular( gltf, json, where.text, &factors.lobes );
    if ( result == RF_OK )
        result = read_ior( gltf, json, where.text, &factors.lobes );
    if ( result == RF_OK )
        result = rf_gltf_read_coat( gltf, json, where.text, &factors.lobes );
    if ( result == RF_OK )
        result = read_emission( gltf, json, where.text, &factors );
    if ( result == RF_OK )
        result = rf_gltf_get_bool( gltf, json, where.text, "doubleSided", &out->double_sided );
    if ( result != RF_OK )
        return result;
    rf_gltf_notice_extensions( gltf, json, "material", out->name );
    apply_factors( &factors, out );
    const RfFactors* lobes = &factors.lobes;
    result = rf_gltf_read_glass( gltf, json, where.text, lobes, out );
    if ( result == RF_OK )
        result = rf_gltf_read_clearcoat( gltf, json, where.text, out );
    if ( result == RF_OK )
        result = rf_gltf_read_lobes( gltf, json, where.text, out );
    return result == RF_OK ? rf_gltf_read_textured( gltf, json, where.text, lobes, out ) : result;
}

RfResult rf_gltf_load_materials( RfGltf* gltf )
{
    int count = gltf->counts[RF_GLTF_MATERIALS];
    // one more: the default material for primitives without one
    gltf->scene->materials = calloc( (size_t)count + 1, sizeof *gltf->scene->materials );
    if ( gltf->scene->materials == NULL )
        return rf_gltf_no_memory( gltf, "materials" );
    gltf->scene->material_count = (uint32_t)count;
    RfResult result = RF_OK;
    for ( int i = 0; result == RF_OK && i < count; ++i )
        result = load_material( gltf, i, gltf->scene->materials + i );
    return result;
}

RfResult rf_gltf_use_default_material( RfGltf* gltf, uint32_t* index )
{
    if ( gltf->default_material < 0 )
    {
        RfMaterial* material = gltf->scene->materials + gltf->scene->material_count;
        material->name = strdup( "default" );
        if ( material->name == NULL )
            return rf_gltf_no_memory( gltf, "materials" );
        Factors factors = default_factors();
        apply_factors( &factors, material );
        material->textured = rf_gltf_textured( &factors.lobes );
        if ( material->textured == NULL )
            return rf_gltf_no_memory( gltf, "materials" );
        material->textured->optional = true; // for primitives with vertex colours
        gltf->default_material = (int)gltf->scene->material_count++;
    }
    *index = (uint32_t)gltf->default_material;
    return RF_OK;
}
