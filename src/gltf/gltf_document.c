// Errors with the place in the document, and typed reads of its values.
#include "gltf/gltf_document.h"

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
    if ( gltf->error->code != RF_OK ) // which came first
        return gltf->error->code;
    va_start( args, format );
    vsnprintf( text, sizeof text, format, args );
    va_end( args );
    const char* advice = code == RF_ERROR_FORMAT ? ": not valid glTF 2.0, export the scene again" : "";
    return rf_fail( gltf->error, code, "%s: %s: %s%s", gltf->path, where, text, advice );
}

RfResult rf_gltf_check_limit( const RfGltf* gltf, const char* where, const char* key, double value, double limit )
{
    if ( fabs( value ) <= limit )
        return gltf->error->code;
    return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where,
                         "%s is %g, beyond what reframe reads: at most %g, change it in the scene", key, value, limit );
}

// Room doubles where the count is a power of two.
bool rf_gltf_grow( void* list, int count, size_t size )
{
    size_t items = (size_t)count;
    void* old;
    if ( ( items & ( items - 1 ) ) != 0 )
        return true;
    memcpy( &old, list, sizeof old );
    void* grown = realloc( old, ( items > 0 ? 2 * items : 1 ) * size );
    if ( grown != NULL )
        memcpy( list, &grown, sizeof grown );
    return grown != NULL;
}

RfResult rf_gltf_no_memory( const RfGltf* gltf, const char* where )
{
    return rf_gltf_fail( gltf, RF_ERROR_MEMORY, where, "out of memory: close other programs" );
}

void rf_gltf_notice( RfGltf* gltf, const char* format, ... )
{
    int kind = 0;
    while ( kind < RF_GLTF_NOTICES && gltf->noticed[kind] != NULL && strcmp( gltf->noticed[kind], format ) != 0 )
        ++kind;
    if ( kind == RF_GLTF_NOTICES || gltf->noticed[kind] != NULL )
        return;
    gltf->noticed[kind] = format;
    char text[512];
    va_list args;
    va_start( args, format );
    vsnprintf( text, sizeof text, format, args );
    va_end( args );
    rf_warn( gltf->log, "%s: %s", gltf->path, text );
}

RfResult rf_gltf_note_unrendered( RfGltf* gltf, const char* what, const char* format, ... )
{
    char why[256];
    va_list args;
    va_start( args, format );
    vsnprintf( why, sizeof why, format, args );
    va_end( args );
    return rf_note_unrendered( gltf->scene, what, why ) ? RF_OK : rf_gltf_no_memory( gltf, "animations" );
}

RfResult rf_gltf_fail_left_out( const RfGltf* gltf, const char* where, const char* extension, const char* library )
{
    return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where, "%s needs %s, which this build of reframe lacks: " RF_GLTF_UNPACK,
                         extension, library );
}

bool rf_gltf_has_draco( void )
{
#ifdef REFRAME_DRACO
    return true;
#else
    return false;
#endif
}

bool rf_gltf_has_meshopt( void )
{
#ifdef REFRAME_MESHOPT
    return true;
#else
    return false;
#endif
}

RfField rf_gltf_field( const RfGltf* gltf, const char* path, const json_t* json )
{
    RfField field = rf_make_field( gltf->path, path, json, gltf->error );
    field.gltf = true;
    return field;
}

RfField rf_gltf_root( const RfGltf* gltf ) { return rf_gltf_field( gltf, "document", gltf->root ); }

RfField rf_gltf_item_field( const RfGltf* gltf, RfGltfList list, int index )
{
    RfField all = rf_gltf_field( gltf, s_list_names[list], gltf->lists[list] );
    return rf_field_item( &all, (size_t)index );
}

RfField rf_gltf_primitives( const RfGltf* gltf, int mesh )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_MESHES, mesh );
    rf_gltf_require( &json, "primitives", NULL );
    RfField primitives = rf_get_array( &json, "primitives" );
    for ( size_t i = 0; i < json_array_size( primitives.json ); ++i )
    {
        if ( !json_is_object( json_array_get( primitives.json, i ) ) )
            rf_gltf_fail( gltf, RF_ERROR_FORMAT, rf_where( "%s[%zu]", primitives.path, i ).text, "must be an object" );
    }
    return primitives;
}

RfResult rf_gltf_require( const RfField* object, ... )
{
    va_list args;
    va_start( args, object );
    for ( const char* key = va_arg( args, const char* ); key != NULL; key = va_arg( args, const char* ) )
        rf_field_require( object, key, "" );
    va_end( args );
    return rf_json_result( object );
}

int rf_gltf_get_index( const RfGltf* gltf, const RfField* object, const char* key, RfGltfList list )
{
    int64_t value = -1;
    // the range is checked below, for a message with the length of the list
    RfResult result = rf_get_integer( object, key, INT64_MIN, INT64_MAX, &value );
    if ( result != RF_OK || !rf_has_member( object, key ) || ( value >= 0 && value < gltf->counts[list] ) )
        return result == RF_OK ? (int)value : -1;
    RfField member = rf_field_member( object, key );
    rf_field_fail( &member, "is %lld, but there are %d %s", (long long)value, gltf->counts[list], s_list_names[list] );
    return -1;
}

RfField rf_gltf_extension( const RfField* object, const char* name )
{
    if ( !rf_has_member( object, "extensions" ) )
        return rf_make_field( object->file, "", NULL, object->error );
    RfField extensions = rf_get_object( object, "extensions" );
    return rf_get_object( &extensions, name );
}

RfField rf_gltf_home( const RfField* object, const char* home )
{
    if ( home == NULL )
        return *object;
    return strncmp( home, "KHR_", 4 ) == 0 ? rf_gltf_extension( object, home ) : rf_get_object( object, home );
}

RfField rf_gltf_extras( const RfField* object )
{
    const json_t* ours = json_object_get( json_object_get( object->json, "extras" ), "reframe" );
    if ( ours == NULL )
        return rf_make_field( object->file, "", NULL, object->error );
    return rf_make_field( object->file, rf_where( "%.140s.extras.reframe", object->path ).text, ours, object->error );
}

RfResult rf_gltf_copy_name( const RfField* object, const char* fallback, char** name )
{
    const char* text = fallback;
    RfResult result = rf_get_text( object, "name", &text );
    if ( result != RF_OK )
        return result;
    *name = strdup( text[0] != 0 ? text : fallback );
    return *name != NULL ? RF_OK : rf_field_no_memory( object );
}

const json_t* rf_gltf_item( const RfGltf* gltf, RfGltfList list, int index )
{
    return json_array_get( gltf->lists[list], (size_t)index );
}

RfResult rf_gltf_open_lists( RfGltf* gltf )
{
    RfField root = rf_gltf_root( gltf );
    for ( int list = 0; list < RF_GLTF_LIST_COUNT; ++list )
    {
        const char* name = s_list_names[list];
        gltf->lists[list] = rf_get_array( &root, name ).json;
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
    return rf_json_result( &root );
}
