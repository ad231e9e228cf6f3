// Enables floating-point traps of invalid operations and divisions by zero; the handler prints a backtrace.
#ifdef REFRAME_TRAP
#define _GNU_SOURCE // feenableexcept
#endif

#include "base/float_traps.h"

// A C file must not be empty.
typedef int RfFloatTrapsAreCompiled;

#ifdef REFRAME_TRAP

#include <execinfo.h>
#include <fenv.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define TRAPS ( FE_INVALID | FE_DIVBYZERO )

static void print( const char* text )
{
    if ( write( STDERR_FILENO, text, strlen( text ) ) < 0 )
        _exit( EXIT_FAILURE );
}

// Prints the calls that led here, by functions that are safe in a handler, and ends the process by the signal.
static void on_trap( int number, siginfo_t* info, void* context )
{
    (void)context;
    print( info->si_code == FPE_FLTDIV ? "division by zero at\n" : "invalid floating-point operation at\n" );
    void* calls[32];
    backtrace_symbols_fd( calls, backtrace( calls, 32 ), STDERR_FILENO );
    signal( number, SIG_DFL );
    raise( number );
}

static void load_backtrace( void )
{
    void* calls[1];
    backtrace( calls, 1 ); // the first call loads a library, which a handler must not
}

void rf_enable_float_traps( void )
{
    static pthread_once_t s_once = PTHREAD_ONCE_INIT;
    pthread_once( &s_once, load_backtrace );
    struct sigaction action = { .sa_sigaction = on_trap, .sa_flags = SA_SIGINFO };
    sigaction( SIGFPE, &action, NULL ); // each time: frameworks for tests set their own
    feclearexcept( TRAPS );
    feenableexcept( TRAPS );
}

int rf_pause_float_traps( void ) { return fedisableexcept( TRAPS ); }

void rf_resume_float_traps( int traps )
{
    feclearexcept( TRAPS );
    feenableexcept( traps & TRAPS );
}

#endif
