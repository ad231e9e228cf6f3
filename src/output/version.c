#include "reframe/types.h"

const char* rf_version( void ) { return REFRAME_VERSION; }
