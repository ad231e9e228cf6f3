// What makes a material vary over its surface: textures, vertex colours and alpha.

#include "scene/gltf/gltf_materials.h"

#include <stdlib.h>
#include <string.h>

RfTextured* rf_gltf_textured( const RfFactors* factors )
{
    RfTextured* textured = calloc( 1, sizeof *textured );
    if ( textured == NULL )
        return NULL;
    textured->factors = *factors;
    textured->normal_scale = textured->clearcoat_normal_scale = 1.0f;
    for ( int i = 0; i < RF_TEXTURE_SLOT_COUNT; ++i )
        textured->refs[i] = ( RfTextureRef ){ .texture = -1, .transform = { 1, 0, 0, 0, 1, 0 } };
    return textured;
}

static RfResult read_scale( const RfGltf* gltf, const json_t* info, const char* where, float* scale )
{
    double value = 1.0;
    RfResult result = rf_gltf_get_number( gltf, info, where, "scale", &value );
    *scale = (float)value;
    return result;
}

static RfResult read_slots( RfGltf* gltf, const json_t* material, const char* where, RfTextured* out )
{
    static const struct
    {
        const char *part, *extension, *key;
        RfTextureSlot slot;
        bool srgb;
    } s_slots[] = {
        { "pbrMetallicRoughness", NULL, "baseColorTexture", RF_TEXTURE_BASE, true },
        { "pbrMetallicRoughness", NULL, "metallicRoughnessTexture", RF_TEXTURE_METALLIC_ROUGHNESS, false },
        { NULL, NULL, "normalTexture", RF_TEXTURE_NORMAL, false },
        { NULL, NULL, "emissiveTexture", RF_TEXTURE_EMISSIVE, true },
        { NULL, "KHR_materials_specular", "specularTexture", RF_TEXTURE_SPECULAR, false },
        { NULL, "KHR_materials_specular", "specularColorTexture", RF_TEXTURE_SPECULAR_COLOR, true },
        { NULL, "KHR_materials_transmission", "transmissionTexture", RF_TEXTURE_TRANSMISSION, false },
        { NULL, "KHR_materials_clearcoat", "clearcoatTexture", RF_TEXTURE_CLEARCOAT, false },
        { NULL, "KHR_materials_clearcoat", "clearcoatRoughnessTexture", RF_TEXTURE_CLEARCOAT_ROUGHNESS, false },
        { NULL, "KHR_materials_clearcoat", "clearcoatNormalTexture", RF_TEXTURE_CLEARCOAT_NORMAL, false },
    };
    for ( size_t i = 0; i < sizeof s_slots / sizeof s_slots[0]; ++i )
    {
        const json_t* parent = material;
        const json_t* info;
        RfWhere owner = rf_where( "%s", where );
        if ( s_slots[i].part != NULL )
        {
            parent = json_object_get( material, s_slots[i].part );
            owner = rf_where( "%s.%s", where, s_slots[i].part );
        }
        if ( s_slots[i].extension != NULL )
        {
            parent = json_object_get( json_object_get( material, "extensions" ), s_slots[i].extension );
            owner = rf_where( "%s.extensions.%s", where, s_slots[i].extension );
        }
        if ( parent == NULL )
            continue;
        RfResult result = rf_gltf_read_texture_info( gltf, parent, owner.text, s_slots[i].key, s_slots[i].srgb,
                                                     out->refs + s_slots[i].slot, &info );
        float* scale = s_slots[i].slot == RF_TEXTURE_NORMAL             ? &out->normal_scale
                       : s_slots[i].slot == RF_TEXTURE_CLEARCOAT_NORMAL ? &out->clearcoat_normal_scale
                                                                        : NULL;
        if ( result == RF_OK && info != NULL && scale != NULL )
            result = read_scale( gltf, info, rf_where( "%s.%s", owner.text, s_slots[i].key ).text, scale );
        if ( result != RF_OK )
            return result;
    }
    return RF_OK;
}

// The thickness texture is for rasterisers. It is validated but otherwise ignored: a ray
// tracer finds the thickness itself.
static RfResult check_thickness( RfGltf* gltf, const json_t* material, const char* where )
{
    const json_t *json, *info;
    RfTextureRef unused;
    RfResult result = rf_gltf_get_extension( gltf, material, where, "KHR_materials_volume", &json );
    if ( result != RF_OK || json == NULL )
        return result;
    RfWhere owner = rf_where( "%s.extensions.KHR_materials_volume", where );
    return rf_gltf_read_texture_info( gltf, json, owner.text, "thicknessTexture", false, &unused, &info );
}

