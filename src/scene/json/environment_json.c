// Reads and validates an environment: radiance, map, rotation, visibility.
#include "scene/json/environment_json.h"

#include "base/file.h"
#include "image/decode.h"

#include <stdlib.h>

// Brighter radiance would overflow when floats are squared.
#define MAX_RADIANCE 1e15

// The view in place of the file; −1: none.
static RfResult read_view( const RfField* object, const RfField* map, int* view )
{
    RfField field = rf_field_member( object, "bufferView" );
    double number = -1.0;
    *view = -1;
    if ( field.json == NULL )
        return RF_OK;
    if ( map->json != NULL )
        return rf_field_fail( object, "has both map and bufferView: give one of them" );
    RfResult result = rf_field_number( &field, rf_range( 0.0, 1e9 ), &number );
    if ( result == RF_OK && floor( number ) != number )
        return rf_field_must_be( &field, "a whole number" );
    *view = (int)number;
    return result;
}

RfResult rf_read_environment( const RfField* object, RfEnvironment* environment, const char** map, int* view )
{
    static const char* const s_keys[] = { "radiance", "map", "rotation", "visible", "bufferView", NULL };
    static const char* const s_file_keys[] = { "radiance", "map", "rotation", "visible", NULL };
    double radiance[3] = { 1.0, 1.0, 1.0 }, rotation = 0.0;
    bool visible = true;
    *map = NULL;
    RfField radiance_field = rf_field_member( object, "radiance" ), map_field = rf_field_member( object, "map" ),
            rotation_field = rf_field_member( object, "rotation" ), visible_field = rf_field_member( object, "visible" );
    RfResult result = rf_field_keys( object, view != NULL ? s_keys : s_file_keys );
    if ( result == RF_OK && view != NULL )
        result = read_view( object, &map_field, view );
    bool has_map = map_field.json != NULL || ( view != NULL && *view >= 0 );
    if ( result == RF_OK && radiance_field.json == NULL && !has_map )
        return rf_field_fail( object, "gives no light: give radiance, map or both" );
    if ( result == RF_OK )
        result = rf_field_numbers( &radiance_field, rf_range( 0.0, MAX_RADIANCE ), 3, radiance );
    if ( result == RF_OK )
        result = rf_field_text( &map_field, map );
    if ( result == RF_OK )
        result = rf_field_number( &rotation_field, rf_range( -1e6, 1e6 ), &rotation );
    if ( result == RF_OK )
        result = rf_field_bool( &visible_field, &visible );
    if ( result != RF_OK )
        return result;
    *environment = ( RfEnvironment ){
        .radiance = rf_vec3( (float)radiance[0], (float)radiance[1], (float)radiance[2] ),
        .rotation = (float)( fmod( rotation, 360.0 ) * ( 3.14159265358979323846 / 180.0 ) ),
        .hidden = !visible,
    };
    return RF_OK;
}

static bool is_too_bright( const RfEnvironment* e )
{
    double most = (double)rf_max_component( e->radiance );
    size_t count = 3 * (size_t)e->width * (size_t)e->height;
    for ( size_t i = 0; i < count; ++i )
    {
        if ( most * (double)e->map[i] > MAX_RADIANCE )
            return true;
    }
    return false;
}

// Checks a map that has been loaded with `result`; the decoder's message names the file.
static RfResult check_map( const RfField* object, const char* key, RfResult result, const RfError* error,
                           RfEnvironment* environment )
{
    RfField field = rf_field_member( object, key );
    if ( result == RF_OK && !is_too_bright( environment ) )
        return RF_OK;
    free( environment->map );
    environment->map = NULL;
    if ( result == RF_OK )
        return rf_field_fail( &field, "times radiance is brighter than %g somewhere: lower radiance", MAX_RADIANCE );
    rf_field_fail( &field, "%.560s", error->text );
    if ( field.error != NULL )
        field.error->code = result;
    return result;
}

RfResult rf_load_environment( const RfField* object, const char* path, RfEnvironment* environment )
{
    RfError error = { 0 };
    RfResult result = rf_load_environment_map( path, &environment->width, &environment->height, &environment->map, &error );
    return check_map( object, "map", result, &error, environment );
}

RfResult rf_decode_environment( const RfField* object, const void* bytes, size_t size, RfEnvironment* environment )
{
    RfError error = { 0 };
    RfResult result =
        rf_decode_environment_map( bytes, size, "the map", &environment->width, &environment->height, &environment->map, &error );
    return check_map( object, "bufferView", result, &error, environment );
}

uint64_t rf_hash_environment( uint64_t hash, const RfEnvironment* environment )
{
    if ( environment->map == NULL )
        return hash;
    int size[2] = { environment->width, environment->height };
    size_t count = 3 * (size_t)environment->width * (size_t)environment->height;
    hash = rf_hash_bytes( hash, size, sizeof size );
    return rf_hash_bytes( hash, environment->map, count * sizeof *environment->map );
}
