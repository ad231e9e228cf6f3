// Reads IES files (ANSI/IES LM-63 of 1986, 1991, 1995 and 2002), which differ in their first lines only.
#include "scene/profile.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

typedef struct Reader
{
    const char* path;
    const char *at, *end;
    int line;
    RfError* error;
} Reader;

static RfResult fail( const Reader* r, RfResult code, const char* what )
{
    return rf_fail( r->error, code, "%s: line %d: %s", r->path, r->line, what );
}

static bool is_space( char c ) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ',' || c == '\v' || c == '\f'; }

// Numbers are parted by white space or commas.
static RfResult read_number( Reader* r, const char* what, double* value )
{
    char word[64], *end;
    size_t length = 0;
    for ( ; r->at < r->end && is_space( *r->at ); ++r->at )
        r->line += *r->at == '\n';
    for ( ; r->at < r->end && !is_space( *r->at ) && length + 1 < sizeof word; ++r->at )
        word[length++] = *r->at;
    word[length] = '\0';
    if ( length == 0 )
        return rf_fail( r->error, RF_ERROR_FORMAT, "%s: it ends where %s is expected", r->path, what );
    *value = strtod( word, &end );
    bool is_cut = r->at < r->end && !is_space( *r->at );
    if ( is_cut || *end != '\0' || !isfinite( *value ) || strpbrk( word, "xXpP" ) != NULL )
        return rf_fail( r->error, RF_ERROR_FORMAT, "%s: line %d: %s must be a number", r->path, r->line, what );
    return RF_OK;
}

static RfResult read_count( Reader* r, const char* what, int most, int* count )
{
    double value = 0.0;
    RfResult result = read_number( r, what, &value );
    if ( result == RF_OK && !( value >= 1.0 && value <= (double)most && value == floor( value ) ) )
        return rf_fail( r->error, RF_ERROR_FORMAT, "%s: line %d: %s is %g: must be 1 to %d", r->path, r->line, what, value,
                        most );
    *count = result == RF_OK ? (int)value : 0;
    return result;
}

static RfResult skip( Reader* r, const char* what, int count )
{
    double value;
    RfResult result = RF_OK;
    for ( int i = 0; i < count && result == RF_OK; ++i )
        result = read_number( r, what, &value );
    return result;
}

// The rest of the line that begins with "TILT=": keywords come before it.
static RfResult find_tilt( Reader* r, bool* included )
{
    while ( r->end - r->at >= 5 && memcmp( r->at, "TILT=", 5 ) != 0 )
    {
        const char* next = memchr( r->at, '\n', (size_t)( r->end - r->at ) );
        r->at = next != NULL ? next + 1 : r->end;
        ++r->line;
    }
    if ( r->end - r->at < 5 )
        return rf_fail( r->error, RF_ERROR_FORMAT, "%s: not an IES file: no line begins with TILT=", r->path );
    const char *word = r->at + 5, *end = memchr( word, '\n', (size_t)( r->end - word ) );
    r->at = end != NULL ? end : r->end;
    size_t length = (size_t)( r->at - word );
    while ( length > 0 && is_space( word[length - 1] ) )
        --length;
    *included = length == 7 && memcmp( word, "INCLUDE", 7 ) == 0;
    if ( !*included && !( length == 4 && memcmp( word, "NONE", 4 ) == 0 ) )
        return fail( r, RF_ERROR_UNSUPPORTED, "TILT names another file: write TILT=NONE" );
    return RF_OK;
}

static RfResult skip_tilt( Reader* r )
{
    int count = 0;
    RfResult result = skip( r, "the lamp's geometry", 1 );
    if ( result == RF_OK )
        result = read_count( r, "the number of tilts", RF_PROFILE_ANGLES, &count );
    return result == RF_OK ? skip( r, "a tilt", 2 * count ) : result;
}

// The line of ten numbers and that of three. `factor`: of all intensities.
static RfResult read_head( Reader* r, RfProfileTable* t, double* factor )
{
    double type = 0.0, ballast = 1.0, lamps = 1.0;
    RfResult result = skip( r, "the number of lamps or their lumens", 2 );
    if ( result == RF_OK )
        result = read_number( r, "the multiplier", factor );
    if ( result == RF_OK )
        result = read_count( r, "the number of vertical angles", RF_PROFILE_ANGLES, &t->rows );
    if ( result == RF_OK )
        result = read_count( r, "the number of horizontal angles", RF_PROFILE_ANGLES, &t->columns );
    if ( result == RF_OK )
        result = read_number( r, "the type of photometry", &type );
    if ( result == RF_OK && type != 1.0 )
        return fail( r, RF_ERROR_UNSUPPORTED, "only photometry of type C (1) is read: convert the file" );
    if ( result == RF_OK )
        result = skip( r, "the size of the luminaire", 4 );
    if ( result == RF_OK )
        result = read_number( r, "the ballast factor", &ballast );
    if ( result == RF_OK )
        result = read_number( r, "the ballast-lamp factor", &lamps );
    if ( result == RF_OK )
        result = skip( r, "the watts", 1 );
    *factor *= ballast * lamps;
    if ( result == RF_OK && t->rows * t->columns > RF_PROFILE_VALUES )
        return fail( r, RF_ERROR_UNSUPPORTED, "it has more than a million intensities" );
    return result;
}

static RfResult read_numbers( Reader* r, const char* what, double factor, int count, double* out )
{
    RfResult result = RF_OK;
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        result = read_number( r, what, out + i );
        if ( result == RF_OK )
            out[i] *= factor;
    }
    return result;
}

static RfResult read_table( Reader* r, RfProfileTable* t, double factor )
{
    t->vertical = malloc( (size_t)t->rows * sizeof *t->vertical );
    t->horizontal = malloc( (size_t)t->columns * sizeof *t->horizontal );
    t->value = malloc( (size_t)( t->rows * t->columns ) * sizeof *t->value );
    if ( t->vertical == NULL || t->horizontal == NULL || t->value == NULL )
        return rf_fail( r->error, RF_ERROR_MEMORY, "%s: out of memory for its %d intensities", r->path, t->rows * t->columns );
    RfResult result = read_numbers( r, "a vertical angle", 1.0, t->rows, t->vertical );
    if ( result == RF_OK )
        result = read_numbers( r, "a horizontal angle", 1.0, t->columns, t->horizontal );
    return result == RF_OK ? read_numbers( r, "an intensity", factor, t->rows * t->columns, t->value ) : result;
}

RfResult rf_read_ies( const char* path, const void* bytes, size_t size, RfProfile** out, RfError* error )
{
    Reader reader = { path, bytes, (const char*)bytes + size, 1, error };
    RfProfileTable table = { 0 };
    bool included = false;
    double factor = 1.0;
    *out = NULL;
    RfResult result = size > 0 ? find_tilt( &reader, &included ) : rf_fail( error, RF_ERROR_FORMAT, "%s: it is empty", path );
    if ( result == RF_OK && included )
        result = skip_tilt( &reader );
    if ( result == RF_OK )
        result = read_head( &reader, &table, &factor );
    if ( result == RF_OK )
        result = read_table( &reader, &table, factor );
    if ( result == RF_OK )
        result = rf_make_profile( path, &table, out, error );
    free( table.vertical );
    free( table.horizontal );
    free( table.value );
    return result;
}
