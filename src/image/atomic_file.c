// Writes to a temporary file, syncs it, renames it to the final name, and syncs the folder.
#define _XOPEN_SOURCE 700 // realpath

#include "image/atomic_file.h"

#include "base/try.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

RfResult rf_fail_io( const char* path, const char* what, int error_number, RfError* error )
{
    const char* advice = "";
    switch ( error_number )
    {
        case ENOENT:
        case ENOTDIR: advice = ": check the name and that its folder exists"; break;
        case ENOSPC:
        case EDQUOT:
        case EFBIG: advice = ": make room or write elsewhere"; break;
        case EACCES:
        case EPERM:
        case EROFS: advice = ": check the permissions"; break;
        default: break;
    }
    return rf_fail( error, RF_ERROR_IO, "%s: %s: %s%s", path, what, strerror( error_number ), advice );
}

static int write_all( int fd, const void* bytes, size_t size )
{
    const char* next = bytes;
    while ( size > 0 )
    {
        ssize_t written = write( fd, next, size );
        if ( written < 0 && errno == EINTR )
            continue;
        if ( written <= 0 )
            return written < 0 ? errno : EIO;
        next += written;
        size -= (size_t)written;
    }
    return 0;
}

static int sync_all( int fd )
{
    while ( fsync( fd ) != 0 )
    {
        if ( errno != EINTR )
            return errno;
    }
    return 0;
}

// Opens the folder of `path` and copies the last component to file->base.
static RfResult open_folder( RfAtomicFile* file, char* path, RfError* error )
{
    char* slash = strrchr( path, '/' );
    const char* base = slash != NULL ? slash + 1 : path;
    if ( *base == 0 || strcmp( base, "." ) == 0 || strcmp( base, ".." ) == 0 )
        return rf_fail( error, RF_ERROR_IO, "%s: names no file: add a file name", file->path );
    if ( strlen( base ) >= sizeof file->base )
        return rf_fail_io( file->path, "cannot be written", ENAMETOOLONG, error );
    snprintf( file->base, sizeof file->base, "%s", base );
    const char* folder = slash == NULL ? "." : slash == path ? "/" : path;
    if ( slash != NULL )
        *slash = 0;
    file->folder = open( folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC );
    if ( file->folder < 0 )
        return rf_fail_io( file->path, "its folder cannot be opened", errno, error );
    return RF_OK;
}

// rf_remove_leftovers knows the name. It contains the process id. Its leading dot keeps it out of sequence patterns, and it
// is short so that it fits wherever the final name does.
static RfResult create_temporary( RfAtomicFile* file, mode_t mode, RfError* error )
{
    static atomic_uint counter;
    do
    {
        snprintf( file->temporary, sizeof file->temporary, ".reframe-%ld-%u.tmp", (long)getpid(),
                  atomic_fetch_add( &counter, 1 ) );
        file->fd = openat( file->folder, file->temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666 );
    } while ( file->fd < 0 && ( errno == EEXIST || errno == EINTR ) );
    if ( file->fd < 0 )
        return rf_fail_io( file->path, "cannot be written", errno, error );
    // while it is locked, nobody takes it for a left-over; failure does not matter
    (void)flock( file->fd, LOCK_EX | LOCK_NB );
    if ( mode != 0 )
        (void)fchmod( file->fd, mode ); // an overwritten file keeps its permissions; failure does not matter
    return RF_OK;
}

RfResult rf_open_atomic_file( const char* path, RfAtomicFile* file, RfError* error )
{
    *file = ( RfAtomicFile ){ .path = path, .fd = -1, .folder = -1 };
    struct stat status;
    bool exists = stat( path, &status ) == 0;
    if ( exists && S_ISREG( status.st_mode ) == 0 )
        return rf_fail( error, RF_ERROR_IO, "%s: is %s: choose another name", path,
                        S_ISDIR( status.st_mode ) ? "a folder" : "not a regular file" );
    char* resolved = exists ? realpath( path, NULL ) : strdup( path );
    if ( resolved == NULL )
        return rf_fail_io( path, "cannot be written", errno, error );
    RfResult result = open_folder( file, resolved, error );
    free( resolved );
    if ( result == RF_OK )
        result = create_temporary( file, exists ? status.st_mode & 0777 : 0, error );
    if ( result != RF_OK && file->folder >= 0 )
    {
        close( file->folder );
        file->folder = -1;
    }
    return result;
}

RfResult rf_folder_of_file( const char* path, char* folder, size_t size, RfError* error )
{
    const char* slash = strrchr( path, '/' );
    size_t length = slash == NULL ? 1 : slash == path ? 1 : (size_t)( slash - path );
    if ( length >= size )
        return rf_fail( error, RF_ERROR_USAGE, "%.80s...: the name is too long", path );
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
    if ( errno == ENOENT && ( mkdir( folder, 0777 ) == 0 || errno == EEXIST ) )
        return RF_OK;
    if ( errno == ENOENT )
        return rf_fail( error, RF_ERROR_IO, "%s: this folder cannot be made, its parent is missing", folder );
    return rf_fail( error, RF_ERROR_IO, "%s: the folder cannot be used: %s", folder, strerror( errno ) );
}

