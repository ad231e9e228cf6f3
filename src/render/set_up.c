#include "render/set_up.h"

#include "base/system.h"
#include "render/pass.h"
#include "render/settings.h"

RfResult rf_set_up_render( RfRenderer* r, int eye_count, RfError* error )
{
    RfRenderSettings* settings = &r->settings;
    const RfScene* scene = rf_tracer_scene( r->tracer );
    r->plan = rf_plan_groups( eye_count, settings->group, settings->spp );
    if ( rf_is_stopping( settings ) )
        r->stop = rf_create_stop( &r->plan, settings->spp,
                                  &( RfStopGoals ){ .noise = settings->noise,
                                                    .flicker = settings->flicker * settings->flicker,
                                                    .seconds = settings->time * r->frames_all } );
    r->sizes = rf_render_sizes( scene, r->eyes, &r->plan, r->frames_all, settings );
    r->traits = rf_running_traits( scene, rf_scene_traits( scene, r->eyes, eye_count, settings ) );
    if ( !rf_is_plain_filter( settings ) )
        rf_make_pixel_filter( settings, &r->filter );
    r->memory.arena = rf_create_arena( settings->memory );
    r->start = r->last_frame = rf_wall_seconds();
    r->frame_count = r->frames_all;
    return rf_fit_sizes( settings->memory, r->frames_all, &r->sizes, &r->fit, error );
}

RfResult rf_alloc_render( RfRenderer* r, RfError* error )
{
    RfEstimatorGroup group = rf_frames_as_group( r, 0, r->plan.eyes, 0 );
    RfResult result = rf_alloc_render_memory( &group, &r->sizes, &r->memory, error );
    return result == RF_OK ? rf_alloc_traced_jobs( r, error ) : result;
}
