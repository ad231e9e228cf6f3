// SIGINT and SIGTERM as a flag: the work stops at the next progress call with
// everything finished so far kept. A second signal ends the program at once.
#ifndef REFRAME_CLI_RENDER_INTERRUPT_H
#define REFRAME_CLI_RENDER_INTERRUPT_H

#include <stdbool.h>

void rf_catch_interrupts( void );
bool rf_is_interrupted( void );

#endif
