// SIGINT and SIGTERM set a flag: the work stops at the next progress call and keeps what is
// finished. A second signal ends the program at once.
#ifndef REFRAME_CLI_RENDER_INTERRUPT_H
#define REFRAME_CLI_RENDER_INTERRUPT_H

#include <stdbool.h>

void rf_catch_interrupts( void );
bool rf_is_interrupted( void );

#endif
