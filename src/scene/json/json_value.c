#include "scene/json/json_value.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>

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
    rf_describe_json( *root, got, sizeof got );
    json_decref( *root );
    *root = NULL;
    return rf_fail( error, RF_ERROR_FORMAT, "%s: %swants an object, got %s", path, where, got );
}

void rf_describe_json( const json_t* json, char* text, size_t size )
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
