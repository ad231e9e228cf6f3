#include "cli/options/options.h"

#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

bool rf_parse_whole( const char* text, long long min, long long max, long long* value )
{
    // strtoll skips blanks and takes a plus sign; a number on a command line has neither.
    if ( !isdigit( (unsigned char)text[text[0] == '-'] ) )
        return false;
    char* end;
    errno = 0;
    long long number = strtoll( text, &end, 10 );
    if ( errno != 0 || *end != '\0' || number < min || number > max )
        return false;
    *value = number;
    return true;
}

static bool parse_unsigned( const char* text, uint64_t* value )
{
    if ( !isdigit( (unsigned char)text[0] ) )
        return false;
    char* end;
    errno = 0;
    unsigned long long number = strtoull( text, &end, 10 );
    if ( errno != 0 || *end != '\0' )
        return false;
    *value = number;
    return true;
}

// A decimal number at the start of `text`: no hexadecimal, no "inf" or "nan".
static bool parse_decimal( const char* text, double* value, const char** rest )
{
    size_t length = strspn( text, "+-0123456789.eE" );
    if ( length == 0 || length > 60 || isspace( (unsigned char)text[0] ) )
        return false;
    char copy[64];
    memcpy( copy, text, length );
    copy[length] = '\0';
    char* end;
    *value = strtod( copy, &end );
    *rest = text + ( end - copy );
    return end != copy && isfinite( *value );
}

static bool parse_real( const RfOption* option, const char* text, double* value )
{
    const char* rest;
    double number;
    if ( !parse_decimal( text, &number, &rest ) || *rest != '\0' || number < option->min || number > option->max )
        return false;
    *value = number;
    return true;
}

static bool parse_ratio( const RfOption* option, const char* text, double* value )
{
    const char* rest;
    double number;
    if ( !parse_decimal( text, &number, &rest ) )
        return false;
    if ( *rest == '%' )
        number /= 100.0;
    if ( rest[*rest == '%'] != '\0' || number < option->min || number > option->max )
        return false;
    *value = number;
    return true;
}

// Seconds, or hours, minutes and seconds in this order, each with its letter.
static bool parse_time( const RfOption* option, const char* text, double* value )
{
    static const struct
    {
        char letter;
        double seconds;
    } units[] = { { 'h', 3600.0 }, { 'm', 60.0 }, { 's', 1.0 } };
    double number, sum = 0.0;
    const char* rest = text;
    if ( parse_real( option, text, value ) )
        return true;
    for ( size_t i = 0; i < sizeof units / sizeof units[0] && *rest != '\0'; ++i )
    {
        const char* next;
        if ( !isdigit( (unsigned char)*rest ) || !parse_decimal( rest, &number, &next ) )
            return false;
        if ( *next != units[i].letter )
            continue;
        sum += number * units[i].seconds;
        rest = next + 1;
    }
    if ( rest == text || *rest != '\0' || sum < option->min || sum > option->max )
        return false;
    *value = sum;
    return true;
}

static bool parse_memory( const RfOption* option, const char* text, size_t* value )
{
    const char* rest;
    double number;
    if ( !isdigit( (unsigned char)text[0] ) || !parse_decimal( text, &number, &rest ) )
        return false;
    static const char units[] = "KMGT";
    if ( *rest != '\0' )
    {
        const char* unit = strchr( units, toupper( (unsigned char)*rest ) );
        if ( unit == NULL || rest[1] != '\0' )
            return false;
        number = ldexp( number, 10 * (int)( unit - units + 1 ) );
    }
    // 2^62 bytes are more than any machine has, and far from overflow.
    if ( number < option->min || number > 0x1p62 )
        return false;
    *value = (size_t)number;
    return true;
}

// Two whole numbers with a separator between them.
static bool parse_pair( const char* text, char separator, long long min, long long max, int* first, int* second )
{
    const char* middle = strchr( text, separator );
    if ( middle == NULL || middle - text > 20 )
        return false;
    char head[24];
    memcpy( head, text, (size_t)( middle - text ) );
    head[middle - text] = '\0';
    long long a, b;
    if ( !rf_parse_whole( head, min, max, &a ) || !rf_parse_whole( middle + 1, min, max, &b ) )
        return false;
    *first = (int)a;
    *second = (int)b;
    return true;
}

// Names of sizes, all 16:9.
static bool parse_size( const RfOption* option, const char* text, RfSize* size )
{
    static const struct
    {
        const char* name;
        RfSize size;
    } names[] = {
        { "360p", { 640, 360 } },    { "540p", { 960, 540 } },    { "720p", { 1280, 720 } }, { "1080p", { 1920, 1080 } },
        { "1440p", { 2560, 1440 } }, { "2160p", { 3840, 2160 } }, { "4k", { 3840, 2160 } },  { "4K", { 3840, 2160 } },
    };
    for ( size_t i = 0; i < sizeof names / sizeof names[0]; ++i )
    {
        if ( strcmp( text, names[i].name ) == 0 && names[i].size.width <= option->max )
        {
            *size = names[i].size;
            return true;
        }
    }
    return parse_pair( text, 'x', (long long)option->min, (long long)option->max, &size->width, &size->height );
}

