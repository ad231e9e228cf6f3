// Which effects this build has. `cmake -DREFRAME_WITHOUT="panes;textures"` leaves the code of some out, to measure what it
// costs where nothing calls for it (scripts/bench/run effects). Every test of whether a scene calls for an effect goes through
// rf_calls_for, which is a constant then; a scene that calls for the effect is refused by name.
#ifndef REFRAME_BASE_BUILT_IN_H
#define REFRAME_BASE_BUILT_IN_H

#include "reframe/effects.h"

#include <stdbool.h>

#ifndef REFRAME_EFFECTS_LEFT_OUT
#define REFRAME_EFFECTS_LEFT_OUT 0
#endif

// A set of RF_EFFECT_BITs.
#define RF_EFFECTS_NOT_BUILT ( (uint64_t)( REFRAME_EFFECTS_LEFT_OUT ) )

// True unless the build leaves the effect out: a constant.
static inline bool rf_is_built( RfEffectId effect ) { return ( RF_EFFECTS_NOT_BUILT >> effect & 1u ) == 0; }

// Whether something that may call for an effect does so in this build.
static inline bool rf_calls_for( bool calls, RfEffectId effect ) { return rf_is_built( effect ) && calls; }

#endif
