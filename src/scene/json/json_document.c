// Opens JSON files and reads typed values; every error gives the JSON path.
#include "scene/json/json_document.h"

#include "base/file.h"
#include "base/words.h"
#include "scene/light_groups.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void describe_json( const json_t* json, char* text, size_t size );

RfResult rf_parse_json( const char* path, const void* text, size_t size, const char* advice, const char* where, json_t** root,
                        RfError* error )
{
    json_error_t fault;
    errno = 0; // jansson takes a string that it has no memory for for one that is not there
    *root = json_loadb( text, size, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, &fault );
    if ( *root == NULL && errno == ENOMEM )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: the system has no memory left: close other programs", path );
    if ( *root == NULL )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: line %d, column %d: %s: %s", path, fault.line, fault.column, fault.text,
                        advice );
    if ( json_is_object( *root ) )
        return RF_OK;
    char got[80];
    describe_json( *root, got, sizeof got );
    json_decref( *root );
    *root = NULL;
    return rf_fail( error, RF_ERROR_FORMAT, "%s: %smust be an object, got %s", path, where, got );
}

// The value itself if it is short enough for one line, else its kind.
static void describe_json( const json_t* json, char* text, size_t size )
{
    if ( json_is_integer( json ) )
        snprintf( text, size, "%lld", (long long)json_integer_value( json ) );
    else if ( json_is_real( json ) )
        snprintf( text, size, "%.9g", json_real_value( json ) );
    else if ( json_is_string( json ) )
        snprintf( text, size, "\"%.60s\"", json_string_value( json ) );
    else if ( json_is_array( json ) )
        snprintf( text, size, "an array of %zu", json_array_size( json ) );
    else
        snprintf( text, size, "%s", rf_json_kind( json ) );
}

const char* rf_json_kind( const json_t* value )
{
    switch ( json_typeof( value ) )
    {
        case JSON_OBJECT: return "an object";
        case JSON_ARRAY: return "an array";
        case JSON_STRING: return "a string";
        case JSON_INTEGER: return "an integer";
        case JSON_REAL: return "a real number";
        case JSON_TRUE: return "true";
        case JSON_FALSE: return "false";
        case JSON_NULL: return "null";
    }
    return "something else";
}

bool rf_json_integer( const json_t* value, int64_t* whole )
{
    if ( json_is_integer( value ) )
    {
        *whole = json_integer_value( value );
        return true;
    }
    double real = json_is_real( value ) ? json_real_value( value ) : 0.5;
    if ( fabs( real ) > 9007199254740992.0 || floor( real ) != real )
        return false;
    *whole = (int64_t)real;
    return true;
}

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
    bool is_beside = slash != NULL && name[0] != '/' && !rf_is_web_address( name );
    size_t folder = is_beside ? (size_t)( slash - file ) + 1 : 0;
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

RfResult rf_field_must_be( const RfField* field, const char* want )
{
    if ( field->json == NULL )
        return rf_field_fail( field, "is missing: must be %s", want );
    char got[80];
    describe_json( field->json, got, sizeof got );
    return rf_field_fail( field, "must be %s, got %s", want, got );
}

RfResult rf_field_require( const RfField* object, const char* key, const char* want )
{
    RfField member = rf_field_member( object, key );
    return member.json != NULL ? RF_OK : rf_field_must_be( &member, want );
}

// Typed values of our own JSON files, and the keys that an object may have.

#define MAX_KEYS 64

static void list_keys( const char* const* keys, char* text, size_t size )
{
    size_t used = 0;
    text[0] = 0;
    for ( int i = 0; keys[i] != NULL && used < size; ++i )
        used += (size_t)snprintf( text + used, size - used, "%s%s", i > 0 ? ", " : "", keys[i] );
}

static RfResult fail_unknown( const RfField* object, const char* key, const char* const* keys )
{
    int count = 0;
    while ( keys[count] != NULL && count < MAX_KEYS )
        ++count;
    char list[640];
    list_keys( keys, list, sizeof list );
    RfField member = rf_field_member( object, key );
    const char* nearest = rf_nearest_word( key, keys, count );
    if ( nearest != NULL )
        return rf_field_fail( &member, "unknown key, did you mean %s? The keys here are: %s", nearest, list );
    return rf_field_fail( &member, "unknown key, the keys here are: %s", list );
}

static bool is_known( const char* key, const char* const* keys )
{
    for ( int i = 0; keys[i] != NULL; ++i )
    {
        if ( strcmp( key, keys[i] ) == 0 )
            return true;
    }
    return false;
}

