#include "scene/json/material_edit_lobes.h"

#include <string.h>

static const char* const s_bsdfs[] = { "gltf", "lambert", "phong", NULL };
static const char* const s_lobe_keys[] = { "diffuse", "specular", "exponent", NULL };

RfResult rf_edit_no_memory( const RfField* field )
{
    return rf_fail( field->error, RF_ERROR_MEMORY, "%s: %s: no memory left", field->file, field->path );
}

json_t* rf_edit_member( json_t* object, const char* key )
{
    json_t* member = json_object_get( object, key );
    if ( json_is_object( member ) )
        return member;
    json_t* made = json_object();
    return json_object_set_new( object, key, made ) == 0 ? made : NULL;
}

static json_t* find_lobes( const json_t* material )
{
    return json_object_get( json_object_get( material, "extras" ), "reframe" );
}

const char* rf_edited_bsdf( const json_t* material )
{
    const json_t* lobes = find_lobes( material );
    const char* bsdf = json_string_value( json_object_get( lobes, "bsdf" ) );
    return bsdf != NULL ? bsdf : "gltf";
}

static bool has_lobe_key( const char* bsdf, const char* key )
{
    return strcmp( bsdf, "phong" ) == 0 || ( strcmp( bsdf, "lambert" ) == 0 && strcmp( key, "diffuse" ) == 0 );
}

// Changes the material to the bsdf that the override selects.
static RfResult change_bsdf( const RfField* override, json_t* material )
{
    int index = 0;
    RfField field = rf_field_member( override, "bsdf" );
    RfResult result = rf_field_choice( &field, s_bsdfs, &index );
    if ( result != RF_OK || field.json == NULL )
        return result;
    if ( index == 0 )
    {
        json_object_del( json_object_get( material, "extras" ), "reframe" );
        return RF_OK;
    }
    for ( int i = 0; s_lobe_keys[i] != NULL && result == RF_OK; ++i )
    {
        if ( has_lobe_key( s_bsdfs[index], s_lobe_keys[i] ) )
            result = rf_field_require( override, s_lobe_keys[i], i == 2 ? "a number from 0 to 1e+06" : "an array of 3 numbers" );
    }
    if ( result != RF_OK )
        return result;
    json_t* extras = rf_edit_member( material, "extras" );
    json_t* lobes = json_pack( "{s:s}", "bsdf", s_bsdfs[index] );
    return extras != NULL && json_object_set_new( extras, "reframe", lobes ) == 0 ? RF_OK : rf_edit_no_memory( &field );
}

static RfResult edit_lobe( const RfField* override, const char* key, json_t* material )
{
    double numbers[3];
    RfField field = rf_field_member( override, key );
    if ( field.json == NULL )
        return RF_OK;
    const char* bsdf = rf_edited_bsdf( material );
    if ( !has_lobe_key( bsdf, key ) )
        return rf_field_fail( &field,
                              "has no effect on bsdf \"%.20s\": add \"bsdf\": \"phong\" with diffuse, specular and "
                              "exponent",
                              bsdf );
    RfResult result = strcmp( key, "exponent" ) == 0 ? rf_field_number( &field, rf_range( 0.0, 1e6 ), numbers )
                                                     : rf_field_numbers( &field, rf_range( 0.0, 1.0 ), 3, numbers );
    if ( result == RF_OK && json_object_set( find_lobes( material ), key, (json_t*)field.json ) != 0 )
        return rf_edit_no_memory( &field );
    return result;
}

static RfResult check_energy( const RfField* override, const json_t* material )
{
    const json_t* lobes = find_lobes( material );
    for ( size_t i = 0; i < 3; ++i )
    {
        double diffuse = json_number_value( json_array_get( json_object_get( lobes, "diffuse" ), i ) );
        double specular = json_number_value( json_array_get( json_object_get( lobes, "specular" ), i ) );
        // the rounding of decimal fractions that sum to one does not violate energy conservation
        if ( diffuse + specular > 1.0 + 1e-6 )
            return rf_field_fail( override, "diffuse + specular reflect %g of the incident light: lower their sum to 1 or less",
                                  diffuse + specular );
    }
    return RF_OK;
}

RfResult rf_edit_lobes( const RfField* override, json_t* material )
{
    RfResult result = change_bsdf( override, material );
    for ( int i = 0; s_lobe_keys[i] != NULL && result == RF_OK; ++i )
        result = edit_lobe( override, s_lobe_keys[i], material );
    return result == RF_OK ? check_energy( override, material ) : result;
}
