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

// Samples of some groups, with paths of at most `depth` vertices.
typedef struct Timing
{
    int eyes, depth;
    double seconds, samples;
} Timing;

static void time_batch( Meter* m, int frame, int number, int pass, Timing* t )
{
    PlanProbe* p = m->probe;
    int max_depth = p->group.max_depth, job = rf_probe_job( p, frame, number );
    rf_aim_probe( p, rf_probe_frame( p, frame ), t->eyes );
    p->group.max_depth = t->depth < max_depth ? t->depth : max_depth;
    double start = rf_thread_seconds();
    t->samples += run_batch( m, ( RfTraceJob ){ p->eye, job, pass }, t->eyes );
    t->seconds += rf_thread_seconds() - start;
    p->group.max_depth = max_depth;
}

// Times the same batches in all ways, in turns: differences do not depend on which batches there was time for.
static void time_batches( Meter* m, double seconds, int count, Timing* timings )
{
    double start = rf_thread_seconds();
    for ( int i = 0; i == 0 || rf_thread_seconds() - start < seconds; ++i )
    {
        int k = i % ( PLAN_FRAMES * PLAN_JOBS );
        for ( int t = 0; t < count; ++t )
            time_batch( m, k % PLAN_FRAMES, k / PLAN_FRAMES, i / ( PLAN_FRAMES * PLAN_JOBS ), timings + t );
    }
}

static double seconds_per_sample( const Timing* t ) { return t->samples > 0.0 ? t->seconds / t->samples : 0.0; }

static void measure( Meter* m, int eyes, double seconds, RfPlan* plan )
{
    int depth = m->probe->group.max_depth;
    Timing warm[] = { { 1, depth, 0.0, 0.0 } }; // caches, pages
    Timing timings[] = { { 1, 1, 0.0, 0.0 }, { 1, depth, 0.0, 0.0 }, { eyes, depth, 0.0, 0.0 } };
    rf_set_float_mode();
    time_batches( m, 0.0, 1, warm );
    time_batches( m, seconds, eyes > 1 ? 3 : 2, timings );
    double bare = seconds_per_sample( timings ), own = seconds_per_sample( timings + 1 ), all = seconds_per_sample( timings + 2 );
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
