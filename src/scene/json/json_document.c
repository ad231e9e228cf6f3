#include "scene/json/json_document.h"

#include "base/file.h"
#include "scene/json/json_value.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_BYTES ( (uint64_t)64 << 20 )

RfResult rf_open_json( const char* path, RfJsonDocument* document, RfError* error )
{
    *document = ( RfJsonDocument ){ .path = strdup( path ) };
    uint8_t* bytes = NULL;
    size_t size;
    RfResult result = document->path != NULL ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left", path );
    if ( result == RF_OK )
        result = rf_read_file( path, MAX_BYTES, &bytes, &size, error );
    if ( result == RF_OK )
    {
        document->hash = rf_hash_bytes( RF_HASH_START, bytes, size );
        result = rf_parse_json( path, bytes, size, "correct the JSON there", "", &document->root, error );
    }
    free( bytes );
    if ( result != RF_OK )
        rf_close_json( document );
    return result;
}

void rf_close_json( RfJsonDocument* document )
{
    json_decref( document->root );
    free( document->path );
    *document = ( RfJsonDocument ){ 0 };
}

char* rf_path_beside( const char* file, const char* name )
{
    const char* slash = strrchr( file, '/' );
    size_t folder = slash != NULL && name[0] != '/' ? (size_t)( slash - file ) + 1 : 0;
    char* path = malloc( folder + strlen( name ) + 1 );
    if ( path == NULL )
        return NULL;
    memcpy( path, file, folder );
    strcpy( path + folder, name );
    return path;
}

// Paths that are too long are truncated: they are only for messages.
__attribute__( ( format( printf, 2, 3 ) ) ) static void set_path( RfField* field, const char* format, ... )
{
    va_list args;
    va_start( args, format );
    vsnprintf( field->path, sizeof field->path, format, args );
    va_end( args );
}

RfField rf_make_field( const char* file, const char* path, const json_t* json, RfError* error )
{
    RfField field = { .file = file, .error = error, .json = json };
    set_path( &field, "%s", path );
    return field;
}

RfField rf_root_field( const RfJsonDocument* document, RfError* error )
{
    RfField root = rf_make_field( document->path, "", document->root, error );
    root.notes = true;
    return root;
}

static bool is_plain( const char* key )
{
    for ( const char* c = key; *c != 0; ++c )
    {
        if ( !isalnum( (unsigned char)*c ) && strchr( "_-$", *c ) == NULL )
            return false;
    }
    return key[0] != 0;
}

RfField rf_field_member( const RfField* object, const char* key )
{
    RfField member = { .file = object->file, .error = object->error, .json = json_object_get( object->json, key ) };
    const char* dot = object->path[0] != 0 ? "." : "";
    if ( is_plain( key ) )
        set_path( &member, "%s%s%.80s", object->path, dot, key );
    else
        set_path( &member, "%s[\"%.80s\"]", object->path, key );
    return member;
}

RfField rf_field_item( const RfField* array, size_t index )
{
    RfField item = { .file = array->file, .error = array->error, .json = json_array_get( array->json, index ) };
    set_path( &item, "%s[%zu]", array->path, index );
    return item;
}

RfResult rf_field_fail( const RfField* field, const char* format, ... )
{
    char text[768];
    va_list args;
    va_start( args, format );
    vsnprintf( text, sizeof text, format, args );
    va_end( args );
    return rf_fail( field->error, RF_ERROR_SCENE, "%s: %s%s%s", field->file, field->path, field->path[0] != 0 ? ": " : "", text );
}

RfResult rf_field_wants( const RfField* field, const char* want )
{
    if ( field->json == NULL )
        return rf_field_fail( field, "is missing: wants %s", want );
    char got[80];
    rf_describe_json( field->json, got, sizeof got );
    return rf_field_fail( field, "wants %s, got %s", want, got );
}

RfResult rf_field_require( const RfField* object, const char* key, const char* want )
{
    RfField member = rf_field_member( object, key );
    return member.json != NULL ? RF_OK : rf_field_wants( &member, want );
}
