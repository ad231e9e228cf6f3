// Versions of the library, set by CMake, and of its pictures.
#include "reframe/types.h"

// Whoever changes pictures in more than rounding, or what they cost, raises it: figures of a lower one are out of date
// (tests/scripts/check-citations).
#define PICTURES 6

const char* rf_version( void ) { return REFRAME_VERSION; }

int rf_pictures( void ) { return PICTURES; }

const char* rf_built_with( void ) { return REFRAME_WITH; }