static bool parse_fps( const char* text, RfFps* fps )
{
    RfFps parsed = { 0, 1 };
    long long whole;
    if ( rf_parse_whole( text, 1, 1000000, &whole ) )
        parsed.numerator = (int)whole;
    else if ( !parse_pair( text, '/', 1, 100000000, &parsed.numerator, &parsed.denominator ) )
        return false;
    *fps = parsed;
    return true;
}

static bool parse_int( const RfOption* option, const char* text, int* value )
{
    if ( option->keyword != NULL && strcmp( text, option->keyword ) == 0 )
    {
        *value = option->keyword_value;
        return true;
    }
    long long whole;
    if ( !rf_parse_whole( text, (long long)option->min, (long long)option->max, &whole ) )
        return false;
    *value = (int)whole;
    return true;
}

static bool parse_choice( const RfOption* option, const char* text, int* value )
{
    for ( int i = 0; option->choices[i] != NULL; ++i )
    {
        if ( strcmp( text, option->choices[i] ) == 0 )
        {
            *value = i;
            return true;
        }
    }
    return false;
}

bool rf_is_choice( const RfOption* option, const char* text )
{
    int unused;
    return parse_choice( option, text, &unused );
}

// Describes the values that an option accepts.
static void describe_choices( const RfOption* option, char* words, size_t size )
{
    size_t used = (size_t)snprintf( words, size, "one of" );
    for ( int i = 0; option->choices[i] != NULL && used < size; ++i )
    {
        const char* comma = option->choices[i + 1] != NULL && i > 0 ? "," : i > 0 ? " or" : "";
        used += (size_t)snprintf( words + used, size - used, "%s %s", comma, option->choices[i] );
    }
}

static void describe_wanted( const RfOption* option, char* words, size_t size )
{
    switch ( option->type )
    {
        case RF_OPTION_INT:
            snprintf( words, size, "a whole number from %.0f to %.0f%s%s", option->min, option->max,
                      option->keyword != NULL ? " or " : "", option->keyword != NULL ? option->keyword : "" );
            break;
        case RF_OPTION_UINT64: snprintf( words, size, "a whole number from 0 to %llu", (unsigned long long)UINT64_MAX ); break;
        case RF_OPTION_REAL: snprintf( words, size, "a number from %g to %g", option->min, option->max ); break;
        case RF_OPTION_RATIO:
            snprintf( words, size, "a number from %g to %g, or percent such as 1%%", option->min, option->max );
            break;
        case RF_OPTION_TIME:
            snprintf( words, size, "seconds from %g to %g, or a time such as 20s, 5m or 1h30m", option->min, option->max );
            break;
        case RF_OPTION_SIZE:
            snprintf( words, size, "WIDTHxHEIGHT, such as 960x540, each from %.0f to %.0f, or 720p, 1080p, 1440p, 2160p or 4k",
                      option->min, option->max );
            break;
        case RF_OPTION_MEMORY:
            snprintf( words, size, "a size such as 512M, 4G or 1.5G, at least %.0f bytes", option->min );
            break;
        case RF_OPTION_FPS: snprintf( words, size, "frames per second, such as 24 or 24000/1001" ); break;
        case RF_OPTION_CHOICE: describe_choices( option, words, size ); break;
        case RF_OPTION_STRING: snprintf( words, size, "a value that is not empty" ); break;
        case RF_OPTION_BOOL: snprintf( words, size, "no value" ); break;
    }
}

static bool parse_value( const RfOption* option, const char* text )
{
    switch ( option->type )
    {
        case RF_OPTION_INT: return parse_int( option, text, option->value );
        case RF_OPTION_UINT64: return parse_unsigned( text, option->value );
        case RF_OPTION_REAL: return parse_real( option, text, option->value );
        case RF_OPTION_RATIO: return parse_ratio( option, text, option->value );
        case RF_OPTION_TIME: return parse_time( option, text, option->value );
        case RF_OPTION_SIZE: return parse_size( option, text, option->value );
        case RF_OPTION_MEMORY: return parse_memory( option, text, option->value );
        case RF_OPTION_FPS: return parse_fps( text, option->value );
        case RF_OPTION_CHOICE: return parse_choice( option, text, option->value );
        case RF_OPTION_STRING: *(const char**)option->value = text; return text[0] != '\0';
        case RF_OPTION_BOOL: return false;
    }
    return false;
}

RfResult rf_parse_option_value( const RfOption* option, const char* text, RfError* error )
{
    if ( parse_value( option, text ) )
        return RF_OK;
    char wanted[256];
    describe_wanted( option, wanted, sizeof wanted );
    return rf_fail( error, RF_ERROR_USAGE, "--%s: wants %s, got '%s'", option->name, wanted, text );
}
