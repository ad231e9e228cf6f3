// What the files of input cases share.
#ifndef REFRAME_TESTS_HARD_INPUTS_H
#define REFRAME_TESTS_HARD_INPUTS_H

#include "base/random.h"
#include "hard/hard.h"

#include <stdio.h>

#ifdef REFRAME_SANITIZED
#define HARD_MANY 20000
#else
#define HARD_MANY 400000
#endif

// Ends a check whose result is `out`, with the text of the table.
#define HARD_TELL( ... )                                                                                                         \
    do                                                                                                                           \
    {                                                                                                                            \
        snprintf( out.text, sizeof out.text, __VA_ARGS__ );                                                                      \
        return out;                                                                                                              \
    } while ( 0 )

// Number k of input i, uniform in [0, 1).
static inline float hard_even( uint32_t i, uint32_t k ) { return rf_random( rf_pixel_key( rf_pass_key( 77, 0, 0, 0 ), i ), k ); }

#endif