RfResult rf_try_output_file( const char* path, RfError* error )
{
    char folder[4096];
    RfAtomicFile file;
    RfResult result = rf_folder_of_file( path, folder, sizeof folder, error );
    if ( result == RF_OK )
        result = make_folder( folder, error );
    if ( result == RF_OK )
        result = rf_open_atomic_file( path, &file, error );
    if ( result == RF_OK )
        rf_discard_atomic_file( &file );
    return result;
}

RfResult rf_append_atomic_file( RfAtomicFile* file, const void* bytes, size_t size, RfError* error )
{
    int failure = write_all( file->fd, bytes, size );
    return failure == 0 ? RF_OK : rf_fail_io( file->path, "cannot be written", failure, error );
}

void rf_discard_atomic_file( RfAtomicFile* file )
{
    if ( file->fd >= 0 )
        close( file->fd );
    if ( file->folder >= 0 )
    {
        unlinkat( file->folder, file->temporary, 0 );
        close( file->folder );
    }
    file->fd = -1;
    file->folder = -1;
}

RfResult rf_end_atomic_file( RfAtomicFile* file, RfResult result, RfError* error )
{
    if ( result != RF_OK )
    {
        rf_discard_atomic_file( file );
        return result;
    }
    int failure = file->unsynced ? 0 : sync_all( file->fd );
    // network file systems may report lost data only on close
    if ( close( file->fd ) != 0 && failure == 0 && errno != EINTR )
        failure = errno;
    file->fd = -1;
    if ( failure == 0 && renameat( file->folder, file->temporary, file->folder, file->base ) != 0 )
        failure = errno;
    if ( failure != 0 )
    {
        rf_discard_atomic_file( file );
        return rf_fail_io( file->path, "cannot be written", failure, error );
    }
    failure = file->unsynced ? 0 : sync_all( file->folder );
    close( file->folder );
    file->folder = -1;
    // some file systems do not support fsync for folders and return EINVAL
    if ( failure != 0 && failure != EINVAL )
        return rf_fail_io( file->path, "is written, but its folder could not be synced", failure, error );
    return RF_OK;
}

static RfResult write_in_place( const char* path, const void* bytes, size_t size, RfError* error )
{
    int fd = open( path, O_WRONLY | O_CLOEXEC );
    if ( fd < 0 )
        return rf_fail_io( path, "cannot be written", errno, error );
    int failure = write_all( fd, bytes, size );
    if ( close( fd ) != 0 && failure == 0 && errno != EINTR )
        failure = errno;
    return failure == 0 ? RF_OK : rf_fail_io( path, "cannot be written", failure, error );
}

RfResult rf_write_file_atomic( const char* path, const void* bytes, size_t size, RfError* error )
{
    struct stat status;
    if ( stat( path, &status ) == 0 && !S_ISREG( status.st_mode ) && !S_ISDIR( status.st_mode ) )
        return write_in_place( path, bytes, size, error );
    RfAtomicFile file;
    RF_TRY( rf_open_atomic_file( path, &file, error ) );
    RfResult result = rf_append_atomic_file( &file, bytes, size, error );
    return rf_end_atomic_file( &file, result, error );
}

// ".reframe-1234-5.tmp".
static bool is_temporary( const char* name )
{
    static const char prefix[] = ".reframe-";
    if ( strncmp( name, prefix, sizeof prefix - 1 ) != 0 )
        return false;
    const char* rest = name + sizeof prefix - 1;
    return strcmp( rest + strspn( rest, "0123456789-" ), ".tmp" ) == 0;
}

static void remove_leftover( int folder, const char* name )
{
    struct stat status;
    int fd = openat( folder, name, O_RDWR | O_CLOEXEC | O_NOFOLLOW );
    if ( fd < 0 )
        return;
    bool is_left = fstat( fd, &status ) == 0 && S_ISREG( status.st_mode ) && difftime( time( NULL ), status.st_mtime ) > 1.0 &&
                   flock( fd, LOCK_EX | LOCK_NB ) == 0;
    if ( is_left )
        (void)unlinkat( folder, name, 0 );
    close( fd );
}

void rf_remove_leftovers( const char* folder )
{
    DIR* dir = opendir( folder );
    if ( dir == NULL )
        return;
    for ( const struct dirent* entry = readdir( dir ); entry != NULL; entry = readdir( dir ) )
    {
        if ( is_temporary( entry->d_name ) )
            remove_leftover( dirfd( dir ), entry->d_name );
    }
    closedir( dir );
}
