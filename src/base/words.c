// Ends of names, sets of words; the nearest word by Levenshtein's edit distance, for suggestions in error messages.
#include "base/words.h"

#include <stdio.h>
#include <stdarg.h>
#include <string.h>
#include <strings.h>

void rf_append( char* text, size_t size, const char* format, ... )
{
    size_t used = strlen( text );
    va_list args;
    va_start( args, format );
    if ( used < size )
        vsnprintf( text + used, size - used, format, args );
    va_end( args );
}

void rf_append_words( char* text, size_t size, const char* const* words, const char* between, const char* last )
{
    for ( int i = 0; words[i] != NULL; ++i )
        rf_append( text, size, "%s%s", i == 0 ? "" : words[i + 1] != NULL ? between : last, words[i] );
}

bool rf_ends_with( const char* text, const char* end )
{
    size_t length = strlen( text ), end_length = strlen( end );
    return length > end_length && strcmp( text + length - end_length, end ) == 0;
}

bool rf_has_extension( const char* path, const char* extension )
{
    size_t length = strlen( path ), end_length = strlen( extension );
    return length > end_length && strcasecmp( path + length - end_length, extension ) == 0;
}

static int edit_distance( const char* a, const char* b )
{
    enum
    {
        LONGEST = 31
    };
    size_t a_length = strlen( a ), b_length = strlen( b );
    if ( a_length > LONGEST || b_length > LONGEST )
        return LONGEST;
    int row[LONGEST + 1];
    for ( size_t j = 0; j <= b_length; ++j )
        row[j] = (int)j;
    for ( size_t i = 1; i <= a_length; ++i )
    {
        int diagonal = row[0];
        row[0] = (int)i;
        for ( size_t j = 1; j <= b_length; ++j )
        {
            int replace = diagonal + ( a[i - 1] != b[j - 1] );
            int other = ( row[j] < row[j - 1] ? row[j] : row[j - 1] ) + 1;
            diagonal = row[j];
            row[j] = replace < other ? replace : other;
        }
    }
    return row[b_length];
}

const char* rf_nearest_word( const char* word, const char* const* words, int count )
{
    const char* nearest = NULL;
    int best = (int)strlen( word ) / 3 + 2; // anything farther away is not a misspelling
    for ( int i = 0; i < count; ++i )
    {
        // a prefix is most likely an abbreviation of that word
        bool beginning = strlen( word ) >= 2 && strncmp( word, words[i], strlen( word ) ) == 0;
        int distance = beginning ? 0 : edit_distance( word, words[i] );
        if ( distance < best )
        {
            best = distance;
            nearest = words[i];
        }
    }
    return nearest;
}

RfResult rf_parse_words( const RfWordSet* of, const char* text, unsigned* set, RfError* error )
{
    *set = 0;
    while ( text != NULL )
    {
        char word[32];
        size_t length = strcspn( text, "," );
        unsigned found = 0;
        snprintf( word, sizeof word, "%.*s", (int)( length < 31 ? length : 31 ), text );
        for ( int i = 0; i < of->count; ++i )
            found |= strcmp( word, of->words[i] ) == 0 ? of->bits[i] : 0;
        const char* nearest = found == 0 && length > 0 ? rf_nearest_word( word, of->words, of->count ) : NULL;
        if ( nearest != NULL )
            return rf_fail( error, RF_ERROR_USAGE, "unknown %s '%s', did you mean %s?", of->what, word, nearest );
        if ( found == 0 )
            return rf_fail( error, RF_ERROR_USAGE, "unknown %s '%s', expected %s", of->what, word, of->expected );
        for ( int i = 0; i < of->count; ++i )
        {
            if ( ( of->bits[i] & found & *set ) != 0 )
                return rf_fail( error, RF_ERROR_USAGE, "%s %s is given twice", of->given, of->words[i] );
        }
        *set |= found;
        text = text[length] == ',' ? text + length + 1 : NULL;
    }
    return RF_OK;
}
