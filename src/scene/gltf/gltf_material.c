// Materials and their extensions, except for textures.
#include "scene/gltf/gltf_changes.h"
#include "scene/gltf/gltf_materials.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Glass and mirrors: KHR_materials_transmission with _volume, metals without roughness; also
// KHR_materials_unlit.

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

static void make_glass( const RfMaterialValues* in, RfMaterial* out )
{
    const RfFactors* factors = &in->lobes;
    out->kind = RF_BSDF_GLASS;
    // by the extension, an index of 0 means total reflection
    out->ior = factors->ior > 0.0 ? (float)fmax( factors->ior, 1.0001 ) : 1e4f;
    out->thin = in->thickness == 0.0;
    rf_derive_glass( factors, in->transmission, out );
    if ( out->thin )
        return;
    const double *color = in->attenuation_color, distance = in->attenuation_distance;
    out->absorption =
        rf_vec3( absorption( color[0], distance ), absorption( color[1], distance ), absorption( color[2], distance ) );
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

// Applies KHR_materials_transmission, _volume and _unlit, and finds metals without roughness, after all other factors.
// `reshapes`: its roughness or metallic factor change, so that it is no metal or mirror at all times. `dense`: it scatters inside,
// and is taken for opaque.
static void apply_glass( const json_t* material, const RfMaterialValues* values, bool reshapes, bool dense, RfMaterial* out )
{
    const RfFactors* factors = &values->lobes;
    if ( rf_gltf_is_unlit( material ) )
        make_unlit( factors->base, out );
    else if ( values->transmission > 0.0 && !dense && ( reshapes || !is_all_metal( material, factors ) ) )
        make_glass( values, out );
    else if ( !reshapes && factors->metallic == 1.0 && factors->roughness < RF_SMOOTH_ROUGHNESS )
    {
        out->kind = RF_BSDF_GLASS;
        out->alpha = 0.0f;
    }
}

// KHR_materials_clearcoat: a clear coat over the metallic-roughness model.

// The last of the extensions.
static void apply_clearcoat( RfGltf* gltf, const json_t* material, const RfMaterialValues* values, RfMaterial* out )
{
    // unlit materials ignore it
    if ( values->clearcoat == 0.0 || rf_gltf_is_unlit( material ) )
        return;
    if ( out->kind >= RF_BSDF_FIRST_SPECULAR )
    {
        rf_gltf_notice( gltf, RF_GLTF_COATED_GLASS,
                        "a clear coat over glass or a mirror is not supported: material '%.80s' is without it", out->name );
        return;
    }
    if ( out->kind == RF_BSDF_TRANSLUCENT )
    {
        rf_gltf_notice( gltf, RF_GLTF_COATED_TRANSLUCENT,
                        "a clear coat over diffuse transmission is not supported: material '%.80s' is without it", out->name );
        return;
    }
    rf_derive_clearcoat( values->clearcoat, values->clearcoat_roughness, out );
    rf_choose_layers( out );
}

// Materials: glTF's metallic-roughness model as a Lambert base under a GGX lobe, with
// KHR_materials_specular, _ior and _emissive_strength.

static RfMaterialValues default_values( void )
{
    return ( RfMaterialValues ){
        .lobes = { .base = { 1, 1, 1, 1 },
                   .metallic = 1,
                   .roughness = 1,
                   .specular = 1,
                   .specular_color = { 1, 1, 1 },
                   .ior = 1.5,
                   .film_ior = 1.3,
                   .film_least = 100,
                   .film_most = 400,
                   .through_color = { 1, 1, 1 } },
        .strength = 1,
        .attenuation_distance = (double)INFINITY,
        .attenuation_color = { 1, 1, 1 },
        .alpha_cutoff = 0.5,
    };
}

static void apply_factors( const RfMaterialValues* in, bool reshapes, RfMaterial* out )
{
    rf_derive_lobes( &in->lobes, out );
    out->kind = !reshapes && in->lobes.metallic == 0.0 && in->lobes.specular == 0.0 ? RF_BSDF_LAMBERT : RF_BSDF_GGX;
    out->emission = rf_emission_of( in );
}

// Makes values what they are where they stand still, and `most` the most that they are at any time. Returns whether the roughness or
// the metallic factor change.
static bool follow_changes( const RfGltf* gltf, int material, RfMaterialValues* values, RfMaterialValues* most )
{
    bool reshapes = false;
    RfChangedValue v = rf_next_value( RF_OF_MATERIAL, 0 );
    for ( *most = *values; v < RF_CHANGED_COUNT; v = rf_next_value( RF_OF_MATERIAL, (int)v + 1 ) )
    {
        double all[4];
        size_t bytes = (size_t)rf_changed_traits( v )->components * sizeof *all;
        int change = rf_gltf_find_change( gltf, v, material, 0, rf_value_in( values, v ) );
        if ( change >= 0 )
            rf_most_of_change( gltf->changes + change, all );
        memcpy( rf_value_in( most, v ), change >= 0 ? all : rf_value_in( values, v ), bytes );
        reshapes = reshapes || ( change >= 0 && ( v == RF_CHANGED_METALLIC || v == RF_CHANGED_ROUGHNESS ) );
    }
    return reshapes;
}

// Of a copy, those of its original.
static void apply_overrides( const RfGltf* gltf, int material, RfMaterialValues* values )
{
    for ( int i = 0; i < gltf->copy_count; ++i )
        material = gltf->copies[i].to == material ? gltf->copies[i].from : material;
    for ( int i = 0; i < gltf->options->override_count; ++i )
    {
        const RfOverride* from = gltf->options->overrides + i;
        size_t bytes = (size_t)rf_changed_traits( from->value )->components * sizeof *from->numbers;
        if ( from->material == material )
            memcpy( rf_value_in( values, from->value ), from->numbers, bytes );
    }
}

static RfResult load_material( RfGltf* gltf, int index, RfMaterial* out )
{
    RfField field = rf_gltf_item_field( gltf, RF_GLTF_MATERIALS, index );
    const json_t* json = field.json;
    RfMovingMaterial moving = { .material = index, .values = default_values() };
    RfMaterialValues *values = &moving.values, most;
    int tag;
    rf_gltf_copy_name( &field, field.path, &out->name );
    rf_gltf_read_values( gltf, &field, RF_OF_MATERIAL, values );
    apply_overrides( gltf, index, values );
    // by the extension, 0 means total reflection
    if ( values->lobes.ior != 0.0 && values->lobes.ior < 1.0 )
        rf_gltf_fail( gltf, RF_ERROR_FORMAT, rf_where( "%s.extensions.KHR_materials_ior", field.path ).text,
                      "ior is %g, it must be 0, or 1 and above", values->lobes.ior );
    rf_gltf_read_material_extras( &field, &values->lobes, out );
    rf_get_bool( &field, "doubleSided", &out->double_sided );
    RfResult result = rf_gltf_read_light_group( gltf, &field, &tag );
    if ( result != RF_OK )
        return result;
    out->light_group = (uint16_t)( tag > 0 ? tag : 0 );
    rf_gltf_notice_extensions( gltf, &field, "material", out->name );
    bool dense = false, reshapes = follow_changes( gltf, index, values, &most );
    result = rf_gltf_apply_scatter( &field, values, &dense );
    if ( result != RF_OK )
        return result;
    apply_factors( values, reshapes, out );
    out->emission = rf_emission_of( &most );
    apply_glass( json, values, reshapes, dense, out );
    rf_gltf_apply_surface( gltf, json, values, out );
    apply_clearcoat( gltf, json, values, out );
    result = rf_gltf_read_own_model( &field, out );
    if ( result == RF_OK )
        result = rf_gltf_read_textured( gltf, &field, &moving, out );
    return result == RF_OK ? rf_gltf_change_material( gltf, &moving, out ) : result;
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
        RfMaterialValues values = default_values();
        apply_factors( &values, false, material );
        material->textured = rf_gltf_textured( &values.lobes );
        if ( material->textured == NULL )
            return rf_gltf_no_memory( gltf, "materials" );
        material->textured->optional = true; // for primitives with vertex colours
        gltf->default_material = (int)gltf->scene->material_count++;
    }
    *index = (uint32_t)gltf->default_material;
    return RF_OK;
}
