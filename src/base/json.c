// Opens JSON files and reads typed values; every error gives the JSON path.
#include "base/json.h"

#include "base/file.h"
#include "base/words.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// What errors of glTF end with.
#define NOT_VALID ": not valid glTF 2.0, export the scene again"

static void describe_json( const json_t* json, char* text, size_t size );

RfResult rf_parse_json( const char* path, const void* text, size_t size, const char* advice, const char* where, json_t** root,
                        RfError* error )
{
    json_error_t fault;
    if ( size >= 3 && memcmp( text, "\xef\xbb\xbf", 3 ) == 0 ) // a byte-order mark
    {
        text = (const char*)text + 3;
        size -= 3;
    }
    errno = 0; // jansson takes a string that it has no memory for for one that is not there
    *root = json_loadb( text, size, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, &fault );
    if ( *root == NULL && errno == ENOMEM )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory: close other programs", path );
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
    error = rf_begin_reading( error );
    uint8_t* bytes = NULL;
    size_t size;
    RfResult result = document->path != NULL ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory", path );
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

RfError* rf_begin_reading( RfError* error )
{
    static _Thread_local RfError s_unheard;
    RfError* kept = error != NULL ? error : &s_unheard;
    kept->code = RF_OK;
    return kept;
}

// Appends to the path of a field, by hand since every object that is read has one. Paths that are too long are truncated: they are
// only for messages.
static void append( RfField* field, const char* text )
{
    size_t used = strlen( field->path ), room = sizeof field->path - 1 - used, length = strlen( text );
    length = length < room ? length : room;
    memcpy( field->path + used, text, length );
    field->path[used + length] = 0;
}

RfField rf_make_field( const char* file, const char* path, const json_t* json, RfError* error )
{
    RfField field;
    field.file = file;
    field.error = error;
    field.json = json;
    field.notes = field.gltf = false;
    field.owner = 0;
    field.path[0] = 0;
    append( &field, path );
    return field;
}

RfField rf_root_field( const RfJsonDocument* document, RfError* error )
{
    RfField root = rf_make_field( document->path, "", document->root, rf_begin_reading( error ) );
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
    RfField member = rf_make_field( object->file, object->path, json_object_get( object->json, key ), object->error );
    member.gltf = object->gltf;
    member.owner = (int)strlen( object->path );
    bool plain = is_plain( key );
    append( &member, !plain ? "[\"" : object->path[0] != 0 ? "." : "" );
    append( &member, key );
    append( &member, plain ? "" : "\"]" );
    return member;
}

RfField rf_field_item( const RfField* array, size_t index )
{
    char text[24], *digits = text + sizeof text - 2;
    RfField item = rf_make_field( array->file, array->path, json_array_get( array->json, index ), array->error );
    item.gltf = array->gltf;
    item.owner = array->owner;
    memcpy( digits, "]", 2 );
    do
        *--digits = (char)( '0' + index % 10 );
    while ( ( index /= 10 ) > 0 );
    *--digits = '[';
    append( &item, digits );
    return item;
}

RfResult rf_field_fail( const RfField* field, const char* format, ... )
{
    char text[768];
    va_list args;
    if ( field->error->code != RF_OK )
        return field->error->code;
    va_start( args, format );
    vsnprintf( text, sizeof text, format, args );
    va_end( args );
    const char* colon = field->path[0] != 0 ? ": " : "";
    if ( !field->gltf )
        return rf_fail( field->error, RF_ERROR_SCENE, "%s: %s%s%s", field->file, field->path, colon, text );
    const char* key = field->path + field->owner;
    if ( field->owner == 0 )
        return rf_fail( field->error, RF_ERROR_FORMAT, "%s: %s%s%s" NOT_VALID, field->file, field->path, colon, text );
    return rf_fail( field->error, RF_ERROR_FORMAT, "%s: %.*s: %s %s" NOT_VALID, field->file, field->owner, field->path,
                    key + ( key[0] == '.' ), text );
}

RfResult rf_field_fail_as( const RfField* field, RfResult result, const RfError* error )
{
    if ( rf_json_result( field ) == RF_OK )
    {
        rf_field_fail( field, "%.700s", error->text );
        field->error->code = result;
    }
    return rf_json_result( field );
}

RfResult rf_field_no_memory( const RfField* field )
{
    return rf_fail( field->error, RF_ERROR_MEMORY, "%s: %s: out of memory", field->file, field->path );
}

RfResult rf_field_must_be( const RfField* field, const char* want )
{
    if ( field->json == NULL )
        return rf_field_fail( field, "is missing: must be %s", want );
    char got[80];
    if ( field->gltf )
        return rf_field_fail( field, "must be %s, got %s", want, rf_json_kind( field->json ) );
    describe_json( field->json, got, sizeof got );
    return rf_field_fail( field, "must be %s, got %s", want, got );
}

RfResult rf_field_require( const RfField* object, const char* key, const char* want )
{
    if ( rf_json_result( object ) != RF_OK || rf_has_member( object, key ) )
        return rf_json_result( object );
    RfField member = rf_field_member( object, key );
    return object->gltf ? rf_field_fail( &member, "is missing" ) : rf_field_must_be( &member, want );
}

// The keys that an object may have.

#define MAX_KEYS 64

static void list_keys( const char* const* keys, char* text, size_t size )
{
    text[0] = 0;
    rf_append_words( text, size, keys, ", ", ", " );
}

// The index of a word in a list; −1 where it is not there, or NULL.
static int find_word( const char* word, const char* const* words )
{
    for ( int i = 0; word != NULL && words[i] != NULL; ++i )
    {
        if ( strcmp( word, words[i] ) == 0 )
            return i;
    }
    return -1;
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

RfResult rf_field_keys( const RfField* object, const char* const* keys )
{
    if ( rf_json_result( object ) != RF_OK )
        return rf_json_result( object );
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
        else if ( find_word( key, keys ) < 0 )
            return fail_unknown( object, key, keys );
    }
    return RF_OK;
}

// Typed values.

// "from 0 to 1" and so on, or for glTF, after "it must be", "0 to 1".
static void describe_range( const RfField* field, RfRange range, char* text, size_t size )
{
    bool low = range.low > -INFINITY, high = range.high < INFINITY;
    const char *more_than = field->gltf ? "more than" : ">", *from = field->gltf ? "" : "from ";
    if ( !low && !high )
        text[0] = 0;
    else if ( !high && ( range.open || !field->gltf ) )
        snprintf( text, size, "%s %g", range.open ? more_than : ">=", range.low );
    else if ( !high )
        snprintf( text, size, "%g or more", range.low );
    else if ( range.open )
        snprintf( text, size, "%s %g and %s %g", more_than, range.low, field->gltf ? "at most" : "<=", range.high );
    else
        snprintf( text, size, "%s%g to %g", from, range.low, range.high );
}

// What all reads begin with: false where there is nothing to read, or something has failed.
static bool is_given( const RfField* field ) { return field->json != NULL && field->error->code == RF_OK; }

static bool contains( RfRange range, double number )
{
    return number <= range.high && ( range.open ? number > range.low : number >= range.low );
}

RfResult rf_field_check( const RfField* field, RfRange range, double value )
{
    char limits[64];
    if ( contains( range, value ) )
        return rf_json_result( field );
    describe_range( field, range, limits, sizeof limits );
    return field->gltf ? rf_field_fail( field, "is %.9g, it must be %s", value, limits )
                       : rf_field_fail( field, "must be a number %s, got %.9g", limits, value );
}

#define ROUNDED 1e-4

double rf_round_into( RfRange range, double number )
{
    if ( number > range.high && number <= range.high + ROUNDED )
        return range.high;
    return !range.open && number < range.low && number >= range.low - ROUNDED ? range.low : number;
}

static bool in_range( bool gltf, const json_t* json, RfRange range, double* value )
{
    double number = json_number_value( json );
    if ( gltf )
        number = rf_round_into( range, number );
    if ( !json_is_number( json ) || !contains( range, number ) )
        return false;
    *value = number;
    return true;
}

RfResult rf_field_number( const RfField* field, RfRange range, double* value )
{
    if ( !is_given( field ) || in_range( field->gltf, field->json, range, value ) )
        return rf_json_result( field );
    if ( field->gltf && json_is_number( field->json ) )
        return rf_field_check( field, range, json_number_value( field->json ) );
    char limits[64], want[96];
    describe_range( field, range, limits, sizeof limits );
    snprintf( want, sizeof want, "a number%s%s", limits[0] != 0 ? " " : "", limits );
    return rf_field_must_be( field, field->gltf ? "a number" : want );
}

// Values are taken as far as they are numbers of the range.
static bool take_numbers( bool gltf, const json_t* json, RfRange range, int count, double* values )
{
    int taken = 0;
    while ( taken < count && in_range( gltf, json_array_get( json, (size_t)taken ), range, values + taken ) )
        ++taken;
    return json_is_array( json ) && taken == count && json_array_size( json ) == (size_t)count;
}

RfResult rf_field_numbers( const RfField* field, RfRange range, int count, double* values )
{
    if ( !is_given( field ) || take_numbers( field->gltf, field->json, range, count, values ) )
        return rf_json_result( field );
    size_t given = json_array_size( field->json );
    if ( field->gltf && json_is_array( field->json ) && given != (size_t)count )
        return rf_field_fail( field, "must be %d numbers, got %zu", count, given );
    if ( given != (size_t)count )
    {
        char want[48];
        snprintf( want, sizeof want, "an array of %d numbers", count );
        return rf_field_must_be( field, field->gltf ? "an array" : want );
    }
    for ( int i = 0; i < count; ++i )
    {
        RfField item = rf_field_item( field, (size_t)i );
        if ( !field->gltf )
            rf_field_number( &item, range, values + i );
        else if ( json_is_number( item.json ) )
            rf_field_check( field, range, json_number_value( item.json ) );
        else
            return rf_field_fail( field, "must be numbers only, got %s", rf_json_kind( item.json ) );
    }
    return rf_json_result( field );
}

RfResult rf_field_whole( const RfField* field, double low, double high, int* value )
{
    double number = (double)*value;
    RfResult result = rf_field_number( field, rf_range( low, high ), &number );
    if ( result == RF_OK && floor( number ) != number )
        return rf_field_must_be( field, "a whole number" );
    *value = (int)number;
    return result;
}

RfResult rf_field_bool( const RfField* field, bool* value )
{
    if ( !is_given( field ) )
        return rf_json_result( field );
    if ( !json_is_boolean( field->json ) )
        return rf_field_must_be( field, "true or false" );
    *value = json_is_true( field->json );
    return RF_OK;
}

RfResult rf_field_text( const RfField* field, const char** text )
{
    if ( !is_given( field ) )
        return rf_json_result( field );
    if ( !json_is_string( field->json ) || ( json_string_length( field->json ) == 0 && !field->gltf ) )
        return rf_field_must_be( field, field->gltf ? "a string" : "a string that is not empty" );
    *text = json_string_value( field->json );
    return RF_OK;
}

RfResult rf_field_choice( const RfField* field, const char* const* words, int* index )
{
    if ( !is_given( field ) )
        return rf_json_result( field );
    const char* text = json_string_value( field->json );
    int found = find_word( text, words );
    *index = found >= 0 ? found : *index;
    if ( found >= 0 )
        return RF_OK;
    if ( field->gltf && text == NULL )
        return rf_field_must_be( field, "a string" );
    char list[160], want[192];
    list_keys( words, list, sizeof list );
    if ( field->gltf )
        return rf_field_fail( field, "'%.20s' must be one of %s", text, list );
    snprintf( want, sizeof want, "one of %s", list );
    return rf_field_must_be( field, want );
}

RfResult rf_field_array( const RfField* field, const char* item, size_t least, size_t most )
{
    size_t count = json_array_size( field->json );
    if ( json_is_array( field->json ) && count >= least && count <= most )
        return rf_json_result( field );
    char want[96];
    snprintf( want, sizeof want, "an array of %zu to %zu %s", least, most, item );
    return rf_field_must_be( field, want );
}

// Members of objects, whose paths are written for errors alone.

// Fails, or has nothing to read.
#define RETURN_UNLESS_GIVEN( object, key )                                                                                       \
    if ( ( object )->error->code != RF_OK || !rf_has_member( object, key ) )                                                     \
    return ( object )->error->code

RfResult rf_get_number( const RfField* object, const char* key, RfRange range, double* value )
{
    RETURN_UNLESS_GIVEN( object, key );
    if ( in_range( object->gltf, json_object_get( object->json, key ), range, value ) )
        return RF_OK;
    RfField member = rf_field_member( object, key );
    return rf_field_number( &member, range, value );
}

RfResult rf_get_numbers( const RfField* object, const char* key, RfRange range, int count, double* values )
{
    RETURN_UNLESS_GIVEN( object, key );
    if ( take_numbers( object->gltf, json_object_get( object->json, key ), range, count, values ) )
        return RF_OK;
    RfField member = rf_field_member( object, key );
    return rf_field_numbers( &member, range, count, values );
}

RfResult rf_get_whole( const RfField* object, const char* key, double low, double high, int* value )
{
    RETURN_UNLESS_GIVEN( object, key );
    RfField member = rf_field_member( object, key );
    return rf_field_whole( &member, low, high, value );
}

RfResult rf_get_integer( const RfField* object, const char* key, int64_t low, int64_t high, int64_t* value )
{
    int64_t integer = 0;
    RETURN_UNLESS_GIVEN( object, key );
    bool whole = rf_json_integer( json_object_get( object->json, key ), &integer );
    if ( whole && integer >= low && integer <= high )
    {
        *value = integer;
        return RF_OK;
    }
    RfField member = rf_field_member( object, key );
    return whole ? rf_field_fail( &member, "must be %lld to %lld, got %lld", (long long)low, (long long)high, (long long)integer )
                 : rf_field_must_be( &member, "an integer" );
}

RfResult rf_get_bool( const RfField* object, const char* key, bool* value )
{
    RETURN_UNLESS_GIVEN( object, key );
    RfField member = rf_field_member( object, key );
    return rf_field_bool( &member, value );
}

RfResult rf_get_text( const RfField* object, const char* key, const char** text )
{
    RETURN_UNLESS_GIVEN( object, key );
    const char* given = json_string_value( json_object_get( object->json, key ) );
    if ( given != NULL && ( given[0] != 0 || object->gltf ) )
    {
        *text = given;
        return RF_OK;
    }
    RfField member = rf_field_member( object, key );
    return rf_field_text( &member, text );
}

RfResult rf_get_choice( const RfField* object, const char* key, const char* const* words, int* index )
{
    RETURN_UNLESS_GIVEN( object, key );
    RfField member = rf_field_member( object, key );
    return rf_field_choice( &member, words, index );
}

static RfField get_container( const RfField* object, const char* key, json_type type, const char* want )
{
    RfField member = rf_field_member( object, key );
    if ( member.json != NULL && json_typeof( member.json ) != type )
    {
        rf_field_must_be( &member, want );
        member.json = NULL;
    }
    member.owner = 0; // what it has is named after it
    return member;
}

RfField rf_get_object( const RfField* object, const char* key ) { return get_container( object, key, JSON_OBJECT, "an object" ); }

RfField rf_get_array( const RfField* object, const char* key ) { return get_container( object, key, JSON_ARRAY, "an array" ); }

json_t* rf_json_text( const char* text )
{
    json_t* json = json_string( text );
    if ( json != NULL )
        return json;
    char* copy = strdup( text );
    for ( char* c = copy; c != NULL && *c != '\0'; ++c )
        *c = (unsigned char)*c >= 0x80 ? '?' : *c;
    json = copy != NULL ? json_string( copy ) : NULL;
    free( copy );
    return json;
}
