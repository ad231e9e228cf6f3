#include "cli/report/report_folder.h"

#include "image/atomic_file.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NAME_SIZE 512

static bool ends_with( const char* name, const char* suffix )
{
    size_t length = strlen( name ), end = strlen( suffix );
    return length > end && strcmp( name + length - end, suffix ) == 0;
}

static int compare_names( const void* a, const void* b ) { return strcmp( *(char* const*)a, *(char* const*)b ); }

static bool append( RfFolderList* list, int* room, const char* name )
{
    if ( list->count == *room )
    {
        int more = *room > 0 ? 2 * *room : 64;
        char** moved = realloc( list->names, (size_t)more * sizeof( char* ) );
        if ( moved == NULL )
            return false;
        list->names = moved;
        *room = more;
    }
    char* copy = malloc( strlen( name ) + 1 );
    if ( copy == NULL )
        return false;
    list->names[list->count++] = strcpy( copy, name );
    return true;
}

RfResult rf_list_folder( const char* folder, const char* suffix, RfFolderList* list, RfError* error )
{
    *list = ( RfFolderList ){ 0 };
    int room = 0;
    DIR* dir = opendir( folder );
    if ( dir == NULL )
        return rf_fail_io( folder, "this folder cannot be read", errno, error );
    RfResult result = RF_OK;
    for ( const struct dirent* entry = readdir( dir ); entry != NULL && result == RF_OK; entry = readdir( dir ) )
    {
        if ( entry->d_name[0] != '.' && ends_with( entry->d_name, suffix ) && !append( list, &room, entry->d_name ) )
            result = rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for the names of its files", folder );
    }
    closedir( dir );
    if ( list->count > 1 )
        qsort( list->names, (size_t)list->count, sizeof( char* ), compare_names );
    return result;
}

void rf_free_folder_list( RfFolderList* list )
{
    for ( int i = 0; i < list->count; ++i )
        free( list->names[i] );
    free( list->names );
    *list = ( RfFolderList ){ 0 };
}

// Where the last number of a name before ".exr" is; false where it has none.
static bool find_number( const char* name, size_t* begin, size_t* length )
{
    size_t end = strlen( name ) - strlen( ".exr" );
    while ( end > 0 && !isdigit( (unsigned char)name[end - 1] ) )
        --end;
    *begin = end;
    while ( *begin > 0 && isdigit( (unsigned char)name[*begin - 1] ) )
        --*begin;
    *length = end - *begin;
    return *length > 0;
}

// Of one sequence: the same but for the number.
static bool is_alike( const char* a, const char* b )
{
    size_t a_begin, a_length, b_begin, b_length;
    if ( !find_number( a, &a_begin, &a_length ) || !find_number( b, &b_begin, &b_length ) )
        return false;
    return a_begin == b_begin && memcmp( a, b, a_begin ) == 0 && strcmp( a + a_begin + a_length, b + b_begin + b_length ) == 0;
}

// The pattern of the sequence that `name` is of: '#' for the digits of its shortest number.
static void make_pattern( const RfFolderList* list, const char* name, char pattern[NAME_SIZE] )
{
    size_t begin, length, shortest, used;
    snprintf( pattern, NAME_SIZE, "%s", name );
    if ( !find_number( name, &begin, &length ) )
        return;
    shortest = length;
    for ( int i = 0; i < list->count; ++i )
    {
        size_t other_begin, other_length;
        if ( is_alike( name, list->names[i] ) && find_number( list->names[i], &other_begin, &other_length ) &&
             other_length < shortest )
            shortest = other_length;
    }
    used = (size_t)snprintf( pattern, NAME_SIZE, "%.*s", (int)begin, name );
    for ( size_t i = 0; i < shortest && used + 1 < NAME_SIZE; ++i )
        pattern[used++] = '#';
    snprintf( pattern + used, NAME_SIZE - used, "%s", name + begin + length );
}

RfResult rf_find_folder_sequence( const char* folder, char* pattern, size_t size, RfError* error )
{
    RfFolderList list;
    char first[NAME_SIZE], other[NAME_SIZE];
    RfResult result = rf_list_folder( folder, ".exr", &list, error );
    if ( result == RF_OK && list.count == 0 )
        result = rf_fail( error, RF_ERROR_IO, "%s: there is no EXR file in this folder", folder );
    for ( int i = 1; i < list.count && result == RF_OK; ++i )
    {
        if ( is_alike( list.names[0], list.names[i] ) )
            continue;
        make_pattern( &list, list.names[0], first );
        make_pattern( &list, list.names[i], other );
        result =
            rf_fail( error, RF_ERROR_USAGE, "%.300s: has more than one sequence, %.200s and %.200s: name one, as %.100s/%.150s",
                     folder, first, other, folder, first );
    }
    if ( result == RF_OK )
    {
        make_pattern( &list, list.names[0], first );
        bool slash = folder[strlen( folder ) - 1] == '/';
        if ( snprintf( pattern, size, "%s%s%s", folder, slash ? "" : "/", first ) >= (int)size )
            result = rf_fail( error, RF_ERROR_USAGE, "%s: the names in this folder are too long", folder );
    }
    rf_free_folder_list( &list );
    return result;
}
