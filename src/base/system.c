#include "base/system.h"

#include "base/cgroup.h"

#include <omp.h>
#include <stdbool.h>
#include <stdio.h>
#include <time.h>

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
    size_t machine = kib > 0 ? (size_t)kib * 1024 : (size_t)1 << 30, group = rf_own_cgroup_free_memory();
    return group < machine ? group : machine;
}

void rf_format_memory( size_t bytes, char text[RF_BYTES_TEXT_SIZE] )
{
    bool whole = bytes % ( (size_t)1 << 20 ) == 0;
    snprintf( text, RF_BYTES_TEXT_SIZE, whole ? "%zu MiB" : "%zu KiB", whole ? bytes >> 20 : bytes >> 10 );
}

int rf_core_count( void ) { return omp_get_num_procs(); }
