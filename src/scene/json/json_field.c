// Typed values of our own JSON files, and the keys that an object may have.
#include "base/words.h"
#include "scene/json/json_document.h"

#include <stdio.h>
#include <string.h>

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
    char list[512];
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
        return rf_field_wants( object, "an object" );
    const char* key;
    json_t* value;
    json_object_foreach( (json_t*)object->json, key, value )
    {
        if ( object->notes && ( strcmp( key, "$schema" ) == 0 || strcmp( key, "about" ) == 0 ) )
        {
            RfField member = rf_field_member( object, key );
            if ( !json_is_string( value ) )
                return rf_field_wants( &member, "a string" );
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
        return rf_field_wants( field, want );
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
        return rf_field_wants( field, want );
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
        return rf_field_wants( field, "true or false" );
    *value = json_is_true( field->json );
    return RF_OK;
}

RfResult rf_field_text( const RfField* field, const char** text )
{
    if ( field->json == NULL )
        return RF_OK;
    if ( !json_is_string( field->json ) || json_string_length( field->json ) == 0 )
        return rf_field_wants( field, "a string that is not empty" );
    *text = json_string_value( field->json );
    return RF_OK;
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
    return rf_field_wants( field, want );
}

RfResult rf_field_array( const RfField* field, const char* item, size_t least, size_t most )
{
    size_t count = json_array_size( field->json );
    if ( json_is_array( field->json ) && count >= least && count <= most )
        return RF_OK;
    char want[96];
    snprintf( want, sizeof want, "an array of %zu to %zu %s", least, most, item );
    return rf_field_wants( field, want );
}