RfResult rf_field_keys( const RfField* object, const char* const* keys )
{
    if ( !json_is_object( object->json ) )
        return rf_field_must_be( object, "an object" );
    const char* key;
    json_t* value;
    json_object_foreach( (json_t*)object->json, key, value )
    {
        if ( object->notes && ( strcmp( key, "$schema" ) == 0 || strcmp( key, "about" ) == 0 ) )
        {
            RfField member = rf_field_member( object, key );
            if ( !json_is_string( value ) )
                return rf_field_must_be( &member, "a string" );
        }
        else if ( !is_known( key, keys ) )
            return fail_unknown( object, key, keys );
    }
    return RF_OK;
}

static void describe_range( RfRange range, char* text, size_t size )
{
    bool low = range.low > -INFINITY, high = range.high < INFINITY;
    if ( !low && !high )
        text[0] = 0;
    else if ( !high )
        snprintf( text, size, " %s %g", range.open ? ">" : ">=", range.low );
    else if ( range.open )
        snprintf( text, size, " > %g and <= %g", range.low, range.high );
    else
        snprintf( text, size, " from %g to %g", range.low, range.high );
}

static bool in_range( const json_t* json, RfRange range, double* value )
{
    if ( !json_is_number( json ) )
        return false;
    *value = json_number_value( json );
    return *value <= range.high && ( range.open ? *value > range.low : *value >= range.low );
}

RfResult rf_field_number( const RfField* field, RfRange range, double* value )
{
    double number;
    if ( field->json == NULL )
        return RF_OK;
    if ( !in_range( field->json, range, &number ) )
    {
        char limits[64], want[96];
        describe_range( range, limits, sizeof limits );
        snprintf( want, sizeof want, "a number%s", limits );
        return rf_field_must_be( field, want );
    }
    *value = number;
    return RF_OK;
}

RfResult rf_field_numbers( const RfField* field, RfRange range, int count, double* values )
{
    if ( field->json == NULL )
        return RF_OK;
    if ( !json_is_array( field->json ) || json_array_size( field->json ) != (size_t)count )
    {
        char want[48];
        snprintf( want, sizeof want, "an array of %d numbers", count );
        return rf_field_must_be( field, want );
    }
    for ( int i = 0; i < count; ++i )
    {
        RfField item = rf_field_item( field, (size_t)i );
        RfResult result = rf_field_number( &item, range, values + i );
        if ( result != RF_OK )
            return result;
    }
    return RF_OK;
}

RfResult rf_field_bool( const RfField* field, bool* value )
{
    if ( field->json == NULL )
        return RF_OK;
    if ( !json_is_boolean( field->json ) )
        return rf_field_must_be( field, "true or false" );
    *value = json_is_true( field->json );
    return RF_OK;
}

RfResult rf_field_text( const RfField* field, const char** text )
{
    if ( field->json == NULL )
        return RF_OK;
    if ( !json_is_string( field->json ) || json_string_length( field->json ) == 0 )
        return rf_field_must_be( field, "a string that is not empty" );
    *text = json_string_value( field->json );
    return RF_OK;
}

RfResult rf_field_light_group( const RfField* object, const char** name )
{
    RfField field = rf_field_member( object, "light_group" );
    *name = json_string_value( field.json );
    if ( field.json == NULL || ( *name != NULL && rf_is_light_group_name( *name ) ) )
        return RF_OK;
    return rf_field_must_be( &field, "a name of 1 to 63 bytes without commas" );
}

RfResult rf_field_choice( const RfField* field, const char* const* words, int* index )
{
    if ( field->json == NULL )
        return RF_OK;
    const char* text = json_string_value( field->json );
    for ( int i = 0; text != NULL && words[i] != NULL; ++i )
    {
        if ( strcmp( text, words[i] ) == 0 )
        {
            *index = i;
            return RF_OK;
        }
    }
    char list[160], want[192];
    list_keys( words, list, sizeof list );
    snprintf( want, sizeof want, "one of %s", list );
    return rf_field_must_be( field, want );
}

RfResult rf_field_array( const RfField* field, const char* item, size_t least, size_t most )
{
    size_t count = json_array_size( field->json );
    if ( json_is_array( field->json ) && count >= least && count <= most )
        return RF_OK;
    char want[96];
    snprintf( want, sizeof want, "an array of %zu to %zu %s", least, most, item );
    return rf_field_must_be( field, want );
}
