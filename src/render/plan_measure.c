// What rays and reuse cost in this scene on this machine, by the render's own
// phases: harvest of a few patches, and compute into a film.
#include "base/system.h"
#include "render/plan_internal.h"

#include <math.h>
#include <string.h>

#define USUAL_GROUP 3

typedef struct Meter
{
    PlanProbe* probe;
    RfFilm film; // one half is enough
    RfAccumulateScratch* compute;
} Meter;

// Seconds for each native sample of groups of `eyes` frames, by paths of so many vertices.
static double seconds_per_sample( Meter* m, int eyes, int depth, double seconds )
{
    PlanProbe* p = m->probe;
    int max_depth = p->harvest.walk.max_depth;
    p->harvest.walk.max_depth = depth < max_depth ? depth : max_depth;
    double start = rf_thread_seconds(), now = start, samples = 0.0;
    for ( int pass = 0; now - start < seconds || pass == 0; ++pass )
    {
        for ( int i = 0; i < PLAN_FRAMES * PLAN_PATCHES && ( now - start < seconds || pass == 0 ); ++i )
        {
            int frame = i % PLAN_FRAMES, patch = rf_probe_patch( p, frame, i / PLAN_FRAMES );
            RfRayCounts rays = { 0 };
            rf_aim_probe( p, rf_probe_frame( p, frame ), eyes );
            rf_harvest_batch( &p->harvest, ( RfHarvestJob ){ p->batch.eye, patch, pass }, &p->batch, p->scratch, &rays );
            RfAccumulate compute = { .eyes = p->harvest.eyes,
                                     .shape = p->harvest.shape,
                                     .weights = RF_WEIGHTS_EXACT,
                                     .weight = 1.0f,
                                     .batches = &p->batch,
                                     .batch_count = 1 };
            for ( int l = 0; l < eyes; ++l )
                rf_accumulate_rows( &compute, ( RfAccumulateJob ){ .eye = l, .end_row = p->eyes->height, .film = &m->film }, NULL,
                                    m->compute );
            samples += p->batch.count + p->batch.miss_count;
            now = rf_thread_seconds();
        }
    }
    p->harvest.walk.max_depth = max_depth;
    return samples > 0.0 ? ( now - start ) / samples : 0.0;
}

static void measure( Meter* m, int eyes, double seconds, RfPlan* plan )
{
    rf_set_float_mode();
    seconds_per_sample( m, eyes, m->probe->harvest.walk.max_depth, 0.0 ); // warms up: caches, pages
    double bare = seconds_per_sample( m, 1, 1, 0.2 * seconds );
    double own = seconds_per_sample( m, 1, m->probe->harvest.walk.max_depth, 0.4 * seconds );
    double all = eyes > 1 ? seconds_per_sample( m, eyes, m->probe->harvest.walk.max_depth, 0.4 * seconds ) : own;
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

RfResult rf_measure_plan( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                          double seconds, RfPlan* plan, RfError* error )
{
    RfRenderSettings common;
    RfResult result = rf_resolve_common( eyes, eye_count, settings, &common, error );
    if ( result != RF_OK )
        return result;
    common.weights = RF_WEIGHTS_EXACT; // without the biased ones' lists
    // the costs of the group that is chosen, or of a usual one
    int group_eyes = plan->rows[plan->chosen].eyes;
    for ( int i = 0; i < plan->count && group_eyes == 1; ++i )
        group_eyes = rf_plan_row_fits( plan->rows + i ) && plan->rows[i].group >= USUAL_GROUP ? plan->rows[i].eyes : group_eyes;
    for ( int i = plan->count - 1; i > 0 && group_eyes == 1; --i )
        group_eyes = rf_plan_row_fits( plan->rows + i ) ? plan->rows[i].eyes : group_eyes;
    PlanProbe probe;
    Meter m = { .probe = &probe, .film = { .width = eyes->width, .height = eyes->height } };
    result = rf_begin_probe( tracer, eyes, eye_count, &common, group_eyes, &probe, error );
    size_t bytes = rf_film_half_bytes( eyes->width, eyes->height );
    if ( result == RF_OK )
        result = rf_arena_alloc( &probe.arena, "films", bytes, (void**)&m.film.half[0], error );
    if ( result == RF_OK )
        result = rf_arena_alloc( &probe.arena, "scratch", sizeof *m.compute, (void**)&m.compute, error );
    if ( result == RF_OK )
    {
        memset( m.film.half[0], 0, bytes );
        measure( &m, group_eyes, seconds, plan );
        weigh( eye_count, &common, plan );
    }
    rf_arena_free( &probe.arena, "scratch", m.compute, sizeof *m.compute );
    rf_arena_free( &probe.arena, "films", m.film.half[0], bytes );
    rf_end_probe( &probe );
    return result;
}
