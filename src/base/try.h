// Passes a failure on.
#ifndef REFRAME_BASE_TRY_H
#define REFRAME_BASE_TRY_H

#include "reframe/error.h"

// Returns the result of a call from this function, unless it is RF_OK. Where something has to be freed first, the result is kept in a
// variable instead.
#define RF_TRY( call )                                                                                                           \
    do                                                                                                                           \
    {                                                                                                                            \
        RfResult rf_tried = ( call );                                                                                            \
        if ( rf_tried != RF_OK )                                                                                                 \
            return rf_tried;                                                                                                     \
    } while ( 0 )

#endif
