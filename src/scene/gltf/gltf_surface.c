// What extensions of materials do that lay something over the metallic-roughness model or change its lobes, except for clear coats,
// glass and textures.
#include "scene/gltf/gltf_materials.h"

#include <math.h>

bool rf_gltf_is_unlit( const json_t* material )
{
    return json_object_get( json_object_get( material, "extensions" ), "KHR_materials_unlit" ) != NULL;
}

static bool has_value( const json_t* material, const char* extension, const char* key )
{
    const json_t* object = json_object_get( json_object_get( material, "extensions" ), extension );
    return json_object_get( object, key ) != NULL;
}

// Does light go through the base of an opaque material? Not of a metal, unless a texture varies that.
static bool is_translucent( const json_t* material, const RfFactors* factors, const RfMaterial* m )
{
    const json_t* part = json_object_get( material, "pbrMetallicRoughness" );
    return factors->through > 0.0 && m->kind < RF_BSDF_FIRST_SPECULAR &&
           ( factors->metallic < 1.0 || json_object_get( part, "metallicRoughnessTexture" ) != NULL );
}

// What a translucent material has beyond what its model knows.
static void make_translucent( RfGltf* gltf, const RfMaterialValues* values, RfMaterial* out )
{
    RfMaterial layered = *out;
    rf_choose_layers( &layered );
    if ( layered.kind != RF_BSDF_GGX )
        rf_gltf_notice( gltf, RF_GLTF_LAYERED_TRANSLUCENT,
                        "sheen, anisotropy and films on a surface with diffuse transmission are not supported: material '%.80s' "
                        "is without them",
                        out->name );
    if ( values->thickness > 0.0 && values->attenuation_distance < HUGE_VAL )
        rf_gltf_notice( gltf, RF_GLTF_TRANSLUCENT_BODY,
                        "absorption inside a body with diffuse transmission is not supported: material '%.80s' is clear inside",
                        out->name );
    out->kind = RF_BSDF_TRANSLUCENT;
}

// The least extinction of the channels, 1/m: what KHR_materials_volume calls attenuation. 0 without any.
static double least_extinction( const RfMaterialValues* values )
{
    const double* color = values->attenuation_color;
    return -log( fmax( fmax( color[0], fmax( color[1], color[2] ) ), 1e-6 ) ) / values->attenuation_distance;
}

// The albedo of a half-space that is lit evenly, from that which KHR_materials_volume_scatter takes for it: its single-scattering
// albedo is 1 − s², whatever g is, which is as bright as an even phase function of 1 − s² / (1 − g (1 − s²)). The inverse of s(A)
// is that of the extension's fit, whose squares cancel to 2e-6.
static double albedo_of_half_space( double multiscatter, double g )
{
    double a = multiscatter, s = 4.09712 + 4.20863 * a - sqrt( 9.59217 + 41.6808 * a + 17.7126 * a * a );
    double even = s / sqrt( 1.0 - g * ( 1.0 - s * s ) ), u = 4.09712 - even;
    return g == 0.0 ? a : fmin( fmax( ( u * u - 9.59217 ) / ( 41.6808 - 2.0 * 4.20863 * u ), 0.0 ), 1.0 );
}

// What a half-space with a boundary reflects: on either side it reflects `base` and lets `in` through, all of it diffuse.
static double reflected( double base, double in, double albedo )
{
    return base + in * in * albedo / fmax( 1.0 - base * albedo, 1e-9 );
}

RfResult rf_gltf_apply_scatter( const RfField* material, RfMaterialValues* values, bool* dense )
{
    RfFactors* factors = &values->lobes;
    RfField json = rf_gltf_extension( material, "KHR_materials_volume_scatter" );
    double g = values->scatter_anisotropy, clear = values->transmission;
    *dense = false;
    if ( json.json == NULL )
        return rf_json_result( material );
    if ( !( g > -1.0 && g < 1.0 ) )
        return rf_field_fail( &json, "scatterAnisotropy is %g, it must be between -1 and 1", g );
    if ( factors->metallic > 0.0 || rf_gltf_is_unlit( material->json ) || rf_gltf_has_own_model( material->json ) )
        return RF_OK;
    // by the extension, diffuse transmission says that a body is dense
    double extinction = least_extinction( values );
    *dense = clear > 0.0 ? extinction * values->thickness >= 1.0 : factors->through > 0.0 && extinction > 0.0;
    for ( int i = 0; i < 3 && *dense; ++i )
    {
        double through = clear > 0.0 ? clear * factors->base[i] : factors->through * factors->through_color[i];
        double left = 1.0 - ( clear > 0.0 ? clear : factors->through );
        factors->base[i] = reflected( left * factors->base[i], through, albedo_of_half_space( values->multiscatter[i], g ) );
    }
    factors->through = *dense ? 0.0 : factors->through;
    return RF_OK;
}

void rf_gltf_apply_surface( RfGltf* gltf, const json_t* material, const RfMaterialValues* values, RfMaterial* out )
{
    const RfFactors* factors = &values->lobes;
    if ( rf_gltf_is_unlit( material ) || rf_gltf_has_own_model( material ) )
        return;
    rf_derive_layers( factors, out );
    bool mirror = out->kind == RF_BSDF_GLASS && out->ior == 0.0f;
    if ( out->kind == RF_BSDF_GLASS && !mirror )
    {
        if ( rf_max_component( out->sheen ) > 0.0f )
            rf_gltf_notice( gltf, RF_GLTF_SHEEN_ON_GLASS, "sheen over glass is not supported: material '%.80s' is without it",
                            out->name );
        if ( out->anisotropy > 0.0f )
            rf_gltf_notice( gltf, RF_GLTF_LAYERED_GLASS, "anisotropy of glass is not supported: material '%.80s' is isotropic",
                            out->name );
        bool opaque = values->transmission < 1.0 || has_value( material, "KHR_materials_transmission", "transmissionTexture" );
        if ( factors->through > 0.0 && opaque ) // else transmission overrides it
            rf_gltf_notice( gltf, RF_GLTF_TRANSLUCENT_GLASS,
                            "diffuse transmission of glass is not supported: the opaque part of material '%.80s' is without it",
                            out->name );
        out->dispersion = out->thin ? 0.0f : (float)factors->dispersion; // what has no volume does not refract
        if ( out->film > 0.0f || out->dispersion > 0.0f )
            out->kind = RF_BSDF_SPECTRAL;
        return;
    }
    if ( is_translucent( material, factors, out ) )
    {
        make_translucent( gltf, values, out );
        return;
    }
    RfMaterial layered = *out;
    rf_choose_layers( &layered );
    if ( layered.kind == RF_BSDF_GGX || ( out->kind == RF_BSDF_LAMBERT && layered.kind == RF_BSDF_ANISOTROPIC ) )
        return;
    if ( mirror && layered.kind == RF_BSDF_IRIDESCENT )
        layered.kind = RF_BSDF_SPECTRAL;
    else if ( mirror ) // not a perfect one
        rf_derive_lobes( factors, &layered );
    *out = layered;
}
