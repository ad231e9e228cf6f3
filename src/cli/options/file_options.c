// Turns the `render` object of a scene file into option values: by the same table, and errors with the JSON path.
#include "cli/options/file_options.h"

#include "base/words.h"

#include <string.h>

#define MAX_KEYS 64

// The key of an option in a file. Names have at most 30 characters.
static const char* key_of( const RfOption* option, char key[32] )
{
    snprintf( key, 32, "%s", option->name );
    for ( char* c = key; *c != 0; ++c )
        *c = *c == '-' ? '_' : *c;
    return key;
}

// A number as it would be written on the command line.
static bool print_number( const json_t* json, char* text, size_t size )
{
    int64_t whole;
    if ( rf_json_integer( json, &whole ) )
        snprintf( text, size, "%lld", (long long)whole );
    else if ( json_is_real( json ) )
        snprintf( text, size, "%.9g", json_real_value( json ) );
    else
        return false;
    return true;
}

static bool print_size( const json_t* json, char* text, size_t size )
{
    char side[2][32];
    if ( json_array_size( json ) != 2 || !print_number( json_array_get( json, 0 ), side[0], sizeof side[0] ) ||
         !print_number( json_array_get( json, 1 ), side[1], sizeof side[1] ) )
        return false;
    snprintf( text, size, "%sx%s", side[0], side[1] );
    return true;
}

static bool is_same( const char* text, const char* word ) { return word != NULL && strcmp( text, word ) == 0; }

// The value as it would be written on the command line; NULL where its JSON type is wrong.
static const char* to_text( const RfOption* option, const json_t* json, char* text, size_t size )
{
    const char* string = json_string_value( json );
    switch ( option->type )
    {
        case RF_OPTION_INT:
            if ( string != NULL && is_same( string, option->keyword ) )
                return string;
            return print_number( json, text, size ) ? text : NULL;
        case RF_OPTION_REAL:
            if ( string != NULL && ( is_same( string, option->keyword ) || is_same( string, option->negated ) ) )
                return string;
            return print_number( json, text, size ) ? text : NULL;
        case RF_OPTION_NOISE:
            if ( string != NULL && strchr( string, '%' ) != NULL )
                return string;
            return print_number( json, text, size ) ? text : NULL;
        case RF_OPTION_UINT64:
        case RF_OPTION_TIME: return print_number( json, text, size ) ? text : NULL;
        case RF_OPTION_SIZE: return print_size( json, text, size ) ? text : NULL;
        case RF_OPTION_FPS: return string != NULL ? string : print_number( json, text, size ) ? text : NULL;
        case RF_OPTION_CHOICE: return json_is_true( json ) ? option->bare : json_is_false( json ) ? option->negated : string;
        case RF_OPTION_MEMORY:
        case RF_OPTION_STRING: return string;
        case RF_OPTION_BOOL: return NULL;
    }
    return NULL;
}

// What JSON values an option accepts, by its min and max.
static const char* const s_wanted[] = {
    [RF_OPTION_INT] = "a whole number from %.0f to %.0f",
    [RF_OPTION_UINT64] = "a whole number from 0 to 9223372036854775807",
    [RF_OPTION_REAL] = "a number from %g to %g",
    [RF_OPTION_NOISE] = "a relMSE from %g to %g, or the noise of a channel in percent, such as \"5%%\"",
    [RF_OPTION_TIME] = "a number from %g to %g",
    [RF_OPTION_SIZE] = "an array of width and height, such as [960, 540], each a whole number from %.0f to %.0f",
    [RF_OPTION_FPS] = "a whole number from 1 to 1000000, 29.97 and the like, or a string such as \"24000/1001\"",
    [RF_OPTION_CHOICE] = "one of ",
    [RF_OPTION_MEMORY] = "a string such as \"512M\" or \"4G\", at least %.0f bytes",
    [RF_OPTION_STRING] = "a string that is not empty",
    [RF_OPTION_BOOL] = "true or false",
};

static RfResult take( const RfOption* option, const RfField* field )
{
    if ( option->type == RF_OPTION_BOOL )
        return rf_field_bool( field, option->value );
    char buffer[80], want[256] = "", side[2][32];
    const char* text = to_text( option, field->json, buffer, sizeof buffer );
    if ( text != NULL && rf_parse_option_value( option, text, NULL ) == RF_OK )
        return RF_OK;
    if ( option->bare != NULL )
        rf_append( want, sizeof want, "true, false, or " );
    rf_describe_wanted( option, s_wanted[option->type], "\"", want, sizeof want );
    if ( option->type == RF_OPTION_CHOICE )
        rf_append_words( want, sizeof want, option->choices, ", ", ", " );
    if ( option->type != RF_OPTION_SIZE || text == NULL )
        return rf_field_must_be( field, want );
    for ( size_t i = 0; i < 2; ++i ) // two numbers
        print_number( json_array_get( field->json, i ), side[i], sizeof side[i] );
    return rf_field_fail( field, "must be %s, got [%s, %s]", want, side[0], side[1] );
}

RfResult rf_fail_file_option( const RfField* field, const RfError* error )
{
    const char* rest = strncmp( error->text, "--", 2 ) == 0 ? strstr( error->text, ": " ) : NULL;
    return rf_field_fail( field, "%s", rest != NULL ? rest + 2 : error->text );
}

RfResult rf_take_file_options( const RfCommandTable* table, const RfField* object )
{
    char names[MAX_KEYS][32];
    const char* keys[MAX_KEYS + 1] = { NULL };
    const RfOption* options[MAX_KEYS];
    int count = 0;
    for ( int i = 0; i < table->option_count; ++i )
    {
        if ( !table->options[i].in_file )
            continue;
        if ( count == MAX_KEYS )
            return rf_field_fail( object, "the table of options has more than %d keys for files", MAX_KEYS );
        keys[count] = key_of( table->options + i, names[count] );
        options[count++] = table->options + i;
    }
    if ( object->json == NULL )
        return RF_OK;
    RfResult result = rf_field_keys( object, keys );
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        RfField field = rf_field_member( object, keys[i] );
        if ( field.json != NULL )
            result = take( options[i], &field );
    }
    return result;
}
