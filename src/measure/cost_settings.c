// What the measurement of cost renders with.
#include "measure/cost_internal.h"

#include "render/groups.h"
#include "render/settings.h"
#include "reuse/tile.h"

// As many trials at a time as have room for their films and records, with a thread each.
static void share_threads( RfCostStudy* s )
{
    RfRenderSettings settings = s->settings[1];
    RfMemoryFit fit;
    settings.threads = 1;
    int eyes = 2 * settings.group + 1 < s->job->eye_count ? 2 * settings.group + 1 : s->job->eye_count;
    s->threads = s->settings[1].threads;
    s->workers = s->threads < RF_COST_TASKS ? s->threads : RF_COST_TASKS;
    if ( rf_fit_memory( rf_tracer_scene( s->job->tracer ), s->job->eyes, eyes, eyes, &settings, &fit, NULL ) == RF_OK )
    {
        size_t room = settings.memory / ( 2 * ( fit.bytes_films + fit.bytes_hits + fit.bytes_lists ) );
        s->workers = room < 1 ? 1 : room < (size_t)s->workers ? (int)room : s->workers;
    }
    for ( int k = 0; k < 2; ++k )
    {
        s->settings[k].threads = 1;
        s->settings[k].memory /= (size_t)s->workers;
    }
}

RfResult rf_resolve_cost_settings( RfCostStudy* s, RfError* error )
{
    const RfCostJob* job = s->job;
    RfRenderSettings asked = *job->settings;
    asked.noise = asked.flicker = asked.time = 0.0;
    asked.adaptive = RF_ADAPTIVE_OFF;
    RfRenderSettings *plain = s->settings, *reuse = s->settings + 1;
    RfResult result = rf_resolve_settings( job->tracer, job->eyes, job->eye_count, &asked, reuse, error );
    if ( result != RF_OK )
        return result;
    *plain = *reuse;
    plain->estimator = rf_default_render_settings().estimator;
    plain->group = 0;
    plain->tile = rf_no_tile();
    RfGroupPlan groups = rf_plan_groups( job->eye_count, reuse->group, 1 );
    reuse->group = groups.eyes / 2;
    if ( reuse->group == 0 && reuse->tile.kind == RF_TILE_NONE && reuse->estimator == plain->estimator )
        return rf_fail( error, RF_ERROR_USAGE,
                        "group 0 with tile 1 is path tracing, which all is compared with: take a larger group or a tile" );
    share_threads( s );
    s->first_passes = rf_usual_passes( reuse );
    s->cost->plain = ( RfCostCurve ){ .group = 0, .eyes = 1, .tile = plain->tile };
    s->cost->reuse = ( RfCostCurve ){ .group = reuse->group, .eyes = groups.eyes, .tile = reuse->tile };
    return RF_OK;
}
