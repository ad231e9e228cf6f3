// Extensions of materials that lay something over the metallic-roughness model or change its lobes, except for clear coats,
// glass and textures. One function per extension reads its factors; rf_gltf_apply_surface decides what they do to the material.
#include "scene/gltf/gltf_materials.h"

#include <math.h>

// The object of an extension in a material, NULL without one, and its place for messages.
static RfResult find( const RfGltf* gltf, const json_t* material, const char* owner, const char* extension, const json_t** json,
                      RfWhere* where )
{
    *where = rf_where( "%s.extensions.%s", owner, extension );
    return rf_gltf_get_extension( gltf, material, owner, extension, json );
}

static RfResult read_sheen( const RfGltf* gltf, const json_t* material, const char* owner, RfFactors* out )
{
    const json_t* json;
    RfWhere where;
    RfResult result = find( gltf, material, owner, "KHR_materials_sheen", &json, &where );
    if ( result != RF_OK || json == NULL )
        return result;
    result = rf_gltf_get_shares( gltf, json, where.text, "sheenColorFactor", 3, out->sheen_color );
    return result == RF_OK ? rf_gltf_get_shares( gltf, json, where.text, "sheenRoughnessFactor", 1, &out->sheen_roughness )
                           : result;
}

static RfResult read_anisotropy( const RfGltf* gltf, const json_t* material, const char* owner, RfFactors* out )
{
    const json_t* json;
    RfWhere where;
    RfResult result = find( gltf, material, owner, "KHR_materials_anisotropy", &json, &where );
    if ( result != RF_OK || json == NULL )
        return result;
    result = rf_gltf_get_shares( gltf, json, where.text, "anisotropyStrength", 1, &out->anisotropy );
    if ( result == RF_OK )
        result = rf_gltf_get_number( gltf, json, where.text, "anisotropyRotation", &out->anisotropy_rotation );
    return result == RF_OK ? rf_gltf_check_limit( gltf, where.text, "anisotropyRotation", out->anisotropy_rotation, 1e6 )
                           : result;
}

#define MAX_FILM 1e5 // nm

static RfResult read_thickness( const RfGltf* gltf, const json_t* json, const char* where, const char* key, double* out )
{
    RfResult result = rf_gltf_get_number( gltf, json, where, key, out );
    if ( result == RF_OK && !( *out >= 0.0 && *out <= MAX_FILM ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s is %g, it must be 0 to %g nanometres", key, *out, MAX_FILM );
    return result;
}

static RfResult read_iridescence( const RfGltf* gltf, const json_t* material, const char* owner, RfFactors* out )
{
    const json_t* json;
    RfWhere where;
    RfResult result = find( gltf, material, owner, "KHR_materials_iridescence", &json, &where );
    if ( result != RF_OK || json == NULL )
        return result;
    result = rf_gltf_get_shares( gltf, json, where.text, "iridescenceFactor", 1, &out->film );
    if ( result == RF_OK )
        result = rf_gltf_get_number( gltf, json, where.text, "iridescenceIor", &out->film_ior );
    if ( result == RF_OK && !( out->film_ior >= 1.0 && out->film_ior <= 100.0 ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "iridescenceIor is %g, it must be 1 to 100", out->film_ior );
    if ( result == RF_OK )
        result = read_thickness( gltf, json, where.text, "iridescenceThicknessMinimum", &out->film_least );
    return result == RF_OK ? read_thickness( gltf, json, where.text, "iridescenceThicknessMaximum", &out->film_most ) : result;
}

static RfResult read_through( const RfGltf* gltf, const json_t* material, const char* owner, RfFactors* out )
{
    const json_t* json;
    RfWhere where;
    RfResult result = find( gltf, material, owner, "KHR_materials_diffuse_transmission", &json, &where );
    if ( result != RF_OK || json == NULL )
        return result;
    result = rf_gltf_get_shares( gltf, json, where.text, "diffuseTransmissionFactor", 1, &out->through );
    return result == RF_OK ? rf_gltf_get_shares( gltf, json, where.text, "diffuseTransmissionColorFactor", 3, out->through_color )
                           : result;
}

static RfResult read_dispersion( const RfGltf* gltf, const json_t* material, const char* owner, RfFactors* out )
{
    const json_t* json;
    RfWhere where;
    RfResult result = find( gltf, material, owner, "KHR_materials_dispersion", &json, &where );
    if ( result == RF_OK && json != NULL )
        result = rf_gltf_get_number( gltf, json, where.text, "dispersion", &out->dispersion );
    if ( result == RF_OK && !( out->dispersion >= 0.0 ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "dispersion is %g, it must be 0 or more", out->dispersion );
    return result == RF_OK ? rf_gltf_check_limit( gltf, where.text, "dispersion", out->dispersion, 1e6 ) : result;
}

RfResult rf_gltf_read_surface( const RfGltf* gltf, const json_t* material, const char* where, RfFactors* out )
{
    RfResult result = read_sheen( gltf, material, where, out );
    if ( result == RF_OK )
        result = read_anisotropy( gltf, material, where, out );
    if ( result == RF_OK )
        result = read_iridescence( gltf, material, where, out );
    if ( result == RF_OK )
        result = read_through( gltf, material, where, out );
    if ( result == RF_OK )
        result = read_dispersion( gltf, material, where, out );
    return result;
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
static RfResult read_extinction( const RfGltf* gltf, const json_t* material, const char* owner, double* least )
{
    const json_t* json;
    RfWhere where;
    double distance = 0.0, color[3] = { 1, 1, 1 };
    RfResult result = find( gltf, material, owner, "KHR_materials_volume", &json, &where );
    *least = 0.0;
    if ( result != RF_OK || json == NULL )
        return result;
    result = rf_gltf_get_number( gltf, json, where.text, "attenuationDistance", &distance );
    if ( result == RF_OK )
        result = rf_gltf_get_shares( gltf, json, where.text, "attenuationColor", 3, color );
    if ( result == RF_OK && distance > 0.0 )
        *least = -log( fmax( fmax( color[0], fmax( color[1], color[2] ) ), 1e-6 ) ) / distance;
    return result;
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

RfResult rf_gltf_read_scatter( const RfGltf* gltf, const json_t* material, const char* owner, RfFactors* factors, bool* dense )
{
    const json_t* json;
    RfWhere where;
    double color[3] = { 0 }, g = 0.0, extinction = 0.0;
    *dense = false;
    RfResult result = find( gltf, material, owner, "KHR_materials_volume_scatter", &json, &where );
    if ( result != RF_OK || json == NULL )
        return result;
    result = rf_gltf_get_shares( gltf, json, where.text, "multiscatterColor", 3, color );
    if ( result == RF_OK )
        result = rf_gltf_get_number( gltf, json, where.text, "scatterAnisotropy", &g );
    if ( result == RF_OK && !( g > -1.0 && g < 1.0 ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "scatterAnisotropy is %g, it must be between -1 and 1", g );
    if ( result == RF_OK )
        result = read_extinction( gltf, material, owner, &extinction );
    if ( result != RF_OK || factors->metallic > 0.0 || rf_gltf_is_unlit( material ) || rf_gltf_has_own_model( material ) )
        return result;
    // by the extension, diffuse transmission says that a body is dense
    double clear = number_of( material, "KHR_materials_transmission", "transmissionFactor" );
    double depth = extinction * number_of( material, "KHR_materials_volume", "thicknessFactor" );
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
