// What rf_choose_effects (reframe/effects.h) has chosen for a scene, for those that have to know.
#ifndef REFRAME_SCENE_LEAVE_OUT_H
#define REFRAME_SCENE_LEAVE_OUT_H

#include "base/built_in.h"
#include "reframe/effects.h"
#include "scene/scene.h"

// Has the effect been left out of the scene?
static inline bool rf_is_left_out( const RfScene* scene, RfEffectId effect )
{
    return ( scene->effects_left_out >> effect & 1u ) != 0;
}

// Does the code of the effect run whether or not the scene calls for it?
static inline bool rf_is_forced( const RfScene* scene, RfEffectId effect )
{
    return rf_is_built( effect ) && ( scene->effects_forced >> effect & 1u ) != 0;
}

// Whether the code of an effect runs for a scene that calls for it, or does not.
static inline bool rf_runs( const RfScene* scene, bool calls, RfEffectId effect )
{
    return rf_is_forced( scene, effect ) || ( rf_calls_for( calls, effect ) && !rf_is_left_out( scene, effect ) );
}

// Completes a row whose id, `on` and `why` are set: its name, and what rf_choose_effects has chosen.
void rf_finish_effect( const struct RfScene* scene, RfEffect* effect );

#endif
