// Profiles of lamps: read from IES files, and evaluated.
#include "scene/profile.h"

#include "base/try.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979324
#define DEGREE ( PI / 180.0 )
#define CLOSE 1e-4 // degrees: angles that are closer together floats do not part

static RfResult no_memory( const char* path, RfError* error )
{
    return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its table of intensities", path );
}

void rf_release_profile( RfProfile* profile )
{
    if ( profile == NULL || --profile->references > 0 )
        return;
    free( profile->vertical );
    free( profile->horizontal );
    free( profile->value );
    free( profile );
}

// ---- From a table

static RfResult check_angles( const char* path, const char* kind, int count, const double* angle, double high, RfError* error )
{
    for ( int i = 0; i < count; ++i )
    {
        if ( !( angle[i] >= 0.0 && angle[i] <= high ) )
            return rf_fail( error, RF_ERROR_FORMAT, "%s: its %s angle %d is %g degrees: must be 0 to %g", path, kind, i, angle[i],
                            high );
        if ( i > 0 && !( angle[i] >= angle[i - 1] + CLOSE ) )
            return rf_fail( error, RF_ERROR_FORMAT, "%s: its %s angle %d is %g degrees: must be more than the one before, %g",
                            path, kind, i, angle[i], angle[i - 1] );
    }
    return RF_OK;
}

static RfResult check_table( const char* path, const RfProfileTable* t, RfError* error )
{
    if ( t->rows < 2 || t->columns < 1 )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: it has %d vertical and %d horizontal angles: must be 2 and 1 at least", path,
                        t->rows, t->columns );
    RF_TRY( check_angles( path, "vertical", t->rows, t->vertical, 180.0, error ) );
    RF_TRY( check_angles( path, "horizontal", t->columns, t->horizontal, 360.0, error ) );
    for ( int i = 0; i < t->rows * t->columns; ++i )
    {
        if ( !( t->value[i] >= 0.0 && t->value[i] <= 1e12 ) )
            return rf_fail( error, RF_ERROR_FORMAT, "%s: its intensity %d is %g: must be 0 to 1e12", path, i, t->value[i] );
    }
    return RF_OK;
}

// The columns of a whole turn: which of the table each is, and where.
typedef struct Turn
{
    int count;
    int* of;
    double* at; // degrees
} Turn;

static void append( Turn* turn, double at, int of )
{
    turn->at[turn->count] = at;
    turn->of[turn->count++] = of;
}

// All columns but that at `axis` again, mirrored about it.
static void mirror( Turn* turn, double axis )
{
    for ( int i = turn->count - 2; i >= 0; --i )
        append( turn, 2.0 * axis - turn->at[i], turn->of[i] );
}

// False where the angles do not tell what is between them.
static bool expand( const RfProfileTable* t, Turn* turn )
{
    double first = t->horizontal[0], last = t->horizontal[t->columns - 1];
    if ( t->columns == 1 )
    {
        append( turn, 0.0, 0 );
        append( turn, 360.0, 0 );
        return first == 0.0;
    }
    bool is_turned = first == 90.0 && last == 270.0;
    for ( int i = 0; i < t->columns; ++i )
        append( turn, t->horizontal[i] - ( is_turned ? 90.0 : 0.0 ), i );
    if ( is_turned )
        last = 180.0;
    if ( last == 90.0 )
        mirror( turn, 90.0 );
    if ( last == 90.0 || last == 180.0 )
        mirror( turn, 180.0 );
    else if ( last <= 360.0 - CLOSE && last >= 315.0 )
        append( turn, 360.0, 0 );
    return ( is_turned || first == 0.0 ) && turn->at[turn->count - 1] == 360.0;
}

static RfResult fill_columns( const char* path, const RfProfileTable* t, const Turn* turn, RfProfile* p, RfError* error )
{
    p->rows = t->rows;
    p->columns = turn->count;
    size_t rows = (size_t)p->rows, columns = (size_t)p->columns;
    p->vertical = malloc( rows * sizeof *p->vertical );
    p->horizontal = malloc( columns * sizeof *p->horizontal );
    p->value = malloc( rows * columns * sizeof *p->value );
    if ( p->vertical == NULL || p->horizontal == NULL || p->value == NULL )
        return no_memory( path, error );
    for ( size_t r = 0; r < rows; ++r )
        p->vertical[r] = (float)( t->vertical[r] * DEGREE );
    for ( size_t c = 0; c < columns; ++c )
    {
        p->horizontal[c] = (float)( turn->at[c] * DEGREE );
        for ( size_t r = 0; r < rows; ++r )
        {
            p->value[c * rows + r] = (float)t->value[(size_t)turn->of[c] * rows + r];
            p->most = rf_maxf( p->most, p->value[c * rows + r] );
        }
    }
    return RF_OK;
}

