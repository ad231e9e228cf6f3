// Patterns of frame numbers (#### or %04d) in file names: matches files, lists frames and gaps.
#include "image/sequence.h"

#include "base/try.h"
#include "image/atomic_file.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

// A pattern split into folder, prefix, number (a run of '#', or as printf has it, %04d) and suffix.
typedef struct Pattern
{
    const char* base;   // last path component
    const char* run;    // the number, or NULL
    const char* suffix; // what follows it
    int digits;         // at least
} Pattern;

// The first %d or %04d; one with a letter behind it is not meant so: 50%done.
static void find_conversion( Pattern* parts )
{
    for ( const char* c = strchr( parts->base, '%' ); c != NULL; c = strchr( c + 1, '%' ) )
    {
        const char* width = c[1] == '0' ? c + 2 : c + 1;
        size_t length = c[1] == '0' ? strspn( width, "0123456789" ) : 0;
        if ( width[length] != 'd' || ( c[1] == '0' && ( length < 1 || length > 2 || *width == '0' ) ) ||
             isalpha( (unsigned char)width[length + 1] ) )
            continue;
        parts->run = c;
        parts->suffix = width + length + 1;
        parts->digits = length > 0 ? atoi( width ) : 1;
        return;
    }
}

static Pattern split( const char* pattern )
{
    const char* slash = strrchr( pattern, '/' );
    Pattern parts = { .base = slash != NULL ? slash + 1 : pattern };
    parts.run = strchr( parts.base, '#' );
    parts.digits = parts.run != NULL ? (int)strspn( parts.run, "#" ) : 0;
    parts.suffix = parts.run != NULL ? parts.run + parts.digits : NULL;
    if ( parts.run == NULL )
        find_conversion( &parts );
    return parts;
}

bool rf_is_sequence( const char* pattern ) { return split( pattern ).run != NULL; }

static RfResult check_pattern( const char* pattern, const Pattern* parts, RfError* error )
{
    if ( memchr( pattern, '#', (size_t)( parts->base - pattern ) ) != NULL )
        return rf_fail( error, RF_ERROR_USAGE, "%s: the name of a folder must not contain '#', which stands for the frame",
                        pattern );
    Pattern more = { .base = parts->suffix };
    if ( parts->run != NULL && *parts->run == '%' )
        find_conversion( &more );
    if ( parts->run != NULL && ( strchr( parts->suffix, '#' ) != NULL || more.run != NULL ) )
        return rf_fail( error, RF_ERROR_USAGE, "%s: has more than one run of '#' or %%04d: use one for the frame", pattern );
    return RF_OK;
}

RfResult rf_sequence_name( const char* pattern, int frame, char* name, size_t size, RfError* error )
{
    Pattern parts = split( pattern );
    RF_TRY( check_pattern( pattern, &parts, error ) );
    int length;
    if ( parts.run == NULL )
        length = snprintf( name, size, "%s", pattern );
    else
        length = snprintf( name, size, "%.*s%s%0*lld%s", (int)( parts.run - pattern ), pattern, frame < 0 ? "-" : "",
                           parts.digits, llabs( (long long)frame ), parts.suffix );
    if ( length < 0 || (size_t)length >= size )
        return rf_fail( error, RF_ERROR_USAGE, "%s: the name is too long", pattern );
    return RF_OK;
}

// Whether a file name matches the pattern; *number is that of its frame. A minus is before the digits: -0012.
static bool match_name( const Pattern* parts, const char* name, int* frame_number )
{
    size_t prefix = (size_t)( parts->run - parts->base );
    if ( strncmp( name, parts->base, prefix ) != 0 )
        return false;
    bool negative = name[prefix] == '-';
    const char* number = name + prefix + negative;
    size_t digits = strspn( number, "0123456789" );
    if ( strcmp( number + digits, parts->suffix ) != 0 )
        return false;
    // more digits than '#' only if the number needs them: 00012 does not match ####
    if ( digits < (size_t)parts->digits || ( digits > (size_t)parts->digits && number[0] == '0' ) )
        return false;
    long frame = 0;
    for ( size_t i = 0; i < digits; ++i )
    {
        frame = 10 * frame + ( number[i] - '0' );
        if ( frame > INT_MAX )
            return false;
    }
    *frame_number = (int)( negative ? -frame : frame );
    return !negative || frame > 0;
}

int rf_compare_frames( const void* a, const void* b )
{
    int x = *(const int*)a, y = *(const int*)b;
    return ( x > y ) - ( x < y );
}

