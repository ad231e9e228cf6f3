// Tokens of PLY: parses the header, and single values in ASCII or either byte order.
#include "convert/ply_file.h"

#include "base/try.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define MAX_LINE 512
#define MAX_WORDS 6

RfResult rf_ply_fail( const RfPlyFile* file, const char* format, ... )
{
    char text[256], place[64];
    va_list arguments;
    va_start( arguments, format );
    vsnprintf( text, sizeof text, format, arguments );
    va_end( arguments );
    if ( file->line > 0 )
        snprintf( place, sizeof place, "line %llu", (unsigned long long)file->line );
    else
        snprintf( place, sizeof place, "byte %zu", file->at );
    return rf_fail( file->error, RF_ERROR_FORMAT, "%s: %s: %s: not a readable PLY file, write it again", file->path, place,
                    text );
}

// The next line of the header, split into words.
typedef struct Line
{
    char text[MAX_LINE];
    char* words[MAX_WORDS];
    int count;
} Line;

static RfResult next_line( RfPlyFile* file, Line* line )
{
    file->line += 1;
    const uint8_t* from = file->bytes + file->at;
    size_t left = file->size - file->at;
    const uint8_t* end = memchr( from, '\n', left );
    if ( end == NULL )
        return rf_ply_fail( file, "the header has no end_header" );
    size_t length = (size_t)( end - from );
    file->at += length + 1;
    if ( length >= MAX_LINE && memcmp( from, "comment ", 8 ) != 0 && memcmp( from, "obj_info ", 9 ) != 0 )
        return rf_ply_fail( file, "the line is too long" );
    length = length < MAX_LINE ? length : MAX_LINE - 1; // only the first word of a comment matters
    memcpy( line->text, from, length );
    line->text[length] = 0;
    line->count = 0;
    for ( char* at = line->text; line->count < MAX_WORDS; )
    {
        at += strspn( at, " \t\r" );
        if ( *at == 0 )
            break;
        line->words[line->count++] = at;
        at += strcspn( at, " \t\r" );
        if ( *at != 0 )
            *at++ = 0;
    }
    return RF_OK;
}

static bool find_type( const char* word, RfPlyType* type )
{
    static const char* const s_names[RF_PLY_TYPE_COUNT][2] = {
        { "char", "int8" }, { "uchar", "uint8" }, { "short", "int16" },   { "ushort", "uint16" },
        { "int", "int32" }, { "uint", "uint32" }, { "float", "float32" }, { "double", "float64" },
    };
    for ( int i = 0; i < RF_PLY_TYPE_COUNT; ++i )
    {
        if ( strcmp( word, s_names[i][0] ) != 0 && strcmp( word, s_names[i][1] ) != 0 )
            continue;
        *type = (RfPlyType)i;
        return true;
    }
    return false;
}

static RfResult read_format( RfPlyFile* file, const Line* line )
{
    static const char* const s_formats[] = { "ascii", "binary_little_endian", "binary_big_endian" };
    for ( int i = 0; i < 3 && line->count == 3; ++i )
    {
        if ( strcmp( line->words[1], s_formats[i] ) != 0 || strcmp( line->words[2], "1.0" ) != 0 )
            continue;
        file->format = (RfPlyFormat)i;
        return RF_OK;
    }
    return rf_ply_fail( file, "format must be ascii, binary_little_endian or binary_big_endian, and 1.0" );
}

static RfResult copy_name( RfPlyFile* file, const char* word, char name[RF_PLY_NAME] )
{
    if ( strlen( word ) >= RF_PLY_NAME )
        return rf_ply_fail( file, "the name '%.20s...' is too long", word );
    snprintf( name, RF_PLY_NAME, "%s", word );
    return RF_OK;
}

static RfResult read_element( RfPlyFile* file, const Line* line )
{
    if ( line->count != 3 )
        return rf_ply_fail( file, "element must have a name and a count" );
    if ( file->element_count == RF_PLY_MAX_ELEMENTS )
        return rf_ply_fail( file, "more than %d elements", RF_PLY_MAX_ELEMENTS );
    RfPlyElement* element = file->elements + file->element_count;
    *element = ( RfPlyElement ){ 0 };
    const char* digits = line->words[2];
    if ( strspn( digits, "0123456789" ) != strlen( digits ) || strlen( digits ) > 18 )
        return rf_ply_fail( file, "element %.40s: the count '%.20s' is not an integer", line->words[1], digits );
    for ( ; *digits != 0; ++digits )
        element->count = 10 * element->count + (uint64_t)( *digits - '0' );
    file->element_count += 1;
    return copy_name( file, line->words[1], element->name );
}

