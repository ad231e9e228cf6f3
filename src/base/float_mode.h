// How the calling thread treats subnormal floats.
#ifndef REFRAME_BASE_FLOAT_MODE_H
#define REFRAME_BASE_FLOAT_MODE_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __aarch64__
#define RF_FLUSH ( (uint64_t)1 << 24 ) // FPCR.FZ: of inputs and results
#else
#include <xmmintrin.h>
#define RF_FLUSH 0x8040u // MXCSR: results to zero, and denormals are zeros
#endif

// Whether subnormal inputs and results are zero from now on; returns what was set before.
static inline bool rf_flush_subnormals( bool flush )
{
#ifdef __aarch64__
    uint64_t mode;
    __asm__ volatile( "mrs %0, fpcr" : "=r"( mode ) );
    __asm__ volatile( "msr fpcr, %0" : : "r"( flush ? mode | RF_FLUSH : mode & ~RF_FLUSH ) );
#else
    unsigned mode = _mm_getcsr();
    _mm_setcsr( flush ? mode | RF_FLUSH : mode & ~RF_FLUSH );
#endif
    return ( mode & RF_FLUSH ) != 0;
}

#endif
