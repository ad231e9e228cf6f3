// A few thousand hits along the path, by the render's own harvest: how many
// eyes see them, and the rays that it takes.
#include "render/plan_internal.h"

#define PROBE_SEED 1 // whatever that of the render: the choice of the group is not to depend on it

static RfResult alloc_probe( PlanProbe* p, RfError* error )
{
    const RfEstimator* estimator = p->settings.estimator;
    RfResult result = rf_arena_alloc( &p->arena, "scratch", p->sizes.of_estimator.trace_scratch, &p->scratch, error );
    if ( result != RF_OK )
        return result;
    estimator->lay_out_scratch( &p->group, p->scratch );
    result = rf_arena_alloc( &p->arena, "hit records", p->sizes.of_estimator.batch, &p->batch, error );
    if ( result == RF_OK )
        estimator->lay_out_batch( &p->group, p->batch );
    return result;
}

RfResult rf_begin_probe( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                         int most_eyes, PlanProbe* probe, RfError* error )
{
    const RfScene* scene = rf_tracer_scene( tracer );
    RfGroupPlan plan = rf_plan_groups( eye_count, most_eyes / 2, settings->spp );
    *probe = ( PlanProbe ){ .eyes = eyes, .eye_count = eye_count, .settings = *settings };
    probe->settings.seed = PROBE_SEED;
    probe->arena = rf_create_arena( settings->memory );
    probe->sizes = rf_render_sizes( scene, eyes, &plan, 1, settings );
    probe->group =
        rf_size_group( scene, rf_scene_traits( scene, eyes, eye_count, &probe->settings ), eyes, plan.eyes, &probe->settings );
    probe->group.tracer = tracer;
    probe->group.max_depth = rf_tracer_lights( tracer )->count > 0 ? settings->max_depth : 1;
    return alloc_probe( probe, error );
}

void rf_end_probe( PlanProbe* p )
{
    rf_arena_free( &p->arena, "scratch", p->scratch, p->sizes.of_estimator.trace_scratch );
    rf_arena_free( &p->arena, "hit records", p->batch, p->sizes.of_estimator.batch );
    p->scratch = NULL;
    p->batch = NULL;
}

void rf_aim_probe( PlanProbe* p, int frame, int eyes )
{
    int first = frame - eyes / 2, last_first = p->eye_count - eyes;
    first = first < last_first ? first : last_first;
    first = first > 0 ? first : 0;
    p->group.eyes = p->eyes + first;
    p->group.first_frame = first;
    p->group.eye_count = eyes;
    p->eye = frame - first;
}

int rf_probe_frame( const PlanProbe* p, int i ) { return (int)( (int64_t)( 2 * i + 1 ) * p->eye_count / ( 2 * PLAN_FRAMES ) ); }

// Spread over the film, other places in every frame.
int rf_probe_job( const PlanProbe* p, int i, int k )
{
    int64_t place = PLAN_FRAMES * k + i, places = PLAN_FRAMES * PLAN_JOBS;
    return (int)( ( 2 * place + 1 ) * p->sizes.of_estimator.jobs / ( 2 * places ) );
}

static void count_batch( PlanProbe* p, int frame, int job, int pass, const int* eyes, int rows, PlanCounts* c )
{
    const RfEstimator* estimator = p->settings.estimator;
    rf_aim_probe( p, frame, 1 );
    c->samples += estimator->trace( &p->group, ( RfTraceJob ){ 0, job, pass }, p->batch, p->scratch, &c->rays );
    for ( int r = 0; r < rows && estimator->count_reuse != NULL; ++r )
    {
        RfReuseCount count = { 0 };
        rf_aim_probe( p, frame, eyes[r] );
        estimator->count_reuse( &p->group, p->eye, p->batch, p->scratch, &count );
        c->hits += r == 0 ? count.hits : 0.0;
        c->glossy += r == 0 ? count.shiny : 0.0;
        c->share[r] += count.own_share;
        c->eye_rays[r] += count.eye_rays;
    }
}

void rf_count_plan( PlanProbe* probe, const int* eyes, int rows, PlanCounts* counts )
{
    *counts = ( PlanCounts ){ 0 };
    rf_set_float_mode();
    for ( int i = 0; i < PLAN_FRAMES; ++i )
    {
        for ( int k = 0; k < PLAN_JOBS; ++k ) // a pass of its own: small films have fewer patches
            count_batch( probe, rf_probe_frame( probe, i ), rf_probe_job( probe, i, k ), k, eyes, rows, counts );
    }
    if ( counts->samples == 0.0 ) // all beside a film that is smaller than a tile
        counts->samples = 1.0;
}
