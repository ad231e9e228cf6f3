// What the machine has: time, memory, cores.
#ifndef REFRAME_BASE_SYSTEM_H
#define REFRAME_BASE_SYSTEM_H

#include <stddef.h>

// Seconds of a clock that never goes back.
double rf_wall_seconds( void );

// Seconds that this thread has computed.
double rf_thread_seconds( void );

// The same of all threads of the process.
double rf_process_seconds( void );

// Memory that can be had without swapping, bytes, in the limits of a container too; 1 GiB
// where it cannot be told.
size_t rf_free_memory( void );

// Cores this process may use, ≥ 1.
int rf_core_count( void );

#endif