// Drops textures of features that the material turned out not to have.
static void drop_unused( const RfMaterial* material, RfTextured* textured )
{
    if ( textured->model != RF_TEXTURED_GLASS || material->ior == 0.0f )
        textured->refs[RF_TEXTURE_TRANSMISSION].texture = -1;
    for ( int slot = RF_TEXTURE_CLEARCOAT; material->kind != RF_BSDF_COATED && slot <= RF_TEXTURE_CLEARCOAT_NORMAL; ++slot )
        textured->refs[slot].texture = -1;
}

static RfResult read_alpha( RfGltf* gltf, const json_t* material, const char* where, RfTextured* out )
{
    const char* mode = "OPAQUE";
    double cutoff = 0.5;
    RfResult result = rf_gltf_get_string( gltf, material, where, "alphaMode", &mode );
    if ( result == RF_OK )
        result = rf_gltf_get_number( gltf, material, where, "alphaCutoff", &cutoff );
    if ( result != RF_OK || strcmp( mode, "OPAQUE" ) == 0 )
        return result;
    bool blend = strcmp( mode, "BLEND" ) == 0;
    if ( !blend && strcmp( mode, "MASK" ) != 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "alphaMode '%.20s' wants OPAQUE, MASK or BLEND", mode );
    if ( !( cutoff >= 0.0 && cutoff <= 1e6 ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "alphaCutoff is %g, it wants 0 or more", cutoff );
    out->masked = !blend;
    out->blended = blend;
    out->alpha_cutoff = (float)cutoff;
    return RF_OK;
}

static RfTexturedModel find_model( const RfMaterial* material, const json_t* json )
{
    if ( rf_gltf_has_own_model( json ) )
        return RF_TEXTURED_DIFFUSE;
    if ( rf_gltf_is_unlit( json ) )
        return RF_TEXTURED_UNLIT;
    return material->kind == RF_BSDF_GLASS ? RF_TEXTURED_GLASS : RF_TEXTURED_COATED;
}

// A factor of an extension, already validated by the extension's reader; 0 if missing.
static double factor_of( const json_t* json, const char* extension, const char* key )
{
    const json_t* object = json_object_get( json_object_get( json, "extensions" ), extension );
    return json_number_value( json_object_get( object, key ) );
}

// A metal that is a perfect mirror by its factors is not one if a texture sets its roughness.
static void undo_mirror( const RfTextured* textured, RfMaterial* out )
{
    if ( out->kind == RF_BSDF_GLASS && out->ior == 0.0f && textured->refs[RF_TEXTURE_METALLIC_ROUGHNESS].texture >= 0 )
    {
        rf_derive_lobes( &textured->factors, out );
        out->kind = RF_BSDF_GGX;
    }
}

// True if anything varies or depends on alpha.
static bool is_needed( const RfTextured* textured )
{
    for ( int i = 0; i < RF_TEXTURE_SLOT_COUNT; ++i )
    {
        if ( textured->refs[i].texture >= 0 )
            return true;
    }
    double alpha = textured->factors.base[3];
    return ( textured->masked && alpha < (double)textured->alpha_cutoff ) || ( textured->blended && alpha < 1.0 );
}

RfResult rf_gltf_read_textured( RfGltf* gltf, const json_t* json, const char* where, const RfFactors* factors, RfMaterial* out )
{
    out->textured = rf_gltf_textured( factors );
    if ( out->textured == NULL )
        return rf_gltf_no_memory( gltf, where );
    RfTextured* textured = out->textured;
    RfResult result = read_slots( gltf, json, where, textured );
    if ( result == RF_OK )
        result = check_thickness( gltf, json, where );
    if ( result == RF_OK )
        result = read_alpha( gltf, json, where, textured );
    if ( result != RF_OK )
        return result;
    undo_mirror( textured, out );
    textured->model = find_model( out, json );
    // our own models vary their own diffuse reflectance
    if ( textured->model == RF_TEXTURED_DIFFUSE )
        textured->factors.base[0] = textured->factors.base[1] = textured->factors.base[2] = 1.0;
    textured->transmission = factor_of( json, "KHR_materials_transmission", "transmissionFactor" );
    textured->clearcoat = factor_of( json, "KHR_materials_clearcoat", "clearcoatFactor" );
    textured->clearcoat_roughness = factor_of( json, "KHR_materials_clearcoat", "clearcoatRoughnessFactor" );
    drop_unused( out, textured );
    textured->optional = !is_needed( textured );
    return RF_OK;
}
