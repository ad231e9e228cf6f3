// --memory is kept, by the process's own accounting; a budget too small is refused with
// the smallest that works; and no budget changes a picture.
#define _DEFAULT_SOURCE // wait4
#include "support/cli_run.h"
#include "support/test.h"

#include <fcntl.h>
#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#define MIB 1048576.0
#define SLACK ( 6.0 * MIB ) // tables of the compression, stacks, what malloc keeps: 0.5 to 3 MiB when measured
#define ARGUMENTS 48

#ifdef REFRAME_SANITIZED
#define COUNTS_RESIDENT 0 // shadow memory and quarantine are not the renderer's
#else
#define COUNTS_RESIDENT 1
#endif

typedef struct Run
{
    int status;
    double resident; // the most that the process ever held, bytes
    double arena;    // peak_bytes as it says itself
    double threads;
} Run;

static double json_value( const char* key )
{
    size_t size;
    char* text = cli_read( "run.json", &size );
    json_t* json = json_loads( text, 0, NULL );
    free( text );
    double value = json_number_value( json_object_get( json, key ) );
    json_decref( json );
    return value;
}

// `reframe render SCENE OPTIONS`, options separated by single blanks, without a
// shell in between: its memory would count.
static Run run( const char* scene, const char* options )
{
    char text[1024], path[256];
    char* arguments[ARGUMENTS] = { (char*)REFRAME_BINARY, (char*)"render", path };
    int count = 3;
    snprintf( path, sizeof path, "%s/%s.glb", REFRAME_SCENE_FOLDER, scene );
    snprintf( text, sizeof text, "%s --overwrite --quiet --json run.json", options );
    for ( char* word = strtok( text, " " ); word != NULL && count < ARGUMENTS - 1; word = strtok( NULL, " " ) )
        arguments[count++] = word;
    pid_t child = fork();
    assert_true( child >= 0 );
    if ( child == 0 )
    {
        int out = chdir( cli_folder() ) == 0 ? open( "out.txt", O_WRONLY | O_CREAT | O_TRUNC, 0666 ) : -1;
        if ( out < 0 || dup2( out, 1 ) < 0 || dup2( out, 2 ) < 0 )
            _exit( 99 );
        execv( REFRAME_BINARY, arguments );
        _exit( 99 );
    }
    int status;
    struct rusage usage;
    assert_int_equal( wait4( child, &status, 0, &usage ), child );
    Run r = { .status = WIFEXITED( status ) ? WEXITSTATUS( status ) : 1000 };
    r.resident = (double)usage.ru_maxrss * 1024.0;
    if ( r.status == 0 )
    {
        r.arena = json_value( "peak_bytes" );
        r.threads = json_value( "threads" );
    }
    return r;
}

// What scene, BVH and the program itself hold: a render of next to nothing.
static double bare_bytes( const char* scene )
{
    Run r = run( scene, "-o bare.exr --frames 1 --size 1x1 --spp 1 --group 0 --tile 1 --threads 1" );
    assert_int_equal( r.status, 0 );
    return r.resident - r.arena;
}

// The budget that the error of one that is too small names, KiB.
static long least_kib( const char* scene, const char* options )
{
    char line[1024];
    snprintf( line, sizeof line, "%s --memory 1M", options );
    assert_int_equal( run( scene, line ).status, 1 );
    size_t size;
    char* text = cli_read( "out.txt", &size );
    const char* at = strstr( text, "give --memory " );
    assert_non_null( at );
    char* unit;
    long kib = 1024 * strtol( at + strlen( "give --memory " ), &unit, 10 );
    assert_true( *unit == 'M' );
    free( text );
    assert_true( kib > 1024 );
    return kib;
}

static Run run_with( const char* scene, const char* options, long kib )
{
    char line[1024];
    snprintf( line, sizeof line, "%s --memory %ldK", options, kib );
    return run( scene, line );
}

static void expect_kept( const char* scene, const char* options, long kib, double bare )
{
    Run r = run_with( scene, options, kib );
    double budget = (double)kib * 1024.0;
    assert_int_equal( r.status, 0 );
    // less than the budget and 32 MiB, which nothing can miss that is small: what is allocated is what the arena says
    if ( r.arena > budget || ( COUNTS_RESIDENT && r.resident - bare > r.arena + SLACK ) )
        fail_msg( "%s %s --memory %ldK: the arena took %.1f MiB, the process %.1f MiB beyond the scene", scene, options, kib,
                  r.arena / MIB, ( r.resident - bare ) / MIB );
}

