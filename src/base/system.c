// Clocks, free memory and cores; the limits of control groups are followed up to the root of the hierarchy.
#include "base/system.h"

#include <limits.h>
#include <math.h>
#include <omp.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

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

static double own_cgroup_cores( void )
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

// Free memory of the control groups that this process is in.
static size_t own_cgroup_free_memory( void )
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

double rf_wall_seconds( void )
{
    struct timespec now;
    clock_gettime( CLOCK_MONOTONIC, &now );
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double rf_thread_seconds( void )
{
    struct timespec now;
    clock_gettime( CLOCK_THREAD_CPUTIME_ID, &now );
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double rf_process_seconds( void )
{
    struct timespec now;
    clock_gettime( CLOCK_PROCESS_CPUTIME_ID, &now );
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

// What RLIMIT_AS (ulimit -v) leaves of the address space.
static size_t free_address_space( void )
{
    struct rlimit limit;
    unsigned long long pages = 0;
    if ( getrlimit( RLIMIT_AS, &limit ) != 0 || limit.rlim_cur == RLIM_INFINITY )
        return SIZE_MAX;
    FILE* file = fopen( "/proc/self/statm", "r" );
    if ( file == NULL )
        return SIZE_MAX;
    bool known = fscanf( file, "%llu", &pages ) == 1;
    fclose( file );
    unsigned long long used = pages * (unsigned long long)sysconf( _SC_PAGESIZE );
    return !known ? SIZE_MAX : used < limit.rlim_cur ? (size_t)( limit.rlim_cur - used ) : 0;
}

size_t rf_permitted_memory( void )
{
    size_t group = own_cgroup_free_memory(), space = free_address_space();
    return group < space ? group : space;
}

size_t rf_free_memory( void )
{
    unsigned long long kib = 0;
    FILE* file = fopen( "/proc/meminfo", "r" );
    if ( file != NULL )
    {
        char line[256];
        while ( fgets( line, sizeof line, file ) != NULL && sscanf( line, "MemAvailable: %llu kB", &kib ) != 1 )
        {
        }
        fclose( file );
    }
    size_t machine = kib > 0 ? (size_t)kib * 1024 : (size_t)1 << 30, permitted = rf_permitted_memory();
    return permitted < machine ? permitted : machine;
}

void rf_format_memory( size_t bytes, char text[RF_BYTES_TEXT_SIZE] )
{
    bool whole = bytes % ( (size_t)1 << 20 ) == 0;
    snprintf( text, RF_BYTES_TEXT_SIZE, whole ? "%zu MiB" : "%zu KiB", whole ? bytes >> 20 : bytes >> 10 );
}

int rf_core_count( void )
{
    int cores = omp_get_num_procs(); // of the CPU set
    double quota = ceil( own_cgroup_cores() );
    return quota >= 1.0 && quota < cores ? (int)quota : cores;
}

static void* wait_for( void* mutex )
{
    pthread_mutex_lock( mutex );
    pthread_mutex_unlock( mutex );
    return NULL;
}

int rf_possible_threads( int wanted )
{
    pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
    pthread_t* threads = malloc( (size_t)wanted * sizeof *threads );
    int count = 1; // this one
    if ( threads == NULL )
        return 1;
    pthread_mutex_lock( &mutex );
    while ( count < wanted && pthread_create( threads + count, NULL, wait_for, &mutex ) == 0 )
        ++count;
    pthread_mutex_unlock( &mutex );
    for ( int i = 1; i < count; ++i )
        pthread_join( threads[i], NULL );
    free( threads );
    return count;
}
