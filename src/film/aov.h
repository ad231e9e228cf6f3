// What the library knows of AOVs besides reframe/aov.h.
#ifndef REFRAME_FILM_AOV_H
#define REFRAME_FILM_AOV_H

#include "reframe/aov.h"

// Are 16 bits enough for it in a file? Those like colour; all others need the range or the precision of 32.
bool rf_aov_is_half( RfAov aov );

#endif
