#include "convert/glb_document.h"

#include <stdlib.h>
#include <string.h>

static float emission_strength( const RfModelMaterial* m )
{
    float largest = m->emission[0];
    for ( int i = 1; i < 3; ++i )
        largest = m->emission[i] > largest ? m->emission[i] : largest;
    return largest > 1.0f ? largest : 1.0f;
}

static json_t* one_real( const char* key, float value ) { return json_pack( "{s:f}", key, (double)value ); }

static json_t* material_extensions( RfGlbDocument* d, const RfModelMaterial* m )
{
    json_t* extensions = json_object();
    float strength = emission_strength( m );
    if ( strength > 1.0f )
        rf_glb_set( d, extensions, "KHR_materials_emissive_strength", one_real( "emissiveStrength", strength ) );
    if ( m->specular != 1.0f )
        rf_glb_set( d, extensions, "KHR_materials_specular", one_real( "specularFactor", m->specular ) );
    if ( m->ior != 1.5f )
        rf_glb_set( d, extensions, "KHR_materials_ior", one_real( "ior", m->ior ) );
    if ( m->transmission != 0.0f )
        rf_glb_set( d, extensions, "KHR_materials_transmission", one_real( "transmissionFactor", m->transmission ) );
    return extensions;
}

// Texture i of the file uses image i of the model.
static void set_texture( RfGlbDocument* d, json_t* object, const char* key, int image )
{
    if ( image >= 0 )
        rf_glb_set( d, object, key, json_pack( "{s:i}", "index", image ) );
}

json_t* rf_glb_material( RfGlbDocument* d, const RfModelMaterial* m )
{
    json_t* material = json_object();
    if ( m->name != NULL )
        rf_glb_set( d, material, "name", rf_glb_name( m->name ) );
    json_t* pbr = json_object();
    rf_glb_set( d, pbr, "baseColorFactor", rf_glb_reals( m->base_color, 4 ) );
    rf_glb_set( d, pbr, "metallicFactor", json_real( (double)m->metallic ) );
    rf_glb_set( d, pbr, "roughnessFactor", json_real( (double)m->roughness ) );
    set_texture( d, pbr, "baseColorTexture", m->base_color_image );
    rf_glb_set( d, material, "pbrMetallicRoughness", pbr );
    set_texture( d, material, "normalTexture", m->normal_image );
    set_texture( d, material, "emissiveTexture", m->emissive_image );
    float strength = emission_strength( m ), factor[3];
    for ( int i = 0; i < 3; ++i )
        factor[i] = m->emission[i] / strength;
    if ( factor[0] > 0.0f || factor[1] > 0.0f || factor[2] > 0.0f )
        rf_glb_set( d, material, "emissiveFactor", rf_glb_reals( factor, 3 ) );
    if ( m->alpha_mode != RF_MODEL_OPAQUE )
        rf_glb_set( d, material, "alphaMode", json_string( m->alpha_mode == RF_MODEL_MASK ? "MASK" : "BLEND" ) );
    if ( m->alpha_mode == RF_MODEL_MASK )
        rf_glb_set( d, material, "alphaCutoff", json_real( (double)m->alpha_cutoff ) );
    if ( m->double_sided )
        rf_glb_set( d, material, "doubleSided", json_true() );
    json_t* extensions = material_extensions( d, m );
    if ( json_object_size( extensions ) > 0 )
        rf_glb_set( d, material, "extensions", extensions );
    else
        json_decref( extensions );
    return material;
}

json_t* rf_glb_extensions( RfGlbDocument* d )
{
    const RfModel* model = d->model;
    bool strength = false, specular = false, ior = false, transmission = false;
    for ( int i = 0; i < model->material_count; ++i )
    {
        const RfModelMaterial* m = model->materials + i;
        strength = strength || emission_strength( m ) > 1.0f;
        specular = specular || m->specular != 1.0f;
        ior = ior || m->ior != 1.5f;
        transmission = transmission || m->transmission != 0.0f;
    }
    const struct
    {
        bool used;
        const char* name;
    } all[] = {
        { strength, "KHR_materials_emissive_strength" },
        { specular, "KHR_materials_specular" },
        { ior, "KHR_materials_ior" },
        { transmission, "KHR_materials_transmission" },
        { model->light_count > 0, "KHR_lights_punctual" },
    };
    json_t* names = json_array();
    for ( size_t i = 0; i < sizeof all / sizeof all[0]; ++i )
    {
        if ( all[i].used )
            rf_glb_append( d, names, json_string( all[i].name ) );
    }
    if ( json_array_size( names ) > 0 )
        return names;
    json_decref( names );
    return NULL;
}
