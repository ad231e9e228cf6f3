#include "base/cgroup.h"

#include <limits.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define NAME_SIZE 4608

// Reads the number after `key` ("": the first) in a file; false if there is none, as in "max".
static bool read_number( const char* folder, const char* name, const char* key, unsigned long long* value )
{
    char path[NAME_SIZE + 32], line[256];
    snprintf( path, sizeof path, "%s/%s", folder, name );
    FILE* file = fopen( path, "r" );
    if ( file == NULL )
        return false;
    bool found = false;
    size_t length = strlen( key );
    while ( !found && fgets( line, sizeof line, file ) != NULL )
        found = strncmp( line, key, length ) == 0 && sscanf( line + length, "%llu", value ) == 1;
    fclose( file );
    return found;
}

// The files of a version.
typedef struct Files
{
    const char *most, *used, *reclaimable; // the last is a key of memory.stat
} Files;

static const Files s_files[] = { { "memory.max", "memory.current", "inactive_file " },
                                 { "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file " } };

static size_t available_in( const char* folder )
{
    size_t least = SIZE_MAX;
    for ( int k = 0; k < 2; ++k )
    {
        unsigned long long most, used, files = 0;
        if ( !read_number( folder, s_files[k].most, "", &most ) || !read_number( folder, s_files[k].used, "", &used ) )
            continue;
        if ( read_number( folder, "memory.stat", s_files[k].reclaimable, &files ) && files <= used )
            used -= files;
        least = used < most ? (size_t)( most - used ) : 0;
    }
    return least;
}

// Sets `folder` to the next group above; false above `root`, whose name has `base` characters.
static bool go_up( char* folder, size_t base )
{
    char* slash = strrchr( folder, '/' );
    if ( slash == NULL || slash < folder + base )
        return false;
    *slash = '\0';
    return true;
}

size_t rf_cgroup_free_memory( const char* root, const char* path )
{
    char folder[NAME_SIZE];
    size_t least = SIZE_MAX;
    if ( snprintf( folder, sizeof folder, "%s%s", root, path ) >= (int)sizeof folder )
        return SIZE_MAX;
    do
    {
        size_t left = available_in( folder );
        least = left < least ? left : least;
    } while ( go_up( folder, strlen( root ) ) );
    return least;
}

// "200000 100000" in cpu.max of version 2, two files in version 1; "max" and -1: no limit.
static double cores_in( const char* folder )
{
    char path[NAME_SIZE + 32];
    unsigned long long quota = 0, period = 0;
    snprintf( path, sizeof path, "%s/cpu.max", folder );
    FILE* file = fopen( path, "r" );
    bool known = file != NULL && fscanf( file, "%llu %llu", &quota, &period ) == 2;
    if ( file != NULL )
        fclose( file );
    else
        known = read_number( folder, "cpu.cfs_quota_us", "", &quota ) && read_number( folder, "cpu.cfs_period_us", "", &period );
    return known && period > 0 && quota <= LLONG_MAX ? (double)quota / (double)period : (double)INFINITY;
}

double rf_cgroup_cores( const char* root, const char* path )
{
    char folder[NAME_SIZE];
    double least = INFINITY;
    if ( snprintf( folder, sizeof folder, "%s%s", root, path ) >= (int)sizeof folder )
        return least;
    do
        least = fmin( least, cores_in( folder ) );
    while ( go_up( folder, strlen( root ) ) );
    return least;
}

double rf_own_cgroup_cores( void )
{
    char line[4096];
    FILE* file = fopen( "/proc/self/cgroup", "r" );
    double cores = INFINITY;
    while ( file != NULL && fgets( line, sizeof line, file ) != NULL )
    {
        line[strcspn( line, "\n" )] = '\0';
        const char* path = strchr( line, '/' );
        // "0::/a/b" of version 2; "4:cpu,cpuacct:/a/b" of version 1
        if ( path != NULL && strncmp( line, "0::/", 4 ) == 0 )
            cores = fmin( cores, rf_cgroup_cores( "/sys/fs/cgroup", path ) );
        else if ( path != NULL && ( strstr( line, ":cpu," ) != NULL || strstr( line, ":cpu:" ) != NULL ||
                                    strstr( line, ",cpu:" ) != NULL || strstr( line, ",cpu," ) != NULL ) )
            cores = fmin( cores, rf_cgroup_cores( "/sys/fs/cgroup/cpu", path ) );
    }
    if ( file != NULL )
        fclose( file );
    return cores;
}

size_t rf_own_cgroup_free_memory( void )
{
    char line[4096];
    FILE* file = fopen( "/proc/self/cgroup", "r" );
    if ( file == NULL )
        return SIZE_MAX;
    size_t left = SIZE_MAX;
    while ( fgets( line, sizeof line, file ) != NULL )
    {
        line[strcspn( line, "\n" )] = '\0';
        const char* path = strchr( line, '/' );
        if ( path == NULL )
            continue;
        // "0::/a/b" of version 2; "4:memory:/a/b", or "4:cpu,memory:/a/b", of version 1
        const char* name = strstr( line, "memory" );
        size_t here = SIZE_MAX;
        if ( strncmp( line, "0::/", 4 ) == 0 )
            here = rf_cgroup_free_memory( "/sys/fs/cgroup", path );
        else if ( name != NULL && name < path )
            here = rf_cgroup_free_memory( "/sys/fs/cgroup/memory", path );
        left = here < left ? here : left;
    }
    fclose( file );
    return left;
}
