// `extras.reframe` of a material: scattering models that glTF lacks.
//
//     {"bsdf": "phong", "diffuse": [r, g, b], "specular": [r, g, b], "exponent": 60}
//     {"bsdf": "lambert", "diffuse": [r, g, b]}
//     {"bsdf": "mirror", "specular": [r, g, b]}
//     {"bsdf": "glass", "ior": 1.5}
//     {"coat": "added"}: glTF's own model, with a coat that takes nothing from the base, as in Blender's Principled

#include "scene/gltf/gltf_materials.h"

#include <string.h>

#define MAX_EXPONENT 1e6

// The extras are written by hand or by other programs: errors give the JSON path and the
// expected value.
static RfResult fault( const RfGltf* gltf, const char* where, const char* text )
{
    return rf_gltf_fail( gltf, RF_ERROR_SCENE, where, "%s", text );
}

static RfResult check_keys( const RfGltf* gltf, const json_t* json, const char* where, const char* const* keys )
{
    const char* key;
    json_t* value;
    json_object_foreach( (json_t*)json, key, value )
    {
        bool known = false;
        for ( int i = 0; keys[i] != NULL; ++i )
            known = known || strcmp( key, keys[i] ) == 0;
        if ( known == false )
        {
            RfWhere self = rf_where( "%s.%.60s", where, key );
            return fault( gltf, self.text,
                          "is not known here: bsdf \"phong\" has diffuse, specular and exponent, "
                          "\"lambert\" has diffuse, \"mirror\" specular, \"glass\" ior" );
        }
    }
    return RF_OK;
}

static RfResult read_reflectance( const RfGltf* gltf, const json_t* json, const char* where, const char* key, RfVec3* out )
{
    double rgb[3] = { 0 };
    RfWhere self = rf_where( "%s.%s", where, key );
    if ( json_object_get( json, key ) == NULL )
        return fault( gltf, self.text, "is missing: add three numbers from 0 to 1" );
    RfResult result = rf_gltf_get_numbers( gltf, json, where, key, 3, rgb );
    for ( int i = 0; result == RF_OK && i < 3; ++i )
    {
        if ( ( rgb[i] >= 0.0 && rgb[i] <= 1.0 ) == false )
            return fault( gltf, self.text, "wants three numbers from 0 to 1" );
    }
    *out = rf_vec3( (float)rgb[0], (float)rgb[1], (float)rgb[2] );
    return result;
}

static RfResult read_lambert( const RfGltf* gltf, const json_t* json, const char* where, RfMaterial* out )
{
    static const char* const s_keys[] = { "bsdf", "diffuse", NULL };
    RfResult result = check_keys( gltf, json, where, s_keys );
    if ( result == RF_OK )
        result = read_reflectance( gltf, json, where, "diffuse", &out->diffuse );
    out->kind = RF_BSDF_LAMBERT;
    return result;
}

static RfResult read_phong( const RfGltf* gltf, const json_t* json, const char* where, RfMaterial* out )
{
    static const char* const s_keys[] = { "bsdf", "diffuse", "specular", "exponent", NULL };
    double exponent = -1.0;
    RfResult result = check_keys( gltf, json, where, s_keys );
    if ( result == RF_OK )
        result = read_reflectance( gltf, json, where, "diffuse", &out->diffuse );
    if ( result == RF_OK )
        result = read_reflectance( gltf, json, where, "specular", &out->specular );
    if ( result == RF_OK )
        result = rf_gltf_get_number( gltf, json, where, "exponent", &exponent );
    if ( result != RF_OK )
        return result;
    if ( ( exponent >= 0.0 && exponent <= MAX_EXPONENT ) == false )
    {
        RfWhere self = rf_where( "%s.exponent", where );
        return fault( gltf, self.text, "wants a number from 0 to 1000000" );
    }
    // the rounding of decimal fractions that sum to one does not violate energy conservation
    if ( rf_max_component( rf_add( out->diffuse, out->specular ) ) > 1.0f + 1e-6f )
        return fault( gltf, where, "diffuse + specular reflect more light than arrives: lower their sum to 1 or less" );
    out->kind = RF_BSDF_PHONG;
    out->exponent = (float)exponent;
    return RF_OK;
}