// ∫ ( a + ( b − a ) ( v − v0 ) / ( v1 − v0 ) ) sin v dv from v0 to v1.
static double integrate( double v0, double v1, double a, double b )
{
    double slope = ( b - a ) / ( v1 - v0 );
    return a * cos( v0 ) - b * cos( v1 ) + slope * ( sin( v1 ) - sin( v0 ) );
}

// Of a cell, over 4π: bilinear, so that the mean of both columns is linear.
static double cell_mean( const RfProfile* p, int c, int r )
{
    const float *left = p->value + (size_t)c * (size_t)p->rows, *right = left + p->rows;
    double width = (double)p->horizontal[c + 1] - (double)p->horizontal[c];
    double sum = integrate( (double)p->vertical[r], (double)p->vertical[r + 1], 0.5 * ( (double)left[r] + (double)right[r] ),
                            0.5 * ( (double)left[r + 1] + (double)right[r + 1] ) );
    return fmax( sum, 0.0 ) * width / ( 4.0 * PI );
}

static void find_mean( RfProfile* p )
{
    for ( int c = 0; c + 1 < p->columns; ++c )
    {
        double sum = 0.0;
        for ( int r = 0; r + 1 < p->rows; ++r )
            sum += cell_mean( p, c, r );
        p->mean += sum;
    }
}

// The rows in which some value is above `least`: the angles next to them.
static void find_rows( const RfProfile* p, float least, double* low, double* high )
{
    int first = p->rows, last = -1;
    for ( int r = 0; r < p->rows; ++r )
    {
        bool is_above = false;
        for ( int c = 0; c < p->columns && !is_above; ++c )
            is_above = p->value[(size_t)c * (size_t)p->rows + (size_t)r] > least;
        first = is_above && r < first ? r : first;
        last = is_above ? r : last;
    }
    *low = last < 0 ? 0.0 : (double)p->vertical[first > 0 ? first - 1 : 0];
    *high = last < 0 ? 0.0 : (double)p->vertical[last + 1 < p->rows ? last + 1 : last];
}

static void find_reach( RfProfile* p )
{
    double low, high, half_low, half_high;
    find_rows( p, 0.0f, &low, &high );
    find_rows( p, 0.5f * p->most, &half_low, &half_high );
    p->up = PI - low < high;
    p->cos_reach = cos( p->up ? PI - low : high );
    p->cos_half = cos( p->up ? PI - half_low : half_high );
}

RfResult rf_make_profile( const char* path, const RfProfileTable* table, RfProfile** out, RfError* error )
{
    *out = NULL;
    RfResult result = check_table( path, table, error );
    if ( result != RF_OK )
        return result;
    size_t room = 4 * (size_t)table->columns + 4;
    Turn turn = { 0, malloc( room * sizeof *turn.of ), malloc( room * sizeof *turn.at ) };
    RfProfile* profile = calloc( 1, sizeof *profile );
    if ( turn.of == NULL || turn.at == NULL || profile == NULL )
        result = no_memory( path, error );
    else if ( !expand( table, &turn ) )
        result =
            rf_fail( error, RF_ERROR_FORMAT,
                     "%s: its horizontal angles are %g to %g degrees: must be 0 alone, or 0 to 90, to 180, to 360, or 90 to 270",
                     path, table->horizontal[0], table->horizontal[table->columns - 1] );
    else
    {
        profile->references = 1;
        result = fill_columns( path, table, &turn, profile, error );
    }
    free( turn.of );
    free( turn.at );
    if ( result == RF_OK )
    {
        find_mean( profile );
        find_reach( profile );
        *out = profile;
    }
    else
        rf_release_profile( profile );
    return result;
}

// ---- Looked up

// The interval of ascending values that `x` is in, of count − 1.
static int interval_of( const float* at, int count, float x )
{
    int low = 0, high = count - 1;
    while ( high - low > 1 )
    {
        int middle = ( low + high ) / 2;
        if ( x < at[middle] )
            high = middle;
        else
            low = middle;
    }
    return low;
}

