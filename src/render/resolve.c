// Settings as a render of a path will use them, with the group that the plan chooses.
#include "reframe/plan.h"
#include "render/render_effects.h"
#include "render/settings.h"

// Never a matter of which frames are asked for.
static RfResult choose_group( const RfTracer* tracer, const RfEye* eyes, int eye_count, RfRenderSettings* settings,
                              RfError* error )
{
    if ( settings->group != RF_GROUP_AUTO )
        return RF_OK;
    RfPlan plan;
    RfResult result = rf_plan_render( tracer, eyes, eye_count, &( int ){ 0 }, 1, settings, &plan, error );
    if ( result != RF_OK )
        return result;
    settings->group = plan.rows[plan.chosen].group;
    settings->adaptive = plan.adaptive;
    return RF_OK;
}

RfResult rf_resolve_settings( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                              RfRenderSettings* resolved, RfError* error )
{
    RfResult result = rf_resolve_common( eyes, eye_count, settings, resolved, error );
    if ( result == RF_OK )
        result = rf_check_built( rf_tracer_scene( tracer ), eyes, eye_count, resolved, error );
    if ( result == RF_OK )
        result = choose_group( tracer, eyes, eye_count, resolved, error );
    if ( result != RF_OK )
        return result;
    RfGroupPlan plan = rf_plan_samples( eye_count, resolved->group, settings->spp );
    resolved->group = plan.eyes / 2;
    if ( resolved->adaptive == RF_ADAPTIVE_AUTO && plan.eyes == 1 )
        resolved->adaptive = RF_ADAPTIVE_OFF;
    if ( !rf_is_stopping( settings ) )
        resolved->spp = plan.spp;
    return RF_OK;
}