static RfResult read_mirror( const RfGltf* gltf, const json_t* json, const char* where, RfMaterial* out )
{
    static const char* const s_keys[] = { "bsdf", "specular", NULL };
    RfResult result = check_keys( gltf, json, where, s_keys );
    out->kind = RF_BSDF_GLASS;
    return result == RF_OK ? read_reflectance( gltf, json, where, "specular", &out->specular ) : result;
}

// Solid, smooth and clear glass.
static RfResult read_glass( const RfGltf* gltf, const json_t* json, const char* where, RfMaterial* out )
{
    static const char* const s_keys[] = { "bsdf", "ior", NULL };
    double ior = 1.5;
    RfResult result = check_keys( gltf, json, where, s_keys );
    if ( result == RF_OK )
        result = rf_gltf_get_number( gltf, json, where, "ior", &ior );
    if ( result != RF_OK )
        return result;
    if ( !( ior > 1.0 && ior <= 10.0 ) )
    {
        RfWhere self = rf_where( "%s.ior", where );
        return fault( gltf, self.text, "wants a number above 1, up to 10" );
    }
    out->kind = RF_BSDF_GLASS;
    out->ior = (float)ior;
    out->tint = rf_vec3( 1.0f, 1.0f, 1.0f );
    return RF_OK;
}

static const json_t* own_extras( const json_t* material )
{
    // extras of other programs may have any type
    return json_object_get( json_object_get( material, "extras" ), "reframe" );
}

// Is `coat` given, so that the scattering model is glTF's?
static bool keeps_model( const json_t* own )
{
    return json_object_get( own, "coat" ) != NULL && json_object_get( own, "bsdf" ) == NULL;
}

bool rf_gltf_has_own_model( const json_t* material )
{
    const json_t* own = own_extras( material );
    return own != NULL && !keeps_model( own );
}

RfResult rf_gltf_read_coat( const RfGltf* gltf, const json_t* material, const char* where, RfFactors* out )
{
    const json_t* own = own_extras( material );
    if ( !keeps_model( own ) )
        return RF_OK;
    RfWhere self = rf_where( "%s.extras.reframe", where );
    const char* coat = json_string_value( json_object_get( own, "coat" ) );
    if ( json_object_size( own ) != 1 || coat == NULL || strcmp( coat, "added" ) != 0 )
        return fault( gltf, self.text, "wants coat \"added\" and nothing else, or a bsdf" );
    out->coat_is_added = true;
    return RF_OK;
}

RfResult rf_gltf_read_lobes( const RfGltf* gltf, const json_t* material, const char* where, RfMaterial* out )
{
    const json_t* json = own_extras( material );
    if ( json == NULL || keeps_model( json ) )
        return RF_OK;
    RfWhere self = rf_where( "%s.extras.reframe", where );
    const char* bsdf = json_string_value( json_object_get( json, "bsdf" ) );
    out->diffuse = out->specular = rf_vec3( 0.0f, 0.0f, 0.0f );
    out->f90 = out->coat_f0 = out->coat_f90 = 0.0f;
    out->alpha = 1.0f;
    out->tint = out->absorption = rf_vec3( 0.0f, 0.0f, 0.0f );
    out->ior = 0.0f;
    out->thin = false;
    if ( bsdf != NULL && strcmp( bsdf, "phong" ) == 0 )
        return read_phong( gltf, json, self.text, out );
    if ( bsdf != NULL && strcmp( bsdf, "lambert" ) == 0 )
        return read_lambert( gltf, json, self.text, out );
    out->alpha = 0.0f;
    if ( bsdf != NULL && strcmp( bsdf, "mirror" ) == 0 )
        return read_mirror( gltf, json, self.text, out );
    if ( bsdf != NULL && strcmp( bsdf, "glass" ) == 0 )
        return read_glass( gltf, json, self.text, out );
    return fault( gltf, self.text, "wants an object with bsdf \"lambert\", \"phong\", \"mirror\" or \"glass\"" );
}
