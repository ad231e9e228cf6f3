// Glass and mirrors: KHR_materials_transmission with _volume, metals without roughness; also
// KHR_materials_unlit.

#include "scene/gltf/gltf_materials.h"

#include <math.h>

typedef struct Inside
{
    double transmission;
    double thickness; // 0: thin-walled
    double distance;  // at which light is attenuated to attenuation_color
    double color[3];
} Inside;

static RfResult read_transmission( const RfGltf* gltf, const json_t* material, const char* owner, Inside* out )
{
    const json_t* json;
    RfResult result = rf_gltf_get_extension( gltf, material, owner, "KHR_materials_transmission", &json );
    if ( result != RF_OK || json == NULL )
        return result;
    RfWhere where = rf_where( "%s.extensions.KHR_materials_transmission", owner );
    result = rf_gltf_get_number( gltf, json, where.text, "transmissionFactor", &out->transmission );
    if ( result == RF_OK && !( out->transmission >= 0.0 && out->transmission <= 1.0 ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "transmissionFactor is %g, it wants 0 to 1", out->transmission );
    return result;
}

static RfResult read_volume( const RfGltf* gltf, const json_t* material, const char* owner, Inside* out )
{
    const json_t* json;
    RfResult result = rf_gltf_get_extension( gltf, material, owner, "KHR_materials_volume", &json );
    if ( result != RF_OK || json == NULL )
        return result;
    RfWhere where = rf_where( "%s.extensions.KHR_materials_volume", owner );
    result = rf_gltf_get_number( gltf, json, where.text, "thicknessFactor", &out->thickness );
    if ( result == RF_OK )
        result = rf_gltf_get_number( gltf, json, where.text, "attenuationDistance", &out->distance );
    if ( result == RF_OK )
        result = rf_gltf_get_numbers( gltf, json, where.text, "attenuationColor", 3, out->color );
    if ( result != RF_OK )
        return result;
    if ( !( out->thickness >= 0.0 ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "thicknessFactor is %g, it wants 0 or more", out->thickness );
    if ( !( out->distance > 0.0 ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "attenuationDistance is %g, it wants more than 0",
                             out->distance );
    for ( int i = 0; i < 3; ++i )
    {
        if ( !( out->color[i] >= 0.0 && out->color[i] <= 1.0 ) )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "attenuationColor is %g, it wants 0 to 1", out->color[i] );
    }
    return RF_OK;
}

// −ln(colour) / distance; a channel of 0 is fully absorbed.
static float absorption( double color, double distance )
{
    double a = -log( fmax( color, 1e-6 ) ) / distance;
    return isfinite( a ) ? (float)fmin( a, 1e6 ) : 0.0f;
}

static RfVec3 scaled( const double rgb[3], double s )
{
    return rf_vec3( (float)( rgb[0] * s ), (float)( rgb[1] * s ), (float)( rgb[2] * s ) );
}

static void make_glass( const Inside* in, const RfFactors* factors, RfMaterial* out )
{
    out->kind = RF_BSDF_GLASS;
    // by the extension, an index of 0 means total reflection
    out->ior = factors->ior > 0.0 ? (float)fmax( factors->ior, 1.0001 ) : 1e4f;
    out->thin = in->thickness == 0.0;
    rf_derive_glass( factors, in->transmission, out );
    if ( out->thin )
        return;
    out->absorption = rf_vec3( absorption( in->color[0], in->distance ), absorption( in->color[1], in->distance ),
                               absorption( in->color[2], in->distance ) );
}

bool rf_gltf_is_unlit( const json_t* material )
{
    return json_object_get( json_object_get( material, "extensions" ), "KHR_materials_unlit" ) != NULL;
}

// A surface that looks the same in any light: emission of its base colour.
static void make_unlit( const double base[3], RfMaterial* out )
{
    out->kind = RF_BSDF_LAMBERT;
    out->diffuse = rf_vec3( 0.0f, 0.0f, 0.0f );
    out->emission = scaled( base, 1.0 );
}

// True for a metal by its factors, unless a texture varies it.
static bool is_all_metal( const json_t* material, const RfFactors* factors )
{
    const json_t* part = json_object_get( material, "pbrMetallicRoughness" );
    return factors->metallic == 1.0 && json_object_get( part, "metallicRoughnessTexture" ) == NULL;
}

RfResult rf_gltf_read_glass( const RfGltf* gltf, const json_t* material, const char* where, const RfFactors* factors,
                             RfMaterial* out )
{
    Inside inside = { .distance = (double)INFINITY, .color = { 1, 1, 1 } };
    RfResult result = read_transmission( gltf, material, where, &inside );
    if ( result == RF_OK )
        result = read_volume( gltf, material, where, &inside );
    if ( result != RF_OK )
        return result;
    if ( rf_gltf_is_unlit( material ) )
        make_unlit( factors->base, out );
    else if ( inside.transmission > 0.0 && !is_all_metal( material, factors ) )
        make_glass( &inside, factors, out );
    else if ( factors->metallic == 1.0 && factors->roughness < RF_SMOOTH_ROUGHNESS )
    {
        out->kind = RF_BSDF_GLASS;
        out->alpha = 0.0f;
    }
    return RF_OK;
}