RfResult rf_sequence_frames( const char* pattern, int** frames, int* count, RfError* error )
{
    *frames = NULL;
    *count = 0;
    Pattern parts = split( pattern );
    RF_TRY( check_pattern( pattern, &parts, error ) );
    if ( parts.run == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "%s: has no '#' that stands for the frame", pattern );
    char path[PATH_MAX];
    struct dirent** entries;
    RF_TRY( rf_folder_of_file( pattern, path, sizeof path, error ) );
    int all = scandir( path, &entries, NULL, NULL );
    if ( all < 0 )
        return rf_fail_io( pattern, "its folder cannot be read", errno, error );
    int* list = malloc( ( (size_t)all + 1 ) * sizeof *list );
    for ( int i = 0; i < all; ++i )
    {
        *count += list != NULL && match_name( &parts, entries[i]->d_name, list + *count );
        free( entries[i] );
    }
    free( entries );
    if ( list != NULL && *count > 0 )
    {
        qsort( list, (size_t)*count, sizeof *list, rf_compare_frames );
        *frames = list;
        return RF_OK;
    }
    free( list );
    return list == NULL ? rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for the list of frames", pattern )
                        : rf_fail( error, RF_ERROR_IO, "%s: no such file", pattern );
}

static bool is_same_inode( const char* a, const char* b )
{
    struct stat x, y;
    return stat( a, &x ) == 0 && stat( b, &y ) == 0 && x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

static bool is_same_folder( const char* a, const char* b )
{
    char folders[2][PATH_MAX];
    if ( rf_folder_of_file( a, folders[0], PATH_MAX, NULL ) != RF_OK ||
         rf_folder_of_file( b, folders[1], PATH_MAX, NULL ) != RF_OK )
        return false;
    return is_same_inode( folders[0], folders[1] );
}

// The same names however the number is written: #### or %04d.
static bool is_same_sequence( const Pattern* a, const Pattern* b )
{
    if ( a->run == NULL || b->run == NULL )
        return false;
    size_t prefix = (size_t)( a->run - a->base );
    return prefix == (size_t)( b->run - b->base ) && strncmp( a->base, b->base, prefix ) == 0 &&
           strcmp( a->suffix, b->suffix ) == 0;
}

bool rf_may_be_same_file( const char* a, const char* b )
{
    Pattern x = split( a ), y = split( b );
    if ( strcmp( a, b ) == 0 || is_same_inode( a, b ) )
        return true;
    int frame;
    bool fits = strcmp( x.base, y.base ) == 0 || is_same_sequence( &x, &y );
    if ( x.run != NULL && y.run == NULL )
        fits = match_name( &x, y.base, &frame );
    if ( y.run != NULL && x.run == NULL )
        fits = match_name( &y, x.base, &frame );
    return fits && is_same_folder( a, b );
}

static int smallest_step( const int* frames, int count )
{
    int step = INT_MAX;
    for ( int i = 1; i < count; ++i )
        step = frames[i] - frames[i - 1] < step ? frames[i] - frames[i - 1] : step;
    return step;
}

// Adds the numbers between two neighbours; with `missing` NULL only counts them.
static int add_between( int before, int now, int step, int* missing, int done )
{
    for ( int64_t frame = (int64_t)before + step; frame < now && done < RF_MAX_MISSING; frame += step )
    {
        if ( missing != NULL )
            missing[done] = (int)frame;
        ++done;
    }
    return done;
}

RfResult rf_missing_frames( const int* frames, int count, int** missing, int* missing_count, RfError* error )
{
    int step = smallest_step( frames, count ), all = 0, done = 0;
    *missing = NULL;
    *missing_count = 0;
    for ( int i = 1; i < count; ++i )
        all = add_between( frames[i - 1], frames[i], step, NULL, all );
    if ( all == 0 )
        return RF_OK;
    *missing = malloc( (size_t)all * sizeof( int ) );
    if ( *missing == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the numbers of %d missing frames", all );
    for ( int i = 1; i < count; ++i )
        done = add_between( frames[i - 1], frames[i], step, *missing, done );
    *missing_count = done;
    return RF_OK;
}

void rf_format_frames( const int* frames, int count, char* text, size_t size )
{
    text[0] = '\0';
    for ( int i = 0, next; i < count; i = next )
    {
        char run[32];
        size_t used = strlen( text );
        for ( next = i + 1; next < count && frames[next] == frames[next - 1] + 1; )
            ++next;
        next = next - i < 3 ? i + 1 : next; // a run of two is listed, not written as a range
        if ( next > i + 1 )
            snprintf( run, sizeof run, frames[i] < 0 ? "%d to %d" : "%d-%d", frames[i], frames[next - 1] );
        else
            snprintf( run, sizeof run, "%d", frames[i] );
        if ( used + strlen( run ) + 8 > size ) // leave room for ", ..."
        {
            snprintf( text + used, size - used, "%s...", used > 0 ? ", " : "" );
            return;
        }
        snprintf( text + used, size - used, "%s%s", used > 0 ? ", " : "", run );
    }
}
