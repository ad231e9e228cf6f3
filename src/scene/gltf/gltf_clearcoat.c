// KHR_materials_clearcoat: a clear coat over the metallic-roughness model.

#include "scene/gltf/gltf_materials.h"

RfResult rf_gltf_read_clearcoat( RfGltf* gltf, const json_t* material, const char* owner, RfMaterial* out )
{
    double factor = 0.0, roughness = 0.0;
    const json_t* json;
    RfResult result = rf_gltf_get_extension( gltf, material, owner, "KHR_materials_clearcoat", &json );
    if ( result != RF_OK || json == NULL )
        return result;
    RfWhere where = rf_where( "%s.extensions.KHR_materials_clearcoat", owner );
    result = rf_gltf_get_number( gltf, json, where.text, "clearcoatFactor", &factor );
    if ( result == RF_OK )
        result = rf_gltf_get_number( gltf, json, where.text, "clearcoatRoughnessFactor", &roughness );
    if ( result != RF_OK )
        return result;
    if ( !( factor >= 0.0 && factor <= 1.0 && roughness >= 0.0 && roughness <= 1.0 ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "factors %g and %g want 0 to 1", factor, roughness );
    // unlit materials ignore it
    if ( factor == 0.0 || rf_gltf_is_unlit( material ) )
        return RF_OK;
    if ( out->kind == RF_BSDF_GLASS )
    {
        rf_gltf_notice( gltf, RF_GLTF_COATED_GLASS,
                        "a clear coat over glass or a mirror is not supported: material '%.80s' is without it", out->name );
        return RF_OK;
    }
    out->kind = RF_BSDF_COATED;
    rf_derive_clearcoat( factor, roughness, out );
    return RF_OK;
}
