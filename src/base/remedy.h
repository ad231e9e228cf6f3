// Errors that the caller could get past by changing something of the call.
#ifndef REFRAME_BASE_REMEDY_H
#define REFRAME_BASE_REMEDY_H

#include "reframe/error.h"

// Adds to an error what would help; `least_memory` as in RfError, else 0. `error` may be NULL.
// Returns `code`, so that `return rf_advise( rf_fail( error, ... ), RF_REMEDY_LAYER, 0, error );`.
RfResult rf_advise( RfResult code, RfRemedy remedy, size_t least_memory, RfError* error );

#endif
