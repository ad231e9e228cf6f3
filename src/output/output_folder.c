// The folder that the frames go to.
#include "reframe/output.h"

#include "image/atomic_file.h"

#include <errno.h>
#include <stdlib.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define MAX_NAME 4096

// The folder of a file name, "." where it has none.
static RfResult folder_of( const char* path, char* folder, size_t size, RfError* error )
{
    const char* slash = strrchr( path, '/' );
    size_t length = slash == NULL ? 1 : slash == path ? 1 : (size_t)( slash - path );
    if ( length >= size )
        return rf_fail( error, RF_ERROR_USAGE, "the name of the output is longer than %d characters", MAX_NAME );
    memcpy( folder, slash == NULL ? "." : path, length );
    folder[length] = '\0';
    return RF_OK;
}

// Makes the last part of a folder's name where it is missing.
static RfResult make_folder( const char* folder, RfError* error )
{
    struct stat status;
    if ( stat( folder, &status ) == 0 )
        return S_ISDIR( status.st_mode ) ? RF_OK : rf_fail( error, RF_ERROR_IO, "%s: is not a folder", folder );
    if ( errno == ENOENT && mkdir( folder, 0777 ) == 0 )
        return RF_OK;
    if ( errno == ENOENT )
        return rf_fail( error, RF_ERROR_IO, "%s: this folder cannot be made, the one that it is to be in is missing", folder );
    return rf_fail( error, RF_ERROR_IO, "%s: the folder cannot be used: %s", folder, strerror( errno ) );
}

// Tells before the work, not after it, that frames cannot be written there.
static RfResult probe_folder( const char* folder, RfError* error )
{
    char name[MAX_NAME + 32];
    snprintf( name, sizeof name, "%s/.reframe-probe-XXXXXX", folder );
    int file = mkstemp( name );
    if ( file < 0 )
        return rf_fail( error, RF_ERROR_IO, "%s: no files can be made in this folder: %s", folder, strerror( errno ) );
    close( file );
    unlink( name );
    return RF_OK;
}

RfResult rf_prepare_output_folder( const char* pattern, RfError* error )
{
    char name[MAX_NAME], folder[MAX_NAME];
    size_t length = pattern != NULL ? strlen( pattern ) : 0;
    if ( length == 0 || pattern[length - 1] == '/' )
        return rf_fail( error, RF_ERROR_USAGE, "'%s' names no file", pattern != NULL ? pattern : "" );
    RfResult result = rf_sequence_name( pattern, 1, name, sizeof name, error );
    if ( result == RF_OK )
        result = folder_of( pattern, folder, sizeof folder, error );
    if ( result == RF_OK )
        result = make_folder( folder, error );
    return result == RF_OK ? probe_folder( folder, error ) : result;
}

void rf_clean_output_folder( const char* pattern )
{
    char folder[MAX_NAME];
    if ( folder_of( pattern, folder, sizeof folder, NULL ) == RF_OK )
        rf_remove_leftovers( folder );
}
