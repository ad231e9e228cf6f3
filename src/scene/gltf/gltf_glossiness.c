// KHR_materials_pbrSpecularGlossiness, converted in the document to what means the same: a non-metal whose reflectance at normal
// incidence is the specular colour (an index of refraction of 0, by KHR_materials_ior, makes the colour of KHR_materials_specular
// that), with a roughness of 1 − glossiness. The light that the base gets differs: it is what GGX lets through, not 1 − max(specular).
#include "scene/gltf/gltf_materials.h"

#define EXTENSION "KHR_materials_pbrSpecularGlossiness"

static int copy( json_t* to, const char* key, const json_t* from, const char* name )
{
    json_t* value = json_object_get( from, name );
    return value != NULL ? json_object_set( to, key, value ) : 0;
}

static int convert( json_t* material, const json_t* from, double glossiness )
{
    json_t* extensions = json_object_get( material, "extensions" );
    json_t *part = json_pack( "{s:f,s:f}", "metallicFactor", 0.0, "roughnessFactor", 1.0 - glossiness ),
           *specular = json_object();
    int fault = copy( part, "baseColorFactor", from, "diffuseFactor" );
    fault |= copy( part, "baseColorTexture", from, "diffuseTexture" );
    fault |= copy( specular, "specularColorFactor", from, "specularFactor" );
    fault |= copy( specular, "specularColorTexture", from, "specularGlossinessTexture" );
    fault |= json_object_set_new( material, "pbrMetallicRoughness", part );
    fault |= json_object_set_new( extensions, "KHR_materials_specular", specular );
    return fault | json_object_set_new( extensions, "KHR_materials_ior", json_pack( "{s:f}", "ior", 0.0 ) );
}

// Factors are validated here, where messages name them as the file does.
static RfResult convert_material( const RfField* material, json_t* json )
{
    double diffuse[4] = { 0 }, specular[3] = { 0 }, glossiness = 1.0;
    const RfRange share = rf_range( 0.0, 1.0 );
    RfField from = rf_gltf_extension( material, EXTENSION );
    if ( from.json == NULL )
        return rf_json_result( material );
    rf_get_numbers( &from, "diffuseFactor", share, 4, diffuse );
    rf_get_numbers( &from, "specularFactor", share, 3, specular );
    RfResult result = rf_get_number( &from, "glossinessFactor", share, &glossiness );
    return result != RF_OK || convert( json, from.json, glossiness ) == 0 ? result : rf_field_no_memory( &from );
}

RfResult rf_gltf_convert_glossiness( RfGltf* gltf )
{
    json_t* material;
    size_t i;
    RfResult result = RF_OK;
    json_array_foreach( json_object_get( gltf->root, "materials" ), i, material )
    {
        if ( result == RF_OK && json_is_object( material ) ) // else an error where materials are read
        {
            RfField field = rf_gltf_field( gltf, rf_where( "materials[%zu]", i ).text, material );
            result = convert_material( &field, material );
        }
    }
    return result;
}

bool rf_gltf_has_glossiness_texture( const json_t* material )
{
    const json_t* from = json_object_get( json_object_get( material, "extensions" ), EXTENSION );
    return json_object_get( from, "specularGlossinessTexture" ) != NULL;
}
