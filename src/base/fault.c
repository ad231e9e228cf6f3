// Looks up at the start which fault REFRAME_FAULT injects (builds with REFRAME_FAULTS only).
#include "base/fault.h"

// A C file must not be empty.
typedef int RfFaultsAreCompiled;

#ifdef REFRAME_FAULTS

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

RfFault g_rf_fault = RF_FAULT_none;

__attribute__( ( constructor ) ) static void read_fault( void )
{
    static const char* const names[] = { "",
#define NAME( name, what, cases ) #name,
                                         RF_FAULTS( NAME ) };
    const char* wanted = getenv( "REFRAME_FAULT" );
    int count = (int)( sizeof names / sizeof *names ), k = 0;
    while ( wanted != NULL && k < count && strcmp( wanted, names[k] ) != 0 )
        ++k;
    if ( k == count )
    {
        fprintf( stderr, "REFRAME_FAULT: unknown fault %s, see base/fault.h\n", wanted );
        exit( 2 );
    }
    g_rf_fault = (RfFault)k;
}

#endif
