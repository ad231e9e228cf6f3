// The program: finds the command and runs it.
#define _XOPEN_SOURCE 700 // setenv, readlink
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/options.h"
#include "trace/trace.h"

#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const RfCommand s_commands[] = {
    { "render", rf_command_render, "render a camera animation to EXR files" },
    { "info", rf_command_info, "list what is in a scene, what moves and changes, and which effects it uses" },
    { "tune", rf_command_tune, "find group and tile: which fit in memory, and which are fastest" },
    { "cost", rf_command_cost, "measure what accuracy costs in time, with and without reuse" },
    { "compare", rf_command_compare, "measure the error of images against references" },
    { "flicker", rf_command_flicker, "measure how much the error changes from frame to frame" },
    { "report", rf_command_report, "show rendered sequences in one HTML page" },
    { "reconstruct", rf_command_reconstruct, "reconstruct images from noisy images and gradients" },
    { "denoise", rf_command_denoise, "denoise rendered sequences, and tell the error that is left" },
    { "png", rf_command_png, "convert EXR files to PNG" },
    { "convert", rf_command_convert, "convert OBJ, PLY, FBX or Collada to .glb" },
    { "completion", rf_command_completion, "print shell completion for bash or zsh" },
    { 0 }, // the end
};

#define COMMAND_COUNT ( (int)( sizeof s_commands / sizeof s_commands[0] ) - 1 )

static int finish_output( void )
{
    RfError error;
    if ( rf_flush_output( &error ) == RF_OK )
        return 0;
    fprintf( stderr, "reframe: %s\n", error.text );
    return 1;
}

static int print_usage( void )
{
    printf( "usage: reframe COMMAND [OPTIONS] FILES\n"
            "Renders camera animations through glTF scenes; every path is shared by the frames that see its first hit.\n\n" );
    for ( int i = 0; i < COMMAND_COUNT; ++i )
        printf( "  %-12s%s\n", s_commands[i].name, s_commands[i].summary );
    printf( "\n  reframe COMMAND --help    the options of a command; also: reframe help COMMAND\n"
            "  reframe --man             the manual page, for man -l -\n"
            "  reframe --version\n" );
    return finish_output();
}

// Every command's help, printed as sections of the manual.
static int print_manual( void )
{
    int status = rf_print_manual( s_commands );
    return status == 0 ? finish_output() : status;
}

static int fail_unknown( const char* name )
{
    const char* names[COMMAND_COUNT + 3] = { [COMMAND_COUNT] = "help", "--version", "--man" };
    for ( int i = 0; i < COMMAND_COUNT; ++i )
        names[i] = s_commands[i].name;
    const char* nearest = rf_find_synonym( name, names, COMMAND_COUNT + 3 );
    if ( nearest == NULL )
        nearest = rf_nearest_word( name, names, COMMAND_COUNT + 1 );
    RfError error; // through rf_fail: the word may hold anything
    if ( nearest != NULL )
        rf_fail( &error, RF_ERROR_USAGE, "'%s': no such command, did you mean %s?", name, nearest );
    else
        rf_fail( &error, RF_ERROR_USAGE, "'%s': no such command, see reframe --help", name );
    fprintf( stderr, "reframe: %s\n", error.text );
    return 2;
}

static int run_command( int argc, char** argv )
{
    for ( int i = 0; i < COMMAND_COUNT; ++i )
    {
        if ( strcmp( argv[0], s_commands[i].name ) == 0 )
            return s_commands[i].run( argc, argv );
    }
    return fail_unknown( argv[0] );
}

// `reframe help` and `reframe help COMMAND`.
static int run_help( int argc, char** argv )
{
    char help[] = "--help";
    char* arguments[] = { argv[1], help, NULL };
    return argc < 2 || argv[1][0] == '-' ? print_usage() : run_command( 2, arguments );
}

// The instruction sets that this program, or one beside it, may be compiled for: levels of the x86-64 ABI supplement. 0: another
// machine, with one kernel.
#if !defined( __x86_64__ )
#define LEVEL 0
#elif defined( __AVX512F__ ) && defined( __AVX512VL__ )
#define LEVEL 4
#elif defined( __AVX2__ )
#define LEVEL 3
#elif defined( __SSE4_2__ )
#define LEVEL 2
#else
#define LEVEL 1
#endif
#define MOST_LEVEL 4
#ifdef __aarch64__
#define OTHER "neon" // which all have
#else
#define OTHER "native"
#endif
static const char* const s_levels[] = { OTHER, "x86-64", "x86-64-v2", "x86-64-v3", "x86-64-v4" };

