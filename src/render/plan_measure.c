// Measures what samples and their reuse cost in this scene on this machine: traces a few batches
// and accumulates them into a film.
#include "base/system.h"
#include "render/plan_internal.h"
#include "render/settings.h"

#include <math.h>
#include <string.h>

#define USUAL_GROUP 3

typedef struct Meter
{
    PlanProbe* probe;
    RfFilm films[RF_MAX_FILMS]; // one half of each is enough
    void *pass_state, *accumulate_scratch;
} Meter;

// One batch, traced and added to the films of all frames of its group. Returns its samples.
static int run_batch( Meter* m, RfTraceJob job, int eyes )
{
    PlanProbe* p = m->probe;
    const RfEstimator* estimator = p->settings.estimator;
    RfRayCounts rays = { 0 };
    int samples = estimator->trace( &p->group, job, p->batch, p->scratch, &rays );
    for ( int l = 0; l < eyes; ++l )
    {
        RfAccumulateJob rows = {
            .eye = l, .end_row = p->group.height, .films = m->films, .weight = 1.0f, .pass_state = m->pass_state
        };
        if ( m->pass_state != NULL )
            memset( m->pass_state, 0, p->sizes.of_estimator.pass_state );
        estimator->accumulate( &p->group, rows, &p->batch, 1, m->accumulate_scratch );
    }
    return samples;
}

// Seconds per own-frame sample in groups of `eyes` frames, with paths of at most `depth` vertices.
static double seconds_per_sample( Meter* m, int eyes, int depth, double seconds )
{
    PlanProbe* p = m->probe;
    int max_depth = p->group.max_depth;
    p->group.max_depth = depth < max_depth ? depth : max_depth;
    double start = rf_thread_seconds(), now = start, samples = 0.0;
    for ( int pass = 0; now - start < seconds || pass == 0; ++pass )
    {
        for ( int i = 0; i < PLAN_FRAMES * PLAN_JOBS && ( now - start < seconds || pass == 0 ); ++i )
        {
            int frame = i % PLAN_FRAMES, job = rf_probe_job( p, frame, i / PLAN_FRAMES );
            rf_aim_probe( p, rf_probe_frame( p, frame ), eyes );
            samples += run_batch( m, ( RfTraceJob ){ p->eye, job, pass }, eyes );
            now = rf_thread_seconds();
        }
    }
    p->group.max_depth = max_depth;
    return samples > 0.0 ? ( now - start ) / samples : 0.0;
}

static void measure( Meter* m, int eyes, double seconds, RfPlan* plan )
{
    rf_set_float_mode();
    seconds_per_sample( m, eyes, m->probe->group.max_depth, 0.0 ); // warms up: caches, pages
    double bare = seconds_per_sample( m, 1, 1, 0.2 * seconds );
    double own = seconds_per_sample( m, 1, m->probe->group.max_depth, 0.4 * seconds );
    double all = eyes > 1 ? seconds_per_sample( m, eyes, m->probe->group.max_depth, 0.4 * seconds ) : own;
    plan->c_e = bare;
    plan->c_l = own > bare ? own - bare : 0.0;
    plan->c_v = eyes > 1 ? fmax( all - own, 0.0 ) / ( eyes - 1 ) : 0.0;
}

static void weigh( int eye_count, const RfRenderSettings* settings, RfPlan* plan )
{
    double own = plan->c_e + plan->c_l;
    for ( int i = 0; i < plan->count; ++i )
    {
        RfPlanRow* row = plan->rows + i;
        if ( !rf_plan_row_fits( row ) )
            continue;
        RfGroupPlan groups = rf_plan_samples( eye_count, row->group, settings->spp );
        double samples = rf_plan_work( &groups, 1.0, 0.0 ), work = rf_plan_work( &groups, own, plan->c_v );
        row->measured_gain = work > 0.0 ? row->reach * (double)groups.frames * groups.spp * own / ( work * row->repeated ) : 1.0;
        row->seconds = row->samples / samples * work / row->fit.threads;
    }
}

static RfResult alloc_meter( Meter* m, RfError* error )
{
    PlanProbe* p = m->probe;
    const RfEstimatorSizes* sizes = &p->sizes.of_estimator;
    size_t half = rf_film_half_bytes( p->group.width, p->group.height );
    RfResult result = RF_OK;
    for ( int f = 0; f < p->settings.estimator->films && result == RF_OK; ++f )
    {
        m->films[f] = ( RfFilm ){ .width = p->group.width, .height = p->group.height };
        result = rf_arena_alloc( &p->arena, "films", half, (void**)&m->films[f].half[0], error );
        if ( result == RF_OK )
            memset( m->films[f].half[0], 0, half );
    }
    if ( result == RF_OK && sizes->pass_state > 0 )
        result = rf_arena_alloc( &p->arena, "films", sizes->pass_state, &m->pass_state, error );
    if ( result == RF_OK && sizes->pass_state > 0 )
        memset( m->pass_state, 0, sizes->pass_state );
    return result == RF_OK ? rf_arena_alloc( &p->arena, "scratch", sizes->accumulate_scratch, &m->accumulate_scratch, error )
                           : result;
}

static void free_meter( Meter* m )
{
    PlanProbe* p = m->probe;
    for ( int f = 0; f < p->settings.estimator->films; ++f )
        rf_arena_free( &p->arena, "films", m->films[f].half[0], rf_film_half_bytes( p->group.width, p->group.height ) );
    rf_arena_free( &p->arena, "films", m->pass_state, p->sizes.of_estimator.pass_state );
    rf_arena_free( &p->arena, "scratch", m->accumulate_scratch, p->sizes.of_estimator.accumulate_scratch );
}

// The group whose costs are measured: the one that is chosen, or a usual one.
static int measured_eyes( const RfPlan* plan )
{
    int eyes = plan->rows[plan->chosen].eyes;
    for ( int i = 0; i < plan->count && eyes == 1; ++i )
        eyes = rf_plan_row_fits( plan->rows + i ) && plan->rows[i].group >= USUAL_GROUP ? plan->rows[i].eyes : eyes;
    for ( int i = plan->count - 1; i > 0 && eyes == 1; --i )
        eyes = rf_plan_row_fits( plan->rows + i ) ? plan->rows[i].eyes : eyes;
    return eyes;
}

RfResult rf_measure_plan( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                          double seconds, RfPlan* plan, RfError* error )
{
    RfRenderSettings common;
    RfResult result = rf_resolve_common( eyes, eye_count, settings, &common, error );
    if ( result != RF_OK )
        return result;
    common.weights = RF_WEIGHTS_EXACT; // the biased ones need lists per pass
    int group_eyes = measured_eyes( plan );
    PlanProbe probe;
    Meter m = { .probe = &probe };
    result = rf_begin_probe( tracer, eyes, eye_count, &common, group_eyes, &probe, error );
    if ( result == RF_OK )
        result = alloc_meter( &m, error );
    if ( result == RF_OK && !probe.sizes.of_estimator.whole_pass ) // which single batches are not
    {
        measure( &m, group_eyes, seconds, plan );
        weigh( eye_count, &common, plan );
    }
    free_meter( &m );
    rf_end_probe( &probe );
    return result;
}
