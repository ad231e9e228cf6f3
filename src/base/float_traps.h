// Builds with REFRAME_TRAP stop at invalid operations and divisions by zero (tests/README.md). In others
// these functions do nothing.
#ifndef REFRAME_BASE_FLOAT_TRAPS_H
#define REFRAME_BASE_FLOAT_TRAPS_H

#ifdef REFRAME_TRAP

// Traps in the calling thread from now on. The handler of SIGFPE prints where.
void rf_enable_float_traps( void );

// Takes the traps out of the calling thread, for libraries that raise the flags legitimately; returns those that were set.
int rf_pause_float_traps( void );

// Sets the traps that rf_pause_float_traps returned, and forgets what happened meanwhile.
void rf_resume_float_traps( int traps );

#else

static inline void rf_enable_float_traps( void ) {}
static inline int rf_pause_float_traps( void ) { return 0; }
static inline void rf_resume_float_traps( int traps ) { (void)traps; }

#endif
#endif
