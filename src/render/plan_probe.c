// A few thousand hits along the path, by the render's own harvest: how many
// eyes see them, and the rays that it takes.
#include "reuse/harvest_internal.h"
#include "render/plan_internal.h"

#define PROBE_SEED 1 // whatever that of the render: the choice of the group is not to depend on it

static RfResult alloc_probe( PlanProbe* p, RfError* error )
{
    const RfBatchShape* shape = &p->sizes.shape;
    void* memory = NULL;
    RfResult result = rf_arena_alloc( &p->arena, "scratch", rf_harvest_scratch_bytes( shape ), &memory, error );
    if ( result != RF_OK )
        return result;
    p->scratch = rf_lay_out_harvest_scratch( shape, memory );
    result = rf_arena_alloc( &p->arena, "hit records", rf_batch_bytes( shape ), &p->batch_memory, error );
    if ( result == RF_OK )
        p->batch = rf_lay_out_batch( shape, p->batch_memory );
    return result;
}

RfResult rf_begin_probe( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                         int most_eyes, PlanProbe* probe, RfError* error )
{
    RfGroupPlan plan = rf_plan_groups( eye_count, most_eyes / 2, settings->spp );
    *probe = ( PlanProbe ){ .tracer = tracer, .eyes = eyes, .eye_count = eye_count, .settings = settings };
    probe->arena = rf_create_arena( settings->memory );
    probe->sizes = rf_render_sizes( rf_tracer_scene( tracer ), eyes, &plan, 1, settings );
    int depth = rf_tracer_lights( tracer )->count > 0 ? settings->max_depth : 1;
    probe->harvest = ( RfHarvest ){
        .walk = { tracer, depth, settings->light_samples, settings->light_sampling },
        .shape = probe->sizes.shape,
        .patches = probe->sizes.patches,
        .tile_roulette = settings->tile_roulette,
        .weights = settings->weights,
        .seed = PROBE_SEED,
    };
    return alloc_probe( probe, error );
}

void rf_end_probe( PlanProbe* p )
{
    rf_arena_free( &p->arena, "scratch", p->scratch, rf_harvest_scratch_bytes( &p->sizes.shape ) );
    rf_arena_free( &p->arena, "hit records", p->batch_memory, rf_batch_bytes( &p->sizes.shape ) );
    p->scratch = NULL;
    p->batch_memory = NULL;
}

void rf_aim_probe( PlanProbe* p, int frame, int eyes )
{
    int first = frame - eyes / 2, last_first = p->eye_count - eyes;
    first = first < last_first ? first : last_first;
    first = first > 0 ? first : 0;
    p->harvest.eyes = p->eyes + first;
    p->harvest.first_frame = first;
    p->harvest.shape.eyes = eyes;
    p->batch.eye = frame - first;
}

int rf_probe_frame( const PlanProbe* p, int i ) { return (int)( (int64_t)( 2 * i + 1 ) * p->eye_count / ( 2 * PLAN_FRAMES ) ); }

// Spread over the film, other places in every frame.
int rf_probe_patch( const PlanProbe* p, int i, int k )
{
    int64_t place = PLAN_FRAMES * k + i, places = PLAN_FRAMES * PLAN_PATCHES;
    return (int)( ( 2 * place + 1 ) * p->sizes.patches.count / ( 2 * places ) );
}

// Of each hit, what is left of its weight in its own frame.
static double sum_shares( const PlanProbe* p )
{
    const float* own = p->scratch->density + (size_t)p->batch.eye * RF_LANES;
    double sum = 0.0;
    for ( int i = 0; i < p->batch.count; ++i )
        sum += (double)own[i] / (double)p->batch.density_sum[i];
    return sum;
}

static void count_batch( PlanProbe* p, int frame, int patch, int pass, const int* eyes, int rows, PlanCounts* c )
{
    rf_aim_probe( p, frame, 1 );
    rf_harvest_batch( &p->harvest, ( RfHarvestJob ){ 0, patch, pass }, &p->batch, p->scratch, &c->rays );
    int natives = p->scratch->first.count - p->batch.count;
    c->samples += p->batch.count + p->batch.miss_count;
    c->hits += p->batch.count + natives;
    c->glossy += rf_glossy_count( &p->batch );
    for ( int r = 0; r < rows; ++r )
    {
        RfRayCounts rays = { 0 };
        rf_aim_probe( p, frame, eyes[r] );
        rf_test_batch_visibility( &p->harvest, &p->batch, p->scratch, &rays );
        c->share[r] += sum_shares( p ) + natives;
        c->eye_rays[r] += (double)rays.eye;
    }
}

void rf_count_plan( PlanProbe* probe, const int* eyes, int rows, PlanCounts* counts )
{
    *counts = ( PlanCounts ){ 0 };
    rf_set_float_mode();
    for ( int i = 0; i < PLAN_FRAMES; ++i )
    {
        for ( int k = 0; k < PLAN_PATCHES; ++k ) // a pass of its own: small films have fewer patches
            count_batch( probe, rf_probe_frame( probe, i ), rf_probe_patch( probe, i, k ), k, eyes, rows, counts );
    }
    if ( counts->samples == 0.0 ) // all beside a film that is smaller than a tile
        counts->samples = 1.0;
}
