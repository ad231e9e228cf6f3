// How the program ends before its time: by a signal, or by a library in C++ that cannot go on.
#ifndef REFRAME_CLI_SIGNALS_H
#define REFRAME_CLI_SIGNALS_H

#include <stdbool.h>

// SIGINT, SIGTERM, SIGHUP and SIGPIPE set a flag: the work stops at the next progress call and keeps what is finished. A second
// SIGINT or SIGTERM ends the program at once. SIGHUP and SIGPIPE stay ignored where they are.

void rf_catch_interrupts( void );
bool rf_is_interrupted( void );

// The opposite, for callbacks that say whether to go on.
bool rf_may_go_on( void* user );

// The end of the program by a library in C++ that cannot go on: Embree and TBB without memory.

// From here on an exception that nothing catches ends the program with a line of ours and exit status 1, not with abort.
void rf_catch_terminate( void );

#endif
