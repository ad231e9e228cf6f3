// Errors with the place in the document, and typed reads of its values.
#include "scene/gltf/gltf_document.h"

#include "scene/json/json_document.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Limit of objects of a kind: more means a broken or malicious file.
#define MAX_ITEMS 16777216

static const char* const s_list_names[RF_GLTF_LIST_COUNT] = {
    [RF_GLTF_ACCESSORS] = "accessors", [RF_GLTF_ANIMATIONS] = "animations",
    [RF_GLTF_BUFFERS] = "buffers",     [RF_GLTF_BUFFER_VIEWS] = "bufferViews",
    [RF_GLTF_CAMERAS] = "cameras",     [RF_GLTF_MATERIALS] = "materials",
    [RF_GLTF_MESHES] = "meshes",       [RF_GLTF_NODES] = "nodes",
    [RF_GLTF_SCENES] = "scenes",       [RF_GLTF_IMAGES] = "images",
    [RF_GLTF_SAMPLERS] = "samplers",   [RF_GLTF_TEXTURES_LIST] = "textures",
    [RF_GLTF_SKINS_LIST] = "skins",
};

RfWhere rf_where( const char* format, ... )
{
    RfWhere where;
    va_list args;
    va_start( args, format );
    vsnprintf( where.text, sizeof where.text, format, args );
    va_end( args );
    return where;
}

RfResult rf_gltf_fail( const RfGltf* gltf, RfResult code, const char* where, const char* format, ... )
{
    char text[640];
    va_list args;
    va_start( args, format );
    vsnprintf( text, sizeof text, format, args );
    va_end( args );
    const char* advice = code == RF_ERROR_FORMAT ? ": not valid glTF 2.0, export the scene again" : "";
    return rf_fail( gltf->error, code, "%s: %s: %s%s", gltf->path, where, text, advice );
}

RfResult rf_gltf_check_limit( const RfGltf* gltf, const char* where, const char* key, double value, double limit )
{
    if ( fabs( value ) <= limit )
        return RF_OK;
    return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where,
                         "%s is %g, beyond what reframe reads: at most %g, change it in the scene", key, value, limit );
}

RfResult rf_gltf_no_memory( const RfGltf* gltf, const char* where )
{
    return rf_gltf_fail( gltf, RF_ERROR_MEMORY, where, "the system has no memory left: close other programs" );
}

void rf_gltf_notice( RfGltf* gltf, RfGltfNotice notice, const char* format, ... )
{
    if ( gltf->noticed[notice] )
        return;
    gltf->noticed[notice] = true;
    char text[512];
    va_list args;
    va_start( args, format );
    vsnprintf( text, sizeof text, format, args );
    va_end( args );
    rf_warn( gltf->log, "%s: %s", gltf->path, text );
}

static RfResult fail_kind( const RfGltf* gltf, const char* where, const char* key, const char* want, const json_t* got )
{
    return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s must be %s, got %s", key, want, rf_json_kind( got ) );
}

RfResult rf_gltf_require( const RfGltf* gltf, const json_t* object, const char* where, const char* key )
{
    if ( json_object_get( object, key ) != NULL )
        return RF_OK;
    return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s is missing", key );
}

RfResult rf_gltf_get_number( const RfGltf* gltf, const json_t* object, const char* where, const char* key, double* value )
{
    const json_t* member = json_object_get( object, key );
    if ( member == NULL )
        return RF_OK;
    if ( json_is_number( member ) == 0 )
        return fail_kind( gltf, where, key, "a number", member );
    *value = json_number_value( member );
    return RF_OK;
}

RfResult rf_gltf_get_numbers( const RfGltf* gltf, const json_t* object, const char* where, const char* key, int count,
                              double* values )
{
    const json_t* member = json_object_get( object, key );
    if ( member == NULL )
        return RF_OK;
    if ( json_is_array( member ) == 0 )
        return fail_kind( gltf, where, key, "an array", member );
    if ( json_array_size( member ) != (size_t)count )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s must be %d numbers, got %zu", key, count,
                             json_array_size( member ) );
    for ( int i = 0; i < count; ++i )
    {
        const json_t* number = json_array_get( member, (size_t)i );
        if ( json_is_number( number ) == 0 )
            return fail_kind( gltf, where, key, "numbers only", number );
        values[i] = json_number_value( number );
    }
    return RF_OK;
}

