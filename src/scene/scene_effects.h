// Rows of the list of effects (reframe/effects.h).
#ifndef REFRAME_SCENE_SCENE_EFFECTS_H
#define REFRAME_SCENE_SCENE_EFFECTS_H

#include "reframe/effects.h"

// Completes a row whose id, `on` and `why` are set: its name, and what rf_choose_effects has chosen.
void rf_finish_effect( const struct RfScene* scene, RfEffect* effect );

#endif
