#include "cli/render/interrupt.h"

#include <signal.h>
#include <stddef.h>

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
