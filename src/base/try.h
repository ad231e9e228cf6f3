// Failures handed on.
#ifndef REFRAME_BASE_TRY_H
#define REFRAME_BASE_TRY_H

#include "reframe/error.h"

// Returns from a function that has nothing to free, with the result of a call that fails.
#define RF_TRY( call )                                                                                                           \
    do                                                                                                                           \
    {                                                                                                                            \
        RfResult rf_result = ( call );                                                                                           \
        if ( rf_result != RF_OK )                                                                                                \
            return rf_result;                                                                                                    \
    } while ( 0 )

#endif
