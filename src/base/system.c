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

static double memory_in( const char* folder )
{
    double least = INFINITY;
    for ( int k = 0; k < 2; ++k )
    {
        unsigned long long most, used, files = 0;
        if ( !read_number( folder, s_files[k].most, "", &most ) || !read_number( folder, s_files[k].used, "", &used ) )
            continue;
        if ( read_number( folder, "memory.stat", s_files[k].reclaimable, &files ) && files <= used )
            used -= files;
        least = used < most ? (double)( most - used ) : 0.0;
    }
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

// The least that a group and those above it leave; INFINITY: they have no limit.
static double least_up( const char* root, const char* path, double ( *left_in )( const char* folder ) )
{
    char folder[NAME_SIZE];
    double least = INFINITY;
    if ( snprintf( folder, sizeof folder, "%s%s", root, path ) >= (int)sizeof folder )
        return least;
    for ( char* end = folder + strlen( folder ); end != NULL && end >= folder + strlen( root ); end = strrchr( folder, '/' ) )
    {
        *end = '\0';
        least = fmin( least, left_in( folder ) );
    }
    return least;
}

static size_t whole_bytes( double bytes ) { return bytes < 0x1p63 ? (size_t)bytes : SIZE_MAX; }

size_t rf_cgroup_free_memory( const char* root, const char* path ) { return whole_bytes( least_up( root, path, memory_in ) ); }

double rf_cgroup_cores( const char* root, const char* path ) { return least_up( root, path, cores_in ); }

// Whether a line of /proc/self/cgroup, before `path`, lists a controller of version 1: "4:cpu,cpuacct:/a/b".
static bool has_controller( const char* line, const char* path, const char* name )
{
    for ( const char* at = strstr( line, name ); at != NULL && at < path; at = strstr( at + 1, name ) )
    {
        if ( at > line && strchr( ":,", at[-1] ) != NULL && strchr( ":,", at[strlen( name )] ) != NULL )
            return true;
    }
    return false;
}

// The same of the groups that this process is in.
static double least_of_own_groups( const char* controller, double ( *left_in )( const char* folder ) )
{
    char line[4096], root[64];
    FILE* file = fopen( "/proc/self/cgroup", "r" );
    double least = INFINITY;
    snprintf( root, sizeof root, "/sys/fs/cgroup/%s", controller );
    while ( file != NULL && fgets( line, sizeof line, file ) != NULL )
    {
        line[strcspn( line, "\n" )] = '\0';
        const char* path = strchr( line, '/' );
        if ( path != NULL && strncmp( line, "0::/", 4 ) == 0 ) // of version 2
            least = fmin( least, least_up( "/sys/fs/cgroup", path, left_in ) );
        else if ( path != NULL && has_controller( line, path, controller ) )
            least = fmin( least, least_up( root, path, left_in ) );
    }
    if ( file != NULL )
        fclose( file );
    return least;
}

static double seconds_of( clockid_t clock )
{
    struct timespec now;
    clock_gettime( clock, &now );
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double rf_wall_seconds( void ) { return seconds_of( CLOCK_MONOTONIC ); }

double rf_thread_seconds( void ) { return seconds_of( CLOCK_THREAD_CPUTIME_ID ); }

double rf_process_seconds( void ) { return seconds_of( CLOCK_PROCESS_CPUTIME_ID ); }

// What RLIMIT_AS (ulimit -v) leaves of the address space.
static size_t free_address_space( void )
{
    struct rlimit limit;
    unsigned long long pages = 0;
    if ( getrlimit( RLIMIT_AS, &limit ) != 0 || limit.rlim_cur == RLIM_INFINITY )
        return SIZE_MAX;
    bool known = read_number( "/proc/self", "statm", "", &pages );
    unsigned long long used = pages * (unsigned long long)sysconf( _SC_PAGESIZE );
    return !known ? SIZE_MAX : used < limit.rlim_cur ? (size_t)( limit.rlim_cur - used ) : 0;
}

size_t rf_permitted_memory( void )
{
    size_t group = whole_bytes( least_of_own_groups( "memory", memory_in ) ), space = free_address_space();
    return group < space ? group : space;
}

size_t rf_free_memory( void )
{
    unsigned long long kib = 0;
    read_number( "/proc", "meminfo", "MemAvailable:", &kib );
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
    double quota = ceil( least_of_own_groups( "cpu", cores_in ) );
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
