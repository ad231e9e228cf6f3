#include "convert/ply_file.h"

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
    return rf_ply_fail( file, "format wants ascii, binary_little_endian or binary_big_endian, and 1.0" );
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
        return rf_ply_fail( file, "element wants a name and a count" );
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
        return rf_ply_fail( file, "property wants a type and a name, or list, two types and a name" );
    const char* type = line->words[line->count - 2];
    if ( !find_type( type, &p->type ) || ( p->is_list && !find_type( line->words[2], &p->count_type ) ) )
        return rf_ply_fail( file, "the type of property %.40s is unknown", line->words[line->count - 1] );
    if ( p->is_list && p->count_type >= RF_PLY_FLOAT32 )
        return rf_ply_fail( file, "the length of list %.40s wants an integer type", line->words[4] );
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
    RfResult result = next_line( file, &line );
    if ( result == RF_OK && ( line.count != 1 || strcmp( line.words[0], "ply" ) != 0 ) )
        return rf_ply_fail( file, "does not begin with 'ply'" );
    while ( result == RF_OK )
    {
        result = next_line( file, &line );
        if ( result == RF_OK && line.count == 1 && strcmp( line.words[0], "end_header" ) == 0 )
            break;
        if ( result == RF_OK )
            result = read_line( file, &line, &has_format );
    }
    if ( result == RF_OK && !has_format )
        return rf_ply_fail( file, "the header has no format" );
    file->line = file->format == RF_PLY_ASCII ? file->line + 1 : 0;
    return result;
}
