// Render settings: their limits, and what follows from them without tracing a ray.
#ifndef REFRAME_RENDER_SETTINGS_H
#define REFRAME_RENDER_SETTINGS_H

#include "base/built_in.h"
#include "reframe/plan.h"
#include "reframe/render.h"
#include "render/groups.h"

// Is the number of passes decided while rendering?
static inline bool rf_is_stopping( const RfRenderSettings* settings )
{
    return rf_calls_for( settings->noise > 0.0 || settings->flicker > 0.0 || settings->time > 0.0, RF_EFFECT_STOP_RULE );
}

// Checks settings and cameras (tracer and frames of the shot are not looked at) and fills in all but the group: threads, memory, normalisation,
// and adaptive sampling where the estimator or the weights rule it out.
// Fails with RF_ERROR_USAGE for values out of range.
RfResult rf_resolve_common( const RfShot* shot, const RfRenderSettings* settings, RfRenderSettings* resolved, RfError* error );

// Is light taken out of the pictures of a scene, and kept on a film of its own?
bool rf_keeps_removed( const RfScene* scene, const RfRenderSettings* settings );
bool rf_can_render_pieces( const RfRenderSettings* settings );
bool rf_has_groups( const RfEstimator* estimator );

// Passes from which on pictures are made as with many of them; at least 2.
int rf_usual_passes( const RfRenderSettings* settings );

// The groups of a render with so many samples, of no more than RF_MAX_SPP where that is possible.
RfGroupPlan rf_plan_samples( const RfShot* shot, int half_width, int spp );

// rf_plan_render with two rows at most: that of single frames, and of a group that is asked for.
RfResult rf_plan_group( const RfShot* shot, const RfRenderSettings* settings, int group, RfPlan* plan, RfError* error );

#endif