static const struct
{
    const char *scene, *options;
    bool large; // for the bytes alone
} s_cases[] = {
    { "vase-room", "--group 1 --tile 3x3 --frames 20 --size 240x180 --spp 3 --threads 2", false },
    { "vase-room-ggx",
      "--group 2 --tile 3x3 --frames 1 --size 160x120 --spp 5 --threads 24 --aov albedo,normal,depth,motion,variance,samples",
      false },
    { "still-life", "--group 1 --frames 1-2 --size 96x72 --spp 3 --threads 4 --tile rooks64 --light-samples 4", false },
    { "turntable", "--group 1 --frames 1-2 --size 160x120 --spp 3 --threads 3 --tile 1 --aov depth", false },
    { "still-life", "--group 2 --tile 3x3 --frames 3-5 --size 120x90 --spp 5 --threads 3 --adaptive", false },
    { "vase-room-phong", "--group 1 --frames 1 --size 96x72 --spp 3 --threads 2 --tile 1 --weights eq15", false },
    // films of 135 MiB, and images whose files are written in chunks of 14 MiB
    { "vase-room", "--group 0 --frames 1 --size 2304x1536 --spp 1 --max-depth 1 --threads 1 --tile 1", true },
    { "vase-room",
      "--group 0 --frames 1-2 --size 8192x32 --spp 1 --max-depth 1 --threads 2 --tile 1 --compression piz "
      "--aov albedo,normal,depth,motion,variance,samples",
      true },
#ifdef REFRAME_DWA
    // chunks of 54 MiB, of which DWA takes six; with --float it would refuse them
    { "vase-room",
      "--group 0 --frames 1-2 --size 4096x256 --spp 1 --max-depth 1 --threads 1 --tile 1 --compression dwab "
      "--aov albedo,normal,depth,motion,variance,samples",
      true },
#define ONCE 2 // at the end, not compared at several budgets
#else
#define ONCE 1
#endif
    // this one looks at the frames rendered before: not the same in several sweeps
    { "vase-room", "--group 2 --frames 3-6 --size 120x90 --noise 0.06 --threads 2", false },
};
#define CASES ( (int)( sizeof s_cases / sizeof s_cases[0] ) )

TEST( test_budgets_are_kept )
{
    for ( int i = 0; i < CASES; ++i )
    {
        if ( s_cases[i].large && !COUNTS_RESIDENT )
            continue;
        char options[512];
        double bare = bare_bytes( s_cases[i].scene );
        snprintf( options, sizeof options, "%s -o f.####.exr", s_cases[i].options );
        long least = least_kib( s_cases[i].scene, options );
        expect_kept( s_cases[i].scene, options, least, bare );
        expect_kept( s_cases[i].scene, options, 65536 > least ? 65536 : 2 * least, bare );
        assert_int_equal( run_with( s_cases[i].scene, options, least - 1024 ).status, 1 );
    }
}

TEST( test_budgets_change_nothing )
{
    for ( int i = 0; i < CASES - ONCE; ++i )
    {
        if ( s_cases[i].large && !COUNTS_RESIDENT )
            continue;
        char options[512];
        snprintf( options, sizeof options, "%s --float -o much.####.exr", s_cases[i].options );
        assert_int_equal( run_with( s_cases[i].scene, options, 8 << 20 ).status, 0 );
        snprintf( options, sizeof options, "%s --float -o less.####.exr", s_cases[i].options );
        long least = least_kib( s_cases[i].scene, options );
        assert_int_equal( run_with( s_cases[i].scene, options, least ).status, 0 );
        cli_expect( cli_run( "for f in less.*.exr; do cmp $f much.${f#less.} || exit 1; done; rm less.* much.*" ), 0, NULL );
    }
}

// The paper's own example (800x600, groups of 7, its memory by section 4.3
// 1,787,520,000 bytes): any budget from 96 MiB on does. In little, its sides a
// quarter as long, in proportion; as it is, where there is time.
TEST( test_paper_example_fits_in_96_mib )
{
    static const char* const tiles[] = { "1", "3x3" };
    bool is_long = getenv( "REFRAME_LONG" ) != NULL;
    double bare = bare_bytes( "vase-room" );
    for ( int i = 0; i < 2; ++i )
    {
        char options[256];
        snprintf( options, sizeof options, "--frames 24 --size 800x600 --spp 14 --group 3 --tile %s -o paper.exr", tiles[i] );
        assert_true( least_kib( "vase-room", options ) < 96L * 1024 );
        if ( is_long )
            expect_kept( "vase-room", options, 96L * 1024, bare );
        snprintf( options, sizeof options,
                  "--frames 22-26 --size 200x150 --spp 7 --max-depth 1 --group 3 --tile %s --threads 1 -o paper.####.exr",
                  tiles[i] );
        expect_kept( "vase-room", options, 96L * 1024 / 16, bare );
    }
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