typedef struct Place
{
    int row, column;
    float v, h; // radians
} Place;

// False in the dark beyond the vertical angles.
static bool find_place( const RfProfile* p, RfVec3 d, Place* out )
{
    out->v = atan2f( sqrtf( d.x * d.x + d.y * d.y ), -d.z );
    // atan2 of 0 and 0 is 0
    out->h = rf_minf( rf_maxf( atan2f( d.x, d.y ) + RF_PI, 0.0f ), p->horizontal[p->columns - 1] );
    out->row = interval_of( p->vertical, p->rows, out->v );
    out->column = interval_of( p->horizontal, p->columns, out->h );
    return out->v >= p->vertical[0] && out->v <= p->vertical[p->rows - 1];
}

float rf_profile_value( const RfProfile* p, RfVec3 local )
{
    Place at;
    if ( !find_place( p, local, &at ) )
        return 0.0f;
    const float *left = p->value + (size_t)at.column * (size_t)p->rows + at.row, *right = left + p->rows;
    const float *v = p->vertical + at.row, *h = p->horizontal + at.column;
    float s = ( at.v - v[0] ) / ( v[1] - v[0] ), t = ( at.h - h[0] ) / ( h[1] - h[0] );
    float a = left[0] + s * ( left[1] - left[0] ), b = right[0] + s * ( right[1] - right[0] );
    return a + t * ( b - a );
}

// ---- From an IES file (ANSI/IES LM-63 of 1986, 1991, 1995 and 2002; they differ in their first lines only)

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
    for ( int i = 0; i < count; ++i )
        RF_TRY( read_number( r, what, &value ) );
    return RF_OK;
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
    RF_TRY( skip( r, "the lamp's geometry", 1 ) );
    RF_TRY( read_count( r, "the number of tilts", RF_PROFILE_ANGLES, &count ) );
    return skip( r, "a tilt", 2 * count );
}

// The line of ten numbers and that of three. `factor`: of all intensities.
static RfResult read_head( Reader* r, RfProfileTable* t, double* factor )
{
    double type = 0.0, ballast = 1.0, lamps = 1.0;
    RF_TRY( skip( r, "the number of lamps or their lumens", 2 ) );
    RF_TRY( read_number( r, "the multiplier", factor ) );
    RF_TRY( read_count( r, "the number of vertical angles", RF_PROFILE_ANGLES, &t->rows ) );
    RF_TRY( read_count( r, "the number of horizontal angles", RF_PROFILE_ANGLES, &t->columns ) );
    RF_TRY( read_number( r, "the type of photometry", &type ) );
    if ( type != 1.0 )
        return fail( r, RF_ERROR_UNSUPPORTED, "only photometry of type C (1) is read: convert the file" );
    RF_TRY( skip( r, "the size of the luminaire", 4 ) );
    RF_TRY( read_number( r, "the ballast factor", &ballast ) );
    RF_TRY( read_number( r, "the ballast-lamp factor", &lamps ) );
    RF_TRY( skip( r, "the watts", 1 ) );
    *factor *= ballast * lamps;
    if ( t->rows * t->columns > RF_PROFILE_VALUES )
        return fail( r, RF_ERROR_UNSUPPORTED, "it has more than a million intensities" );
    return RF_OK;
}

static RfResult read_numbers( Reader* r, const char* what, double factor, int count, double* out )
{
    for ( int i = 0; i < count; ++i )
    {
        RF_TRY( read_number( r, what, out + i ) );
        out[i] *= factor;
    }
    return RF_OK;
}

static RfResult read_table( Reader* r, RfProfileTable* t, double factor )
{
    t->vertical = malloc( (size_t)t->rows * sizeof *t->vertical );
    t->horizontal = malloc( (size_t)t->columns * sizeof *t->horizontal );
    t->value = malloc( (size_t)( t->rows * t->columns ) * sizeof *t->value );
    if ( t->vertical == NULL || t->horizontal == NULL || t->value == NULL )
        return rf_fail( r->error, RF_ERROR_MEMORY, "%s: out of memory for its %d intensities", r->path, t->rows * t->columns );
    RF_TRY( read_numbers( r, "a vertical angle", 1.0, t->rows, t->vertical ) );
    RF_TRY( read_numbers( r, "a horizontal angle", 1.0, t->columns, t->horizontal ) );
    return read_numbers( r, "an intensity", factor, t->rows * t->columns, t->value );
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
