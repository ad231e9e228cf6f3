// Intensity profiles of lamps: what `extras.reframe` of a light says,
//
//     {"ies": "file.ies"} or {"ies": {"bufferView": 7}}
//     {"profile": {"vertical": [0, 90], "horizontal": [0], "relative": [1, 0]}}
//
// by which its intensity is multiplied. A table takes the place of a spot's cone.
#include "scene/gltf/gltf_document.h"

#include "base/file.h"
#include "base/json.h"

#include <stdlib.h>

// By a scene file, the file lies beside it.
static RfResult read_file( RfGltf* gltf, const RfField* field, bool beside, RfProfile** out )
{
    const char* name = NULL;
    char* path = NULL;
    uint8_t* bytes = NULL;
    size_t size = 0;
    RfError error = { 0 };
    RfResult result = rf_field_text( field, &name );
    if ( result == RF_OK && beside )
        path = rf_path_beside( field->file, name );
    if ( result == RF_OK && beside && path == NULL )
        return rf_gltf_no_memory( gltf, "profiles" );
    if ( result == RF_OK && !beside )
        result = rf_gltf_resolve_uri( gltf, field->path, name, &path );
    if ( result != RF_OK )
        return result;
    result = rf_read_file( path, RF_PROFILE_BYTES, &bytes, &size, &error );
    if ( result == RF_OK )
        result = rf_read_ies( path, bytes, size, out, &error );
    if ( result == RF_OK )
        gltf->scene->content_hash = rf_hash_bytes( gltf->scene->content_hash, bytes, size );
    free( path );
    free( bytes );
    return result == RF_OK ? RF_OK : rf_field_fail_as( field, result, &error );
}

// The bytes of the view are in the scene's hash already.
static RfResult read_view( RfGltf* gltf, const RfField* field, RfProfile** out )
{
    static const char* const s_keys[] = { "bufferView", NULL };
    const uint8_t* bytes = NULL;
    int number = 0;
    int64_t length = 0;
    RfError error = { 0 };
    rf_field_keys( field, s_keys );
    rf_field_require( field, "bufferView", "the number of a buffer view" );
    RfField view = rf_field_member( field, "bufferView" );
    RfResult result = rf_field_whole( &view, 0.0, (double)gltf->counts[RF_GLTF_BUFFER_VIEWS] - 1.0, &number );
    if ( result != RF_OK )
        return result;
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_BUFFER_VIEWS, number );
    result = rf_get_integer( &json, "byteLength", 1, (int64_t)RF_PROFILE_BYTES, &length );
    if ( result == RF_OK )
        result = rf_gltf_view_bytes( gltf, view.path, number, 0, (uint64_t)length, &bytes );
    if ( result != RF_OK )
        return result;
    result = rf_read_ies( json.path, bytes, (size_t)length, out, &error );
    return result == RF_OK ? RF_OK : rf_field_fail_as( field, result, &error );
}

static RfResult read_numbers( const RfField* table, const char* key, const char* item, int least, int most, double** values,
                              int* count )
{
    RfField array = rf_field_member( table, key );
    rf_field_require( table, key, "an array of numbers" );
    RfResult result = rf_field_array( &array, item, (size_t)least, (size_t)most );
    if ( result != RF_OK )
        return result;
    *count = (int)json_array_size( array.json );
    *values = malloc( (size_t)*count * sizeof **values );
    if ( *values == NULL )
        return rf_field_no_memory( &array );
    return rf_field_numbers( &array, rf_range( 0.0, 1e12 ), *count, *values );
}

static RfResult read_table( const RfField* field, RfProfile** out )
{
    static const char* const s_keys[] = { "vertical", "horizontal", "relative", NULL };
    RfProfileTable table = { 0 };
    int count = 0;
    RfError error = { 0 };
    rf_field_keys( field, s_keys );
    read_numbers( field, "vertical", "degrees", 2, RF_PROFILE_ANGLES, &table.vertical, &table.rows );
    read_numbers( field, "horizontal", "degrees", 1, RF_PROFILE_ANGLES, &table.horizontal, &table.columns );
    RfResult result = read_numbers( field, "relative", "intensities", 2, RF_PROFILE_VALUES, &table.value, &count );
    if ( result == RF_OK && count != table.rows * table.columns )
        result = rf_field_fail( field, "has %d intensities for %d vertical and %d horizontal angles: must be %d", count,
                                table.rows, table.columns, table.rows * table.columns );
    else if ( result == RF_OK )
    {
        result = rf_make_profile( "the table", &table, out, &error );
        result = result == RF_OK ? RF_OK : rf_field_fail_as( field, result, &error );
    }
    free( table.vertical );
    free( table.horizontal );
    free( table.value );
    return result;
}

static RfResult read_any( RfGltf* gltf, const RfField* ours, const RfField* edit, RfProfile** out )
{
    RfField given = rf_field_member( edit, "ies" );
    RfField ies = rf_field_member( ours, "ies" ), table = rf_field_member( ours, "profile" );
    if ( given.json != NULL )
        return read_file( gltf, &given, true, out );
    if ( ies.json != NULL && table.json != NULL )
        return rf_field_fail( ours, "has both ies and profile: leave one out" );
    if ( table.json != NULL )
        return read_table( &table, out );
    if ( ies.json == NULL )
        return RF_OK;
    return json_is_object( ies.json ) ? read_view( gltf, &ies, out ) : read_file( gltf, &ies, false, out );
}

// A file may name the same table in each of many lights.
#define MOST_VALUES ( (size_t)1 << 24 )

RfResult rf_gltf_read_profile( RfGltf* gltf, const RfField* ours, const RfField* edit, RfProfile** out )
{
    RfResult result = read_any( gltf, ours, edit, out );
    if ( result != RF_OK || *out == NULL )
        return result;
    gltf->profile_values += (size_t)( *out )->rows * (size_t)( *out )->columns;
    return gltf->profile_values <= MOST_VALUES
               ? RF_OK
               : rf_field_fail( ours, "the profiles of the file's lights have more than %zu values", MOST_VALUES );
}
