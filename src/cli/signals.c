// Signals ask a render to stop in good order; a second SIGINT or SIGTERM ends the program at once.
#define _GNU_SOURCE // RTLD_DEFAULT

#include "cli/signals.h"

#include <dlfcn.h>
#include <signal.h>
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
    static const int numbers[] = { SIGINT, SIGTERM, SIGHUP, SIGPIPE };
    for ( size_t i = 0; i < sizeof numbers / sizeof numbers[0]; ++i )
    {
        // These two may come several times: from the shell and the terminal, and with every line to a closed pipe.
        bool repeats = numbers[i] == SIGHUP || numbers[i] == SIGPIPE;
        struct sigaction action = { .sa_handler = on_signal }, before;
        sigemptyset( &action.sa_mask );
        // Reset: the second signal has its default action. Restart: the first does not
        // interrupt a write.
        action.sa_flags = SA_RESTART | ( repeats ? 0 : (int)SA_RESETHAND );
        if ( repeats && sigaction( numbers[i], NULL, &before ) == 0 && before.sa_handler == SIG_IGN )
            continue; // by nohup
        sigaction( numbers[i], &action, NULL );
    }
}

bool rf_is_interrupted( void ) { return s_interrupted != 0; }

bool rf_may_go_on( void* user )
{
    (void)user;
    return s_interrupted == 0;
}