RfResult rf_gltf_get_integer( const RfGltf* gltf, const json_t* object, const char* where, const char* key, int64_t low,
                              int64_t high, int64_t* value )
{
    const json_t* member = json_object_get( object, key );
    if ( member == NULL )
        return RF_OK;
    int64_t integer;
    if ( rf_json_integer( member, &integer ) == false )
        return fail_kind( gltf, where, key, "an integer", member );
    if ( integer < low || integer > high )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s must be %lld to %lld, got %lld", key, (long long)low,
                             (long long)high, (long long)integer );
    *value = integer;
    return RF_OK;
}

RfResult rf_gltf_get_bool( const RfGltf* gltf, const json_t* object, const char* where, const char* key, bool* value )
{
    const json_t* member = json_object_get( object, key );
    if ( member == NULL )
        return RF_OK;
    if ( json_is_boolean( member ) == 0 )
        return fail_kind( gltf, where, key, "true or false", member );
    *value = json_is_true( member );
    return RF_OK;
}

RfResult rf_gltf_get_string( const RfGltf* gltf, const json_t* object, const char* where, const char* key, const char** value )
{
    const json_t* member = json_object_get( object, key );
    if ( member == NULL )
        return RF_OK;
    if ( json_is_string( member ) == 0 )
        return fail_kind( gltf, where, key, "a string", member );
    *value = json_string_value( member );
    return RF_OK;
}

RfResult rf_gltf_get_object( const RfGltf* gltf, const json_t* object, const char* where, const char* key, const json_t** value )
{
    const json_t* member = json_object_get( object, key );
    if ( member == NULL )
        return RF_OK;
    if ( json_is_object( member ) == 0 )
        return fail_kind( gltf, where, key, "an object", member );
    *value = member;
    return RF_OK;
}

RfResult rf_gltf_get_array( const RfGltf* gltf, const json_t* object, const char* where, const char* key, const json_t** value )
{
    const json_t* member = json_object_get( object, key );
    if ( member == NULL )
        return RF_OK;
    if ( json_is_array( member ) == 0 )
        return fail_kind( gltf, where, key, "an array", member );
    *value = member;
    return RF_OK;
}

RfResult rf_gltf_get_index( const RfGltf* gltf, const json_t* object, const char* where, const char* key, RfGltfList list,
                            int* index )
{
    *index = -1;
    int64_t value = -1;
    // the range is checked below, for a message with the length of the list
    RfResult result = rf_gltf_get_integer( gltf, object, where, key, INT64_MIN, INT64_MAX, &value );
    if ( result != RF_OK || json_object_get( object, key ) == NULL )
        return result;
    if ( value < 0 || value >= gltf->counts[list] )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s is %lld, but there are %d %s", key, (long long)value,
                             gltf->counts[list], s_list_names[list] );
    *index = (int)value;
    return RF_OK;
}

RfResult rf_gltf_get_extension( const RfGltf* gltf, const json_t* object, const char* where, const char* name,
                                const json_t** extension )
{
    *extension = NULL;
    const json_t* extensions = NULL;
    RfResult result = rf_gltf_get_object( gltf, object, where, "extensions", &extensions );
    if ( result != RF_OK || extensions == NULL )
        return result;
    return rf_gltf_get_object( gltf, extensions, where, name, extension );
}

RfResult rf_gltf_copy_name( const RfGltf* gltf, const json_t* object, const char* where, const char* fallback, char** name )
{
    const char* text = fallback;
    RfResult result = rf_gltf_get_string( gltf, object, where, "name", &text );
    if ( result != RF_OK )
        return result;
    *name = strdup( text[0] != 0 ? text : fallback );
    return *name != NULL ? RF_OK : rf_gltf_no_memory( gltf, where );
}

const json_t* rf_gltf_item( const RfGltf* gltf, RfGltfList list, int index )
{
    return json_array_get( gltf->lists[list], (size_t)index );
}

RfResult rf_gltf_open_lists( RfGltf* gltf )
{
    for ( int list = 0; list < RF_GLTF_LIST_COUNT; ++list )
    {
        const char* name = s_list_names[list];
        RfResult result = rf_gltf_get_array( gltf, gltf->root, "document", name, &gltf->lists[list] );
        if ( result != RF_OK )
            return result;
        size_t count = json_array_size( gltf->lists[list] );
        if ( count > MAX_ITEMS )
            return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, name, "%zu objects are too many, the limit is %d: split the scene",
                                 count, MAX_ITEMS );
        gltf->counts[list] = (int)count;
        for ( int i = 0; i < gltf->counts[list]; ++i )
        {
            const json_t* item = rf_gltf_item( gltf, (RfGltfList)list, i );
            if ( json_is_object( item ) == 0 )
                return rf_gltf_fail( gltf, RF_ERROR_FORMAT, name, "[%d] must be an object, got %s", i, rf_json_kind( item ) );
        }
    }
    return RF_OK;
}
