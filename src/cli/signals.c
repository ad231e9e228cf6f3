// SIGINT and SIGTERM ask a render to stop in good order; a second signal ends the program at once.
#define _GNU_SOURCE // RTLD_DEFAULT

#include "cli/signals.h"

#include <dlfcn.h>
#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

// Nothing is left open that matters: files that are being written have temporary names.
static void on_terminate( void )
{
    static const char line[] = "reframe: a library could not go on, most likely for want of memory: close other programs\n";
    (void)!write( STDERR_FILENO, line, sizeof line - 1 );
    _exit( 1 );
}

void rf_catch_terminate( void )
{
    // std::set_terminate of the C++ runtime that Embree brings along
    void ( *( *set )( void ( * )( void ) ) )( void );
    *(void**)&set = dlsym( RTLD_DEFAULT, "_ZSt13set_terminatePFvvE" );
    if ( set != NULL )
        set( on_terminate );
}

static volatile sig_atomic_t s_interrupted;

static void on_signal( int number )
{
    (void)number;
    s_interrupted = 1;
}

void rf_catch_interrupts( void )
{
    struct sigaction action = { .sa_handler = on_signal };
    sigemptyset( &action.sa_mask );
    // Reset: the second signal has its default action. Restart: the first does not
    // interrupt a write.
    action.sa_flags = (int)SA_RESETHAND | SA_RESTART;
    sigaction( SIGINT, &action, NULL );
    sigaction( SIGTERM, &action, NULL );
}

bool rf_is_interrupted( void ) { return s_interrupted != 0; }

bool rf_may_go_on( void* user )
{
    (void)user;
    return s_interrupted == 0;
}
