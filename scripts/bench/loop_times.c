// Preloaded into a program that gcc built with OpenMP, notes the CPU time of each iteration of its dynamic loops, and of what is
// serial between its parallel regions. Written to $LOOP_TIMES at the end: lines "region loop iteration nanoseconds", with
// iteration −1 for what a thread does in a region beside the loop, and loop −1 for what was serial before the region; the first
// line has the wall time and the CPU time of the process from the first region to the last, nanoseconds. For scripts/bench/cores.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct Note
{
    int region, loop;
    long iteration;
    uint64_t nanoseconds;
} Note;

typedef struct Notes
{
    Note* list;
    size_t count, room;
    struct Notes* next;
} Notes;

// What a team shares.
typedef struct Region
{
    void ( *body )( void* );
    void* data;
    int number;
} Region;

static void ( *s_parallel )( void ( * )( void* ), void*, unsigned, unsigned );
static bool ( *s_start )( long, long, long, long, long*, long* );
static bool ( *s_next )( long*, long* );
static void ( *s_end )( void );
static void ( *s_end_nowait )( void );
static pthread_mutex_t s_mutex = PTHREAD_MUTEX_INITIALIZER;
static Notes* s_all;
static int s_regions;
static uint64_t s_first[2], s_last[2];
static pthread_t s_master;
static uint64_t s_left; // by the master's clock

static __thread Notes* t_notes;
static __thread int t_region, t_loop; // region 0: none
static __thread long t_iteration;
static __thread uint64_t t_since;

static uint64_t clock_of( clockid_t id )
{
    struct timespec t;
    clock_gettime( id, &t );
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

static uint64_t cpu( void ) { return clock_of( CLOCK_THREAD_CPUTIME_ID ); }

static void note( int region, int loop, long iteration, uint64_t nanoseconds )
{
    Notes* n = t_notes;
    if ( n == NULL )
    {
        n = t_notes = calloc( 1, sizeof *n );
        pthread_mutex_lock( &s_mutex );
        n->next = s_all;
        s_all = n;
        pthread_mutex_unlock( &s_mutex );
    }
    if ( n->count == n->room )
    {
        n->room = 2 * n->room + 1024;
        n->list = realloc( n->list, n->room * sizeof *n->list );
    }
    n->list[n->count++] = ( Note ){ region, loop, iteration, nanoseconds };
}

// Ends what the thread has done since it was last asked, and begins an iteration, or −1.
static void turn( long iteration )
{
    if ( t_region == 0 )
        return;
    uint64_t now = cpu();
    note( t_region, t_loop, t_iteration, now - t_since );
    t_iteration = iteration;
    t_since = cpu();
}

static void run( void* data )
{
    const Region* region = data;
    t_region = region->number;
    t_loop = 0;
    t_iteration = -1;
    t_since = cpu();
    region->body( region->data );
    turn( -1 );
    t_region = 0;
}

static void* find( const char* name ) { return dlsym( RTLD_NEXT, name ); }

void GOMP_parallel( void ( *body )( void* ), void* data, unsigned threads, unsigned flags )
{
    if ( s_parallel == NULL )
    {
        s_start = (bool ( * )( long, long, long, long, long*, long* ))find( "GOMP_loop_nonmonotonic_dynamic_start" );
        s_next = (bool ( * )( long*, long* ))find( "GOMP_loop_nonmonotonic_dynamic_next" );
        s_end = (void ( * )( void ))find( "GOMP_loop_end" );
        s_end_nowait = (void ( * )( void ))find( "GOMP_loop_end_nowait" );
        s_parallel = (void ( * )( void ( * )( void* ), void*, unsigned, unsigned ))find( "GOMP_parallel" );
    }
    uint64_t now = cpu();
    if ( s_regions == 0 )
    {
        s_master = pthread_self();
        s_first[0] = clock_of( CLOCK_MONOTONIC );
        s_first[1] = clock_of( CLOCK_PROCESS_CPUTIME_ID );
        s_left = now;
    }
    if ( t_region != 0 || pthread_equal( pthread_self(), s_master ) == 0 )
    {
        s_parallel( body, data, threads, flags );
        return;
    }
    Region region = { body, data, ++s_regions };
    note( region.number, -1, -1, now - s_left );
    s_parallel( run, &region, threads, flags );
    s_last[0] = clock_of( CLOCK_MONOTONIC );
    s_last[1] = clock_of( CLOCK_PROCESS_CPUTIME_ID );
    s_left = cpu();
}

bool GOMP_loop_nonmonotonic_dynamic_start( long start, long end, long step, long chunk, long* first, long* last )
{
    t_loop += 1;
    turn( -1 );
    bool any = s_start( start, end, step, chunk, first, last );
    if ( any )
    {
        t_iteration = *first;
        t_since = cpu();
    }
    return any;
}

bool GOMP_loop_nonmonotonic_dynamic_next( long* first, long* last )
{
    turn( -1 );
    bool any = s_next( first, last );
    if ( any && t_region != 0 )
    {
        t_iteration = *first;
        t_since = cpu();
    }
    return any;
}

void GOMP_loop_end( void )
{
    turn( -1 );
    s_end();
    t_since = cpu();
}

void GOMP_loop_end_nowait( void )
{
    s_end_nowait();
    t_since = cpu();
}

__attribute__( ( destructor ) ) static void write_all( void )
{
    const char* path = getenv( "LOOP_TIMES" );
    FILE* file = path != NULL && s_regions > 0 ? fopen( path, "w" ) : NULL;
    if ( file == NULL )
        return;
    fprintf( file, "%lu %lu\n", (unsigned long)( s_last[0] - s_first[0] ), (unsigned long)( s_last[1] - s_first[1] ) );
    for ( const Notes* n = s_all; n != NULL; n = n->next )
    {
        for ( size_t i = 0; i < n->count; ++i )
            fprintf( file, "%d %d %ld %lu\n", n->list[i].region, n->list[i].loop, n->list[i].iteration,
                     (unsigned long)n->list[i].nanoseconds );
    }
    fclose( file );
}