// That of this machine.
static int find_level( void )
{
#if defined( __x86_64__ ) && defined( __GNUC__ )
    __builtin_cpu_init();
    if ( !__builtin_cpu_supports( "sse4.2" ) || !__builtin_cpu_supports( "popcnt" ) )
        return 1;
    if ( !__builtin_cpu_supports( "avx2" ) || !__builtin_cpu_supports( "fma" ) || !__builtin_cpu_supports( "bmi2" ) )
        return 2;
    bool wide = __builtin_cpu_supports( "avx512f" ) && __builtin_cpu_supports( "avx512bw" ) &&
                __builtin_cpu_supports( "avx512cd" ) && __builtin_cpu_supports( "avx512dq" ) &&
                __builtin_cpu_supports( "avx512vl" );
    return wide ? 4 : 3;
#else
    return LEVEL;
#endif
}

// Compiled for more than the processor has, it would die of an illegal instruction.
static bool check_cpu( void )
{
    if ( find_level() >= LEVEL )
        return true;
    fprintf( stderr, "reframe: built for processors with %s, this one has %s: build with cmake -DREFRAME_MARCH=%s\n",
             s_levels[LEVEL], s_levels[find_level()], s_levels[find_level()] );
    return false;
}

// Starts the program that is compiled for what the processor has, where it lies beside this one (scripts/make-package), or for what
// REFRAME_KERNEL says: pictures of one kernel are the same bits on all machines. Returns where this is the one; false: that
// cannot be had.
static bool start_kernel( char** argv )
{
    const char* asked = getenv( "REFRAME_KERNEL" );
    int has = find_level(), most = has, least = LEVEL;
    for ( int level = 0; asked != NULL && asked[0] != 0; ++level )
    {
        if ( level > MOST_LEVEL || strcmp( asked, s_levels[level] ) == 0 )
        {
            most = least = level;
            break;
        }
    }
    char program[PATH_MAX];
    ssize_t length = readlink( "/proc/self/exe", program, sizeof program - 64 );
    while ( length > 0 && program[length - 1] != '/' )
        --length;
    for ( int level = most; length > 0 && level > LEVEL && level <= has; --level )
    {
        if ( level < least )
            break;
        snprintf( program + length, 64, "../libexec/reframe/reframe-%s", s_levels[level] );
        execv( program, argv ); // returns where there is none
    }
    if ( LEVEL >= least && LEVEL <= most )
        return true;
    if ( most > MOST_LEVEL )
        fprintf( stderr, "reframe: REFRAME_KERNEL: '%s': no kernel, expected %s\n", asked,
                 LEVEL == 0 ? OTHER : "x86-64-v2, x86-64-v3 or x86-64-v4" );
    else if ( most > has )
        fprintf( stderr, "reframe: REFRAME_KERNEL: this processor lacks %s: it has %s\n", asked, s_levels[has] );
    else
        fprintf( stderr, "reframe: REFRAME_KERNEL: %s: is not installed here: leave it out, or take %s\n", asked,
                 s_levels[LEVEL] );
    return false;
}

// Threads that wait do so asleep, unless the user has chosen otherwise. By default libgomp's spin, which on a machine with other
// work takes several times the CPU time. It reads the environment before main(), so that the program has to be started again.
static void wait_asleep( char** argv )
{
    static const char* const choices[] = { "OMP_WAIT_POLICY", "GOMP_SPINCOUNT", "KMP_BLOCKTIME", "KMP_LIBRARY" };
    char program[PATH_MAX];
    for ( size_t i = 0; i < sizeof choices / sizeof choices[0]; ++i )
    {
        if ( getenv( choices[i] ) != NULL )
            return; // also the second time
    }
    // by its own name: a program started as /proc/self/exe is listed as "exe"
    ssize_t length = readlink( "/proc/self/exe", program, sizeof program - 1 );
    if ( length <= 0 || setenv( choices[0], "passive", 1 ) != 0 )
        return;
    program[length] = '\0';
    execv( program, argv ); // where this fails, they spin
}

int main( int argc, char** argv )
{
    if ( !check_cpu() || !start_kernel( argv ) )
        return 1;
    rf_set_float_mode();
    rf_catch_terminate();
    rf_set_completion_commands( s_commands );
#ifdef SIGXFSZ
    // Exceeding a file size limit becomes an error of write, like a full disk.
    signal( SIGXFSZ, SIG_IGN );
#endif
    if ( argc < 2 )
    {
        fprintf( stderr, "reframe: no command given, see reframe --help\n" );
        return 2;
    }
    if ( strcmp( argv[1], "--help" ) == 0 || strcmp( argv[1], "-h" ) == 0 )
        return print_usage();
    if ( strcmp( argv[1], "--man" ) == 0 )
        return print_manual();
    if ( strcmp( argv[1], "--version" ) == 0 )
    {
        const char* with = rf_built_with();
        printf( "reframe %s (pictures %d, %s%s%s)\n", rf_version(), rf_pictures(), s_levels[LEVEL], with[0] != 0 ? ", with " : "",
                with );
        return finish_output();
    }
    if ( strcmp( argv[1], "help" ) == 0 )
        return run_help( argc - 1, argv + 1 );
    wait_asleep( argv );
    return run_command( argc - 1, argv + 1 );
}
