#include "base/system.h"
#include "render/plan_internal.h"

RfRenderSettings rf_default_render_settings( void )
{
    return ( RfRenderSettings ){
        .spp = 28,
        .group = RF_GROUP_AUTO,
        .tile = { RF_TILE_BLOCK, 3, 3 },
        .tile_roulette = false,
        .weights = RF_WEIGHTS_EXACT,
        .normalize = RF_NORMALIZE_CROSSFIT,
        .max_depth = 12,
        .light_samples = 1,
        .seed = 1,
    };
}

static RfResult check_settings( const RfRenderSettings* s, RfError* error )
{
    if ( s->spp < 1 || s->spp > RF_MAX_SPP )
        return rf_fail( error, RF_ERROR_USAGE, "samples per pixel must be 1 to %d, got %d", RF_MAX_SPP, s->spp );
    if ( !( s->noise >= 0.0 && s->noise <= RF_MAX_NOISE ) )
        return rf_fail( error, RF_ERROR_USAGE, "the relMSE wanted must be 0 to %g, got %g", RF_MAX_NOISE, s->noise );
    if ( !( s->time >= 0.0 && s->time <= RF_MAX_TIME ) )
        return rf_fail( error, RF_ERROR_USAGE, "the seconds for a frame must be 0 to %g, got %g", RF_MAX_TIME, s->time );
    if ( s->hold_all && rf_is_stopping( s ) )
        return rf_fail(
            error, RF_ERROR_USAGE,
            "all records of a group can be held only where its passes are known: not with a noise or a time to stop at" );
    if ( s->adaptive && s->weights != RF_WEIGHTS_EXACT )
        return rf_fail( error, RF_ERROR_USAGE, "adaptive samples want exact weights" );
    if ( s->group < RF_GROUP_AUTO || s->group > RF_MAX_GROUP )
        return rf_fail( error, RF_ERROR_USAGE, "group must be 0 to %d, got %d", RF_MAX_GROUP, s->group );
    if ( s->max_depth < 1 || s->max_depth > RF_MAX_DEPTH )
        return rf_fail( error, RF_ERROR_USAGE, "depth must be 1 to %d, got %d", RF_MAX_DEPTH, s->max_depth );
    if ( s->light_samples < 1 || s->light_samples > RF_MAX_LIGHT_SAMPLES )
        return rf_fail( error, RF_ERROR_USAGE, "light samples must be 1 to %d, got %d", RF_MAX_LIGHT_SAMPLES, s->light_samples );
    if ( !rf_is_tile( &s->tile ) )
        return rf_fail( error, RF_ERROR_USAGE, "tiles must have 1 to %d pixels, and rooks a square grid", RF_MAX_TILE_PIXELS );
    if ( ( s->layers & ~RF_ALL_AOVS ) != 0 )
        return rf_fail( error, RF_ERROR_USAGE, "there are no such layers: %#x", s->layers );
    if ( s->queue < 0 || s->queue > RF_MAX_QUEUE )
        return rf_fail( error, RF_ERROR_USAGE, "the queue must be 0 to %d frames, got %d", RF_MAX_QUEUE, s->queue );
    return RF_OK;
}

static RfResult check_eyes( const RfEye* eyes, int count, RfError* error )
{
    if ( count < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "a render needs at least one frame" );
    for ( int k = 0; k < count; ++k )
    {
        if ( eyes[k].width < 1 || eyes[k].height < 1 || eyes[k].width > RF_MAX_IMAGE_SIDE || eyes[k].height > RF_MAX_IMAGE_SIDE )
            return rf_fail( error, RF_ERROR_USAGE, "the image must be 1x1 to %dx%d pixels, got %dx%d", RF_MAX_IMAGE_SIDE,
                            RF_MAX_IMAGE_SIDE, eyes[k].width, eyes[k].height );
        if ( eyes[k].width != eyes[0].width || eyes[k].height != eyes[0].height )
            return rf_fail( error, RF_ERROR_USAGE, "all frames of a path must have the same size" );
    }
    return RF_OK;
}

// Never a matter of which frames are asked for.
static RfResult choose_group( const RfTracer* tracer, const RfEye* eyes, int eye_count, RfRenderSettings* settings,
                              RfError* error )
{
    if ( settings->group != RF_GROUP_AUTO )
        return RF_OK;
    RfPlan plan;
    RfResult result = rf_plan_render( tracer, eyes, eye_count, &( int ){ 0 }, 1, settings, &plan, error );
    if ( result == RF_OK )
        settings->group = plan.rows[plan.chosen].group;
    return result;
}

RfResult rf_resolve_common( const RfEye* eyes, int eye_count, const RfRenderSettings* settings, RfRenderSettings* resolved,
                            RfError* error )
{
    RfResult result = check_settings( settings, error );
    if ( result == RF_OK )
        result = check_eyes( eyes, eye_count, error );
    if ( result != RF_OK )
        return result;
    *resolved = *settings;
    if ( resolved->threads < 1 )
        resolved->threads = rf_core_count();
    if ( resolved->memory == 0 )
        resolved->memory = rf_free_memory() / 2;
    // the biased weightings count hits, whose mean is not known: their quotient only
    if ( resolved->weights != RF_WEIGHTS_EXACT )
        resolved->normalize = RF_NORMALIZE_RATIO;
    return RF_OK;
}

RfGroupPlan rf_plan_samples( int frames, int half_width, int spp )
{
    RfGroupPlan plan = rf_plan_groups( frames, half_width, spp );
    return plan.spp > RF_MAX_SPP ? rf_plan_groups( frames, half_width, RF_MAX_SPP / plan.eyes * plan.eyes ) : plan;
}

RfResult rf_resolve_settings( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                              RfRenderSettings* resolved, RfError* error )
{
    RfResult result = rf_resolve_common( eyes, eye_count, settings, resolved, error );
    if ( result == RF_OK )
        result = choose_group( tracer, eyes, eye_count, resolved, error );
    if ( result != RF_OK )
        return result;
    RfGroupPlan plan = rf_plan_samples( eye_count, resolved->group, settings->spp );
    resolved->group = plan.eyes / 2;
    if ( !rf_is_stopping( settings ) )
        resolved->spp = plan.spp;
    return RF_OK;
}
