#define _GNU_SOURCE // RTLD_DEFAULT

#include "cli/terminate.h"

#include <dlfcn.h>
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
