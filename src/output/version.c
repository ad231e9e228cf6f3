// Version of the library, set by CMake.
#include "reframe/types.h"

const char* rf_version( void ) { return REFRAME_VERSION; }

const char* rf_built_with( void ) { return REFRAME_WITH; }