static RfResult read_property( RfPlyFile* file, const Line* line )
{
    if ( file->element_count == 0 )
        return rf_ply_fail( file, "a property before any element" );
    RfPlyElement* element = file->elements + file->element_count - 1;
    if ( element->property_count == RF_PLY_MAX_PROPERTIES )
        return rf_ply_fail( file, "more than %d properties", RF_PLY_MAX_PROPERTIES );
    RfPlyProperty* p = element->properties + element->property_count;
    *p = ( RfPlyProperty ){ 0 };
    p->is_list = line->count > 1 && strcmp( line->words[1], "list" ) == 0;
    if ( line->count != ( p->is_list ? 5 : 3 ) )
        return rf_ply_fail( file, "property must have a type and a name, or list, two types and a name" );
    const char* type = line->words[line->count - 2];
    if ( !find_type( type, &p->type ) || ( p->is_list && !find_type( line->words[2], &p->count_type ) ) )
        return rf_ply_fail( file, "the type of property %.40s is unknown", line->words[line->count - 1] );
    if ( p->is_list && p->count_type >= RF_PLY_FLOAT32 )
        return rf_ply_fail( file, "the length of list %.40s must have an integer type", line->words[4] );
    element->property_count += 1;
    return copy_name( file, line->words[line->count - 1], p->name );
}

static RfResult read_line( RfPlyFile* file, const Line* line, bool* has_format )
{
    const char* word = line->count > 0 ? line->words[0] : "";
    if ( strcmp( word, "comment" ) == 0 || strcmp( word, "obj_info" ) == 0 )
        return RF_OK;
    if ( strcmp( word, "format" ) == 0 )
    {
        if ( *has_format )
            return rf_ply_fail( file, "a second format" );
        *has_format = true;
        return read_format( file, line );
    }
    if ( strcmp( word, "element" ) == 0 )
        return read_element( file, line );
    if ( strcmp( word, "property" ) == 0 )
        return read_property( file, line );
    return rf_ply_fail( file, "'%.40s' is not a keyword of a header", word );
}

RfResult rf_ply_read_header( RfPlyFile* file )
{
    Line line;
    bool has_format = false;
    RF_TRY( next_line( file, &line ) );
    if ( line.count != 1 || strcmp( line.words[0], "ply" ) != 0 )
        return rf_ply_fail( file, "does not begin with 'ply'" );
    RF_TRY( next_line( file, &line ) );
    while ( line.count != 1 || strcmp( line.words[0], "end_header" ) != 0 )
    {
        RF_TRY( read_line( file, &line, &has_format ) );
        RF_TRY( next_line( file, &line ) );
    }
    if ( !has_format )
        return rf_ply_fail( file, "the header has no format" );
    file->line = file->format == RF_PLY_ASCII ? file->line + 1 : 0;
    return RF_OK;
}

#define MAX_WORD 64

static const uint8_t s_sizes[RF_PLY_TYPE_COUNT] = { 1, 1, 2, 2, 4, 4, 4, 8 };

static const char* const s_type_names[RF_PLY_TYPE_COUNT] = {
    "char", "uchar", "short", "ushort", "int", "uint", "float", "double"
};

// The minimum size of a value: in ASCII a digit and a separator.
static uint64_t least_bytes( const RfPlyFile* file, RfPlyType type ) { return file->format == RF_PLY_ASCII ? 2 : s_sizes[type]; }

static bool is_space( uint8_t c ) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

// Parses the digits before and after the point as one number, times a power of ten. False if
// the word is not a number.
static bool parse_decimal( const char* word, double* value )
{
    static const double s_tens[] = { 1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                     1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22 };
    const char* at = word + ( *word == '-' || *word == '+' );
    uint64_t digits = 0;
    int count = 0, exponent = 0, seen = 0;
    bool point = false;
    for ( ;; ++at )
    {
        if ( *at == '.' && !point )
        {
            point = true;
            continue;
        }
        if ( *at < '0' || *at > '9' )
            break;
        ++seen;
        if ( count < 18 )
        {
            digits = 10 * digits + (uint64_t)( *at - '0' );
            count += digits > 0;
            exponent -= point;
        }
        else
            exponent += !point;
    }
    if ( seen == 0 )
        return false;
    if ( *at == 'e' || *at == 'E' )
    {
        ++at;
        bool negative = *at == '-';
        at += *at == '-' || *at == '+';
        int power = 0, power_digits = 0;
        for ( ; *at >= '0' && *at <= '9' && power_digits < 6; ++at, ++power_digits )
            power = 10 * power + ( *at - '0' );
        if ( power_digits == 0 )
            return false;
        exponent += negative ? -power : power;
    }
    double v = (double)digits;
    if ( exponent >= 0 && exponent <= 22 )
        v *= s_tens[exponent];
    else if ( exponent < 0 && exponent >= -22 )
        v /= s_tens[-exponent];
    else if ( v != 0.0 )
        v = exp( log( v ) + exponent * 2.302585092994045684 ); // beyond the range of any model: precision does not matter
    *value = *word == '-' ? -v : v;
    return *at == 0;
}

