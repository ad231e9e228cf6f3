// `extras.reframe` of a material: scattering models that glTF lacks.
//
//     {"bsdf": "phong", "diffuse": [r, g, b], "specular": [r, g, b], "exponent": 60}
//     {"bsdf": "lambert", "diffuse": [r, g, b]}
//     {"bsdf": "mirror", "specular": [r, g, b]}
//     {"bsdf": "glass", "ior": 1.5}
//     {"coat": "added"}: glTF's own model, with a coat that takes nothing from the base, as in Blender's Principled
//
// and beside either or alone {"pass_index": 3}, for compositors, and {"light_group": "key"}, of what it emits.
#include "scene/gltf/gltf_materials.h"
#include "scene/surfaces.h"

#include <string.h>

#define BESIDE "pass_index", "light_group"

// A model, its keys and its alpha. A reflectance is required where there is a key for it.
typedef struct Model
{
    const char* name;
    const char* keys[7];
    RfBsdfKind kind;
    float alpha;
} Model;

static const Model s_models[] = {
    { "phong", { "bsdf", "diffuse", "specular", "exponent", BESIDE, NULL }, RF_BSDF_PHONG, 1.0f },
    { "lambert", { "bsdf", "diffuse", BESIDE, NULL }, RF_BSDF_LAMBERT, 1.0f },
    { "mirror", { "bsdf", "specular", BESIDE, NULL }, RF_BSDF_GLASS, 0.0f },
    { "glass", { "bsdf", "ior", BESIDE, NULL }, RF_BSDF_GLASS, 0.0f }, // solid, smooth and clear
};

static bool is_one_of( const char* key, const char* const* keys )
{
    while ( *keys != NULL && strcmp( key, *keys ) != 0 )
        ++keys;
    return *keys != NULL;
}

static bool has_only( const json_t* own, const char* const* keys )
{
    const char* key;
    json_t* value;
    bool all = true;
    json_object_foreach( (json_t*)own, key, value ) all = all && is_one_of( key, keys );
    return all;
}

// Is the scattering model glTF's? `coat` says how its layers are joined.
static bool keeps_model( const json_t* own )
{
    static const char* const s_beside[] = { BESIDE, NULL };
    return ( json_object_size( own ) > 0 && has_only( own, s_beside ) ) ||
           ( json_object_get( own, "bsdf" ) == NULL && json_object_get( own, "coat" ) != NULL );
}

bool rf_gltf_has_own_model( const json_t* material )
{
    const json_t* own = json_object_get( json_object_get( material, "extras" ), "reframe" );
    return own != NULL && !keeps_model( own );
}

void rf_gltf_read_material_extras( const RfField* material, RfFactors* factors, RfMaterial* out )
{
    static const char* const s_keys[] = { "coat", BESIDE, NULL };
    RfField own = rf_gltf_extras( material );
    const char* coat = json_string_value( json_object_get( own.json, "coat" ) );
    int64_t index = 0;
    if ( keeps_model( own.json ) && rf_has_member( &own, "coat" ) )
    {
        if ( !has_only( own.json, s_keys ) || coat == NULL || strcmp( coat, "added" ) != 0 )
            rf_field_fail( &own, "must have coat \"added\" and nothing else, or a bsdf" );
        factors->coat_is_added = true;
    }
    own.gltf = true;
    rf_get_integer( &own, "pass_index", 0, RF_MOST_PASS_INDEX, &index );
    out->pass_index = (unsigned int)index & RF_MOST_PASS_INDEX;
}

static void read_reflectance( const RfField* own, const Model* model, const char* key, RfVec3* out )
{
    double rgb[3] = { 0 };
    if ( is_one_of( key, model->keys ) )
        rf_field_require( own, key, "three numbers from 0 to 1" );
    rf_get_numbers( own, key, rf_range( 0.0, 1.0 ), 3, rgb );
    *out = rf_vec3( (float)rgb[0], (float)rgb[1], (float)rgb[2] );
}

RfResult rf_gltf_read_own_model( const RfField* material, RfMaterial* out )
{
    RfField own = rf_gltf_extras( material );
    const char* bsdf = json_string_value( json_object_get( own.json, "bsdf" ) );
    const Model *model = s_models, *end = s_models + sizeof s_models / sizeof s_models[0];
    double exponent = 0.0, ior = 1.5;
    if ( own.json == NULL || keeps_model( own.json ) )
        return rf_json_result( material );
    while ( bsdf != NULL && model < end && strcmp( bsdf, model->name ) != 0 )
        ++model;
    if ( bsdf == NULL || model == end )
        return rf_field_fail( &own, "must be an object with bsdf \"lambert\", \"phong\", \"mirror\" or \"glass\"" );
    rf_field_keys( &own, model->keys );
    read_reflectance( &own, model, "diffuse", &out->diffuse );
    read_reflectance( &own, model, "specular", &out->specular );
    if ( model->kind == RF_BSDF_PHONG )
        rf_field_require( &own, "exponent", "a number from 0 to 1000000" );
    rf_get_number( &own, "exponent", rf_range( 0.0, 1e6 ), &exponent );
    rf_get_number( &own, "ior", rf_above( 1.0, 10.0 ), &ior );
    // the rounding of decimal fractions that sum to one does not violate energy conservation
    if ( rf_max_component( rf_add( out->diffuse, out->specular ) ) > 1.0f + 1e-6f )
        return rf_field_fail( &own, "diffuse + specular reflect more light than arrives: lower their sum to 1 or less" );
    bool clear = is_one_of( "ior", model->keys );
    float through = clear ? 1.0f : 0.0f;
    out->kind = model->kind;
    out->alpha = model->alpha;
    out->exponent = model->kind == RF_BSDF_PHONG ? (float)exponent : out->exponent;
    out->f90 = out->coat_f0 = out->coat_f90 = 0.0f;
    out->tint = rf_vec3( through, through, through );
    out->absorption = rf_vec3( 0.0f, 0.0f, 0.0f );
    out->ior = clear ? (float)ior : 0.0f;
    out->thin = false;
    return rf_json_result( material );
}
