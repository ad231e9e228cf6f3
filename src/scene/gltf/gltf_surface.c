// Extensions of materials that lay something over the metallic-roughness model or change its lobes, except for clear coats,
// glass and textures. One function per extension reads its factors; rf_gltf_apply_surface decides what they do to the material.
#include "scene/gltf/gltf_materials.h"

#include <math.h>

static const RfRange s_share = { 0.0, 1.0, false };

static void read_sheen( const RfField* material, RfFactors* out )
{
    RfField json = rf_gltf_extension( material, "KHR_materials_sheen" );
    rf_get_numbers( &json, "sheenColorFactor", s_share, 3, out->sheen_color );
    rf_get_number( &json, "sheenRoughnessFactor", s_share, &out->sheen_roughness );
}

static void read_anisotropy( const RfGltf* gltf, const RfField* material, RfFactors* out )
{
    RfField json = rf_gltf_extension( material, "KHR_materials_anisotropy" );
    rf_get_number( &json, "anisotropyStrength", s_share, &out->anisotropy );
    rf_get_number( &json, "anisotropyRotation", rf_any_number(), &out->anisotropy_rotation );
    rf_gltf_check_limit( gltf, json.path, "anisotropyRotation", out->anisotropy_rotation, 1e6 );
}

#define MAX_FILM 1e5 // nm

static void read_iridescence( const RfField* material, RfFactors* out )
{
    RfField json = rf_gltf_extension( material, "KHR_materials_iridescence" );
    rf_get_number( &json, "iridescenceFactor", s_share, &out->film );
    rf_get_number( &json, "iridescenceIor", rf_range( 1.0, 100.0 ), &out->film_ior );
    rf_get_number( &json, "iridescenceThicknessMinimum", rf_range( 0.0, MAX_FILM ), &out->film_least );
    rf_get_number( &json, "iridescenceThicknessMaximum", rf_range( 0.0, MAX_FILM ), &out->film_most );
}

static void read_through( const RfField* material, RfFactors* out )
{
    RfField json = rf_gltf_extension( material, "KHR_materials_diffuse_transmission" );
    rf_get_number( &json, "diffuseTransmissionFactor", s_share, &out->through );
    rf_get_numbers( &json, "diffuseTransmissionColorFactor", s_share, 3, out->through_color );
}

static void read_dispersion( const RfGltf* gltf, const RfField* material, RfFactors* out )
{
    RfField json = rf_gltf_extension( material, "KHR_materials_dispersion" );
    rf_get_number( &json, "dispersion", rf_range( 0.0, HUGE_VAL ), &out->dispersion );
    rf_gltf_check_limit( gltf, json.path, "dispersion", out->dispersion, 1e6 );
}

RfResult rf_gltf_read_surface( const RfGltf* gltf, const RfField* material, RfFactors* out )
{
    read_sheen( material, out );
    read_anisotropy( gltf, material, out );
    read_iridescence( material, out );
    read_through( material, out );
    read_dispersion( gltf, material, out );
    return rf_json_result( material );
}

static double number_of( const json_t* material, const char* extension, const char* key )
{
    const json_t* object = json_object_get( json_object_get( material, "extensions" ), extension );
    return json_number_value( json_object_get( object, key ) );
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
static void make_translucent( RfGltf* gltf, const json_t* material, RfMaterial* out )
{
    RfMaterial layered = *out;
    rf_choose_layers( &layered );
    if ( layered.kind != RF_BSDF_GGX )
        rf_gltf_notice( gltf, RF_GLTF_LAYERED_TRANSLUCENT,
                        "sheen, anisotropy and films on a surface with diffuse transmission are not supported: material '%.80s' "
                        "is without them",
                        out->name );
    if ( number_of( material, "KHR_materials_volume", "thicknessFactor" ) > 0.0 &&
         has_value( material, "KHR_materials_volume", "attenuationDistance" ) )
        rf_gltf_notice( gltf, RF_GLTF_TRANSLUCENT_BODY,
                        "absorption inside a body with diffuse transmission is not supported: material '%.80s' is clear inside",
                        out->name );
    out->kind = RF_BSDF_TRANSLUCENT;
}

// The least extinction of the channels, 1/m: what KHR_materials_volume calls attenuation. 0 without any.
static double read_extinction( const RfField* material )
{
    double distance = 0.0, color[3] = { 1, 1, 1 };
    RfField json = rf_gltf_extension( material, "KHR_materials_volume" );
    rf_get_number( &json, "attenuationDistance", rf_any_number(), &distance );
    rf_get_numbers( &json, "attenuationColor", s_share, 3, color );
    return distance > 0.0 ? -log( fmax( fmax( color[0], fmax( color[1], color[2] ) ), 1e-6 ) ) / distance : 0.0;
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

RfResult rf_gltf_read_scatter( const RfGltf* gltf, const RfField* material, RfFactors* factors, bool* dense )
{
    double color[3] = { 0 }, g = 0.0;
    *dense = false;
    RfField json = rf_gltf_extension( material, "KHR_materials_volume_scatter" );
    if ( json.json == NULL )
        return rf_json_result( material );
    rf_get_numbers( &json, "multiscatterColor", s_share, 3, color );
    RfResult result = rf_get_number( &json, "scatterAnisotropy", rf_any_number(), &g );
    if ( result == RF_OK && !( g > -1.0 && g < 1.0 ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, json.path, "scatterAnisotropy is %g, it must be between -1 and 1", g );
    double extinction = read_extinction( material );
    result = rf_json_result( material );
    if ( result != RF_OK || factors->metallic > 0.0 || rf_gltf_is_unlit( material->json ) ||
         rf_gltf_has_own_model( material->json ) )
        return result;
    // by the extension, diffuse transmission says that a body is dense
    double clear = number_of( material->json, "KHR_materials_transmission", "transmissionFactor" );
    double depth = extinction * number_of( material->json, "KHR_materials_volume", "thicknessFactor" );
    *dense = clear > 0.0 ? depth >= 1.0 : factors->through > 0.0 && extinction > 0.0;
    for ( int i = 0; i < 3 && *dense; ++i )
    {
        double through = clear > 0.0 ? clear * factors->base[i] : factors->through * factors->through_color[i];
        double left = 1.0 - ( clear > 0.0 ? clear : factors->through );
        factors->base[i] = reflected( left * factors->base[i], through, albedo_of_half_space( color[i], g ) );
    }
    factors->through = *dense ? 0.0 : factors->through;
    return RF_OK;
}

void rf_gltf_apply_surface( RfGltf* gltf, const json_t* material, const RfFactors* factors, RfMaterial* out )
{
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
        bool opaque = number_of( material, "KHR_materials_transmission", "transmissionFactor" ) < 1.0 ||
                      has_value( material, "KHR_materials_transmission", "transmissionTexture" );
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
        make_translucent( gltf, material, out );
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
