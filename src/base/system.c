#include "base/system.h"

#include "base/cgroup.h"

#include <math.h>
#include <omp.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

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
    size_t group = rf_own_cgroup_free_memory(), space = free_address_space();
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
    double quota = ceil( rf_own_cgroup_cores() );
    return quota >= 1.0 && quota < cores ? (int)quota : cores;
}