static RfResult read_word( RfPlyFile* file, char word[MAX_WORD] )
{
    while ( file->at < file->size && is_space( file->bytes[file->at] ) )
        file->line += file->bytes[file->at++] == '\n';
    size_t length = 0;
    while ( file->at < file->size && !is_space( file->bytes[file->at] ) )
    {
        if ( length == MAX_WORD - 1 )
            return rf_ply_fail( file, "a number of more than %d characters", MAX_WORD - 1 );
        word[length++] = (char)file->bytes[file->at++];
    }
    word[length] = 0;
    if ( strlen( word ) != length )
        return rf_ply_fail( file, "a zero byte in text" );
    return length > 0 ? RF_OK : rf_ply_fail( file, "it ends too early" );
}

static double decode( RfPlyType type, const uint8_t* bytes )
{
    union
    {
        int8_t i8;
        uint8_t u8;
        int16_t i16;
        uint16_t u16;
        int32_t i32;
        uint32_t u32;
        float f32;
        double f64;
    } v;
    memcpy( &v, bytes, s_sizes[type] );
    switch ( type )
    {
        case RF_PLY_INT8: return v.i8;
        case RF_PLY_UINT8: return v.u8;
        case RF_PLY_INT16: return v.i16;
        case RF_PLY_UINT16: return v.u16;
        case RF_PLY_INT32: return v.i32;
        case RF_PLY_UINT32: return v.u32;
        case RF_PLY_FLOAT32: return (double)v.f32;
        case RF_PLY_FLOAT64: return v.f64;
        case RF_PLY_TYPE_COUNT: break;
    }
    return 0.0;
}

static bool fits( RfPlyType type, double value )
{
    double half = ldexp( 1.0, 8 * s_sizes[type] - 1 ); // half the number of values
    bool is_signed = type == RF_PLY_INT8 || type == RF_PLY_INT16 || type == RF_PLY_INT32;
    return is_signed ? value >= -half && value < half : value >= 0.0 && value < 2.0 * half;
}

RfResult rf_ply_read_value( RfPlyFile* file, RfPlyType type, double* value )
{
    if ( file->format == RF_PLY_ASCII )
    {
        char word[MAX_WORD];
        RF_TRY( read_word( file, word ) );
        if ( !parse_decimal( word, value ) )
            return rf_ply_fail( file, "'%.40s' is not a number", word );
        if ( type < RF_PLY_FLOAT32 && *value != floor( *value ) )
            return rf_ply_fail( file, "'%.40s' is not an integer", word );
        return type >= RF_PLY_FLOAT32 || fits( type, *value )
                   ? RF_OK
                   : rf_ply_fail( file, "'%.40s' does not fit into %s", word, s_type_names[type] );
    }
    size_t size = s_sizes[type];
    if ( file->size - file->at < size )
        return rf_ply_fail( file, "it ends too early" );
    uint8_t bytes[8];
    for ( size_t i = 0; i < size; ++i )
        bytes[i] = file->bytes[file->at + ( file->format == RF_PLY_BIG_ENDIAN ? size - 1 - i : i )];
    *value = decode( type, bytes );
    file->at += size;
    return RF_OK;
}

RfResult rf_ply_read_count( RfPlyFile* file, const RfPlyProperty* property, uint32_t* count )
{
    double value = 0.0;
    RF_TRY( rf_ply_read_value( file, property->count_type, &value ) );
    uint64_t room = ( file->size - file->at + 1 ) / least_bytes( file, property->type );
    if ( !( value >= 0.0 && value <= (double)room && value < 4294967295.0 ) )
        return rf_ply_fail( file, "list %s has a length of %.0f, which is negative or more than the file holds", property->name,
                            value );
    *count = (uint32_t)value;
    return RF_OK;
}

RfResult rf_ply_check_element( const RfPlyFile* file, const RfPlyElement* element )
{
    uint64_t bytes = 0, left = file->size - file->at + 1; // the last word of an ASCII file needs no separator
    for ( int i = 0; i < element->property_count; ++i )
        bytes +=
            least_bytes( file, element->properties[i].is_list ? element->properties[i].count_type : element->properties[i].type );
    if ( bytes > 0 && element->count > left / bytes )
        return rf_ply_fail( file, "%llu of element %s need more than the %zu bytes that are left",
                            (unsigned long long)element->count, element->name, file->size - file->at );
    return RF_OK;
}

RfResult rf_ply_skip( RfPlyFile* file, const RfPlyProperty* property )
{
    uint32_t count = 1;
    double value;
    RF_TRY( property->is_list ? rf_ply_read_count( file, property, &count ) : RF_OK );
    for ( uint32_t i = 0; i < count; ++i )
        RF_TRY( rf_ply_read_value( file, property->type, &value ) );
    return RF_OK;
}

RfResult rf_ply_check_end( RfPlyFile* file )
{
    while ( file->format == RF_PLY_ASCII && file->at < file->size && is_space( file->bytes[file->at] ) )
        file->line += file->bytes[file->at++] == '\n';
    if ( file->at == file->size )
        return RF_OK;
    return rf_ply_fail( file, "%zu bytes follow the last element: the header's counts do not fit the data",
                        file->size - file->at );
}
