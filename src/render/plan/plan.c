// How large a group pays: a few thousand hits along the path, traced by the render's own estimator, give the number of cameras
// that see them and of the rays that this takes; the gain follows by fixed costs of rays.
#include "reframe/plan.h"
#include "render/memory/memory.h"
#include "render/settings.h"
#include "render/worlds.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Traces some batches of the path by the estimator, one at a time.
typedef struct Probe
{
    const RfEye* eyes;
    RfGroupPlan plan;          // of the largest groups looked at
    RfRenderSettings settings; // with a seed of its own
    RfArena arena;
    RfRenderSizes sizes; // for the largest group looked at
    void *compiled, *scratch, *batch;
    RfEstimatorGroup group;
    int eye; // index in it of the frame that is traced
    RfWorlds worlds;
} Probe;

// The probe looks at so many frames, and batches of each.
#define PROBE_FRAMES 4
#define PROBE_JOBS 8

// What it counted: sums over own-frame samples.
typedef struct Counts
{
    double samples, hits, glossy;
    RfRayCounts rays; // without reuse
    // by row
    double share[RF_PLAN_ROWS]; // Σ w: share of each hit's weight that its own frame keeps
    double eye_rays[RF_PLAN_ROWS];
} Counts;

#define PROBE_SEED 1 // whatever that of the render: the choice of the group is not to depend on it

static void compile_group( Probe* p )
{
    p->group.compiled = p->compiled;
    if ( p->compiled != NULL )
        p->settings.estimator->compile( &p->group, p->compiled );
}

static RfResult alloc_probe( Probe* p, RfError* error )
{
    const RfEstimator* estimator = p->settings.estimator;
    RfResult result = rf_arena_alloc( &p->arena, "group", p->sizes.of_estimator.compiled, &p->compiled, error );
    compile_group( p );
    if ( result == RF_OK )
        result = rf_arena_alloc( &p->arena, "scratch", p->sizes.of_estimator.trace_scratch, &p->scratch, error );
    if ( result != RF_OK )
        return result;
    estimator->lay_out_scratch( &p->group, p->scratch );
    result = rf_arena_alloc( &p->arena, "hit records", p->sizes.of_estimator.batch, &p->batch, error );
    if ( result == RF_OK )
        estimator->lay_out_batch( &p->group, p->batch );
    return result;
}

// For groups of up to `most_eyes`. Fails with RF_ERROR_MEMORY.
static RfResult begin_probe( const RfShot* shot, const RfRenderSettings* settings, int most_eyes, Probe* probe, RfError* error )
{
    const RfScene* scene = rf_tracer_scene( shot->tracer );
    const RfEye* eyes = shot->eyes;
    int eye_count = shot->eye_count;
    RfGroupPlan plan = rf_plan_shots( eyes, eye_count, most_eyes / 2, settings->spp );
    *probe = ( Probe ){ .eyes = eyes, .plan = plan, .settings = *settings };
    probe->settings.seed = PROBE_SEED;
    probe->arena = rf_create_arena( settings->memory );
    probe->sizes = rf_render_sizes( scene, eyes, &plan, 1, settings );
    probe->group =
        rf_size_group( scene, rf_scene_traits( scene, eyes, eye_count, &probe->settings ), eyes, plan.eyes, &probe->settings );
    probe->group.tracer = shot->tracer;
    probe->group.max_depth = rf_tracer_lights( shot->tracer )->count > 0 ? settings->max_depth : 1;
    RfResult result =
        rf_create_worlds( shot, rf_worlds_held( scene, eye_count, plan.eyes, false, false ), false, &probe->worlds, error );
    return result == RF_OK ? alloc_probe( probe, error ) : result;
}

static void end_probe( Probe* p )
{
    rf_destroy_worlds( &p->worlds );
    rf_arena_free( &p->arena, "group", p->compiled, p->sizes.of_estimator.compiled );
    rf_arena_free( &p->arena, "scratch", p->scratch, p->sizes.of_estimator.trace_scratch );
    rf_arena_free( &p->arena, "hit records", p->batch, p->sizes.of_estimator.batch );
    p->scratch = NULL;
    p->batch = NULL;
}

// Sets the probe's group to `eyes` frames around `frame`, as far as its shot goes.
static void aim_probe( Probe* p, int frame, int eyes )
{
    int first;
    rf_frames_around( &p->plan, frame, &first, &eyes );
    p->group.eyes = p->eyes + first;
    p->group.first_frame = first;
    p->group.eye_count = eyes;
    p->eye = frame - first;
    compile_group( p );
    p->group.tracers = rf_open_worlds( &p->worlds, first, eyes );
    p->group.tracer = p->group.tracers != NULL && eyes == 1 ? *p->group.tracers : p->worlds.still;
}

static int probe_frame( const Probe* p, int i )
{
    return (int)( (int64_t)( 2 * i + 1 ) * p->plan.frames / ( 2 * PROBE_FRAMES ) );
}

// The batch of the k-th position there: spread over the film, other places in every frame.
static int probe_job( const Probe* p, int i, int k )
{
    int64_t place = PROBE_FRAMES * k + i, places = PROBE_FRAMES * PROBE_JOBS;
    return (int)( ( 2 * place + 1 ) * p->sizes.of_estimator.jobs / ( 2 * places ) );
}

// Which light holds in all frames is a matter of the group.
static void look_again( Probe* p, int job, int pass )
{
    RfRayCounts rays = { 0 };
    if ( p->group.tracers == NULL )
        return;
    p->group.first_hits_only = true;
    p->settings.estimator->trace( &p->group, ( RfTraceJob ){ p->eye, job, pass }, p->batch, p->scratch, &rays );
    p->group.first_hits_only = false;
}

static void count_row( Probe* p, int frame, int job, int pass, int row, int eyes, Counts* c )
{
    RfReuseCount count = { 0 };
    if ( p->settings.estimator->count_reuse == NULL )
        return;
    aim_probe( p, frame, eyes );
    look_again( p, job, pass );
    p->settings.estimator->count_reuse( &p->group, p->eye, p->batch, p->scratch, &count );
    c->hits += row == 0 ? count.hits : 0.0;
    c->glossy += row == 0 ? count.glossy : 0.0;
    c->share[row] += count.own_share;
    c->eye_rays[row] += count.eye_rays;
}

// The i-th of the frames looked at, in batches that are a pass of their own each: small films have fewer patches.
static void count_frame( Probe* p, int i, const int* eyes, int rows, Counts* c )
{
    int frame = probe_frame( p, i );
    bool moves = p->worlds.count > 0; // then batches are traced again for each row, whose swept geometry is made once
    for ( int k = 0; k < PROBE_JOBS; ++k )
    {
        aim_probe( p, frame, 1 );
        RfTraceJob job = { 0, probe_job( p, i, k ), k };
        c->samples += p->settings.estimator->trace( &p->group, job, p->batch, p->scratch, &c->rays );
        for ( int r = 0; r < rows && !moves; ++r )
            count_row( p, frame, job.job, k, r, eyes[r], c );
    }
    for ( int r = 0; r < rows && moves; ++r )
    {
        for ( int k = 0; k < PROBE_JOBS; ++k )
            count_row( p, frame, probe_job( p, i, k ), k, r, eyes[r], c );
    }
}

// Counts for groups of eyes[0 … rows), the first of which is 1.
static void count_plan( Probe* probe, const int* eyes, int rows, Counts* counts )
{
    *counts = ( Counts ){ 0 };
    rf_set_float_mode();
    for ( int i = 0; i < PROBE_FRAMES; ++i )
        count_frame( probe, i, eyes, rows, counts );
    if ( counts->samples == 0.0 ) // all beside a film that is smaller than a tile
        counts->samples = 1.0;
}

// Cost of a pixel over all groups where a sample costs `own`, and `reuse` for every other camera of its group:
// Σ passes · eyes · (own + (eyes − 1) · reuse).
static double plan_work( const RfGroupPlan* plan, double own, double reuse )
{
    double work = 0.0;
    for ( int g = 0; g < plan->groups; ++g )
    {
        RfGroup group = rf_group( plan, g );
        work += (double)group.passes * group.eyes * ( own + ( group.eyes - 1 ) * reuse );
    }
    return work;
}

static const int s_groups[RF_PLAN_ROWS] = { 0, 1, 2, 3, 4, 6, 8, 12, 16 };

// Relative costs of rays, which the choice of the group rests on: about nanoseconds on one core of
// a 2.5 GHz Xeon with AVX2.
#define COST_PRIMARY 100.0 // including records and films
#define COST_PATH 200.0
#define COST_SHADOW 100.0
#define COST_TILE 40.0
#define COST_EYE 30.0      // a visibility test
#define COST_ADD 4.0       // adding a hit to a film, plus
#define COST_DIRECTION 7.0 // this for each direction of a glossy hit

// Why the automatic choice leaves a row out.
static const char s_no_room[] = "does not fit in memory", s_films[] = "films take over half of the memory",
                  s_sweeps[] = "needs several sweeps", s_rounded[] = "samples rounded up too far";

#define FLAT 0.9      // of the best gain is good enough: smaller groups need less memory, and less time for a single frame
#define ROUNDING 1.25 // rounding up may trace so many times the samples asked for

static void list_rows( const RfShot* shot, const RfRenderSettings* settings, RfPlan* plan )
{
    int spp = settings->spp, longest = rf_longest_shot( shot->eyes, shot->eye_count );
    for ( int i = 0; i < RF_PLAN_ROWS; ++i )
    {
        RfGroupPlan groups = rf_plan_samples( shot, s_groups[i], spp );
        plan->rows[plan->count++] = ( RfPlanRow ){ .group = groups.eyes / 2,
                                                   .eyes = groups.eyes,
                                                   .spp = groups.spp,
                                                   .samples = NAN,
                                                   .rays_primary = NAN,
                                                   .rays_path = NAN,
                                                   .rays_shadow = NAN,
                                                   .rays_tile = NAN,
                                                   .rays_eye = NAN,
                                                   .reach = NAN,
                                                   .gain = NAN };
        if ( groups.eyes == longest || !rf_has_groups( settings->estimator ) )
            break;
    }
}

// Gain: samples that land in a frame over the cost of a sample, relative to no reuse.
static double gain_of( const RfGroupPlan* plan, double reach, double own, double reuse )
{
    double samples = (double)plan->frames * plan->spp;
    double work = plan_work( plan, own, reuse );
    return work > 0.0 ? reach * samples * own / work : 1.0;
}

// Samples and rays of the frames asked for, over all sweeps.
static void count_rays( const RfGroupPlan* plan, const RfShot* shot, const Counts* counts, int index, RfPlanRow* row )
{
    const int* frames = shot->frames;
    int frame_count = shot->frame_count;
    double pixels = (double)shot->eyes->width * shot->eyes->height;
    int per_sweep = row->fit.sweeps > 1 ? row->fit.films : frame_count;
    double samples = 0.0, others = 0.0;
    for ( int first = 0; first < frame_count; first += per_sweep )
        rf_add_group_samples( plan, frames, first, first + per_sweep < frame_count ? first + per_sweep : frame_count, &samples,
                              &others );
    double per = pixels / counts->samples;
    row->samples = samples * pixels;
    row->rays_primary = samples * pixels;
    row->rays_path = samples * per * (double)counts->rays.path;
    row->rays_shadow = samples * per * (double)counts->rays.shadow;
    row->rays_tile = samples * per * (double)counts->rays.tile;
    // visibility from the own camera is tested in blended scenes only, and counted there
    row->rays_eye =
        row->eyes > 1 ? others / ( row->eyes - 1 ) * per * counts->eye_rays[index] : samples * per * counts->eye_rays[index];
}

static void fixed_costs( const Counts* c, const RfEstimatorSizes* sizes, int index, int eyes, double* own, double* reuse )
{
    double adding = ( c->hits * COST_ADD + c->glossy * COST_DIRECTION * sizes->directions ) / c->samples;
    *own = ( COST_PRIMARY * (double)c->rays.primary + COST_PATH * (double)c->rays.path + COST_SHADOW * (double)c->rays.shadow +
             COST_TILE * (double)c->rays.tile ) /
               c->samples +
           adding;
    *reuse = eyes > 1 ? COST_EYE * c->eye_rays[index] / c->samples / ( eyes - 1 ) + adding : 0.0;
}

static RfShot whole_path( const RfShot* shot )
{
    return ( RfShot ){ shot->tracer, shot->eyes, shot->eye_count, NULL, shot->eye_count };
}

// Why the automatic choice leaves a group out; NULL: it does not. It depends on path, size and settings
// alone, as if the whole path were asked for and one thread had all the memory. Several sweeps
// repeat the tracing, which the gain does not account for.
static const char* reason_against( const RfShot* shot, const RfRenderSettings* settings, const RfPlanRow* row )
{
    RfRenderSettings s = *settings;
    s.group = row->group;
    s.threads = 1;
    if ( s.adaptive == RF_ADAPTIVE_AUTO ) // what may be of use in some frames is no reason for smaller groups in all
        s.adaptive = RF_ADAPTIVE_OFF;
    RfGroupPlan plan = rf_plan_samples( shot, row->group, settings->spp );
    RfRenderSizes sizes = rf_render_sizes( rf_tracer_scene( shot->tracer ), shot->eyes, &plan, shot->eye_count, &s );
    RfMemoryFit fit;
    RfShot whole = whole_path( shot );
    if ( rf_fit_memory( &whole, &s, &fit, NULL ) != RF_OK )
        return s_no_room;
    if ( rf_films_bytes( &sizes ) > settings->memory / 2 )
        return s_films;
    if ( fit.sweeps > 1 )
        return s_sweeps;
    return (double)row->spp > ROUNDING * settings->spp ? s_rounded : NULL;
}

// The smallest group whose gain is as good as the best.
static void choose_row( RfPlan* plan )
{
    double best = 1.0;
    for ( int i = 0; i < plan->count; ++i )
        best = plan->rows[i].excluded == NULL && plan->rows[i].gain > best ? plan->rows[i].gain : best;
    while ( plan->rows[plan->chosen].excluded != NULL || plan->rows[plan->chosen].gain < FLAT * best )
        plan->chosen += 1;
    plan->rows[plan->chosen].chosen = true;
}

// A group that was chosen for the memory at hand goes without the memory of extra samples, which few frames may
// need, rather than through the path several times.
static RfResult settle_adaptive( const RfShot* shot, const RfRenderSettings* settings, RfPlan* plan, RfError* error )
{
    RfShot whole = whole_path( shot );
    RfPlanRow* row = plan->rows + plan->chosen;
    RfRenderSettings s = *settings;
    RfMemoryFit fit;
    plan->adaptive = settings->adaptive == RF_ADAPTIVE_AUTO && row->eyes == 1 ? RF_ADAPTIVE_OFF : settings->adaptive;
    s.group = row->group;
    s.threads = 1;
    if ( plan->adaptive != RF_ADAPTIVE_AUTO || ( rf_fit_memory( &whole, &s, &fit, NULL ) == RF_OK && fit.sweeps == 1 ) )
        return RF_OK;
    plan->adaptive = s.adaptive = RF_ADAPTIVE_OFF;
    s.threads = settings->threads;
    return rf_fit_memory( shot, &s, &row->fit, error );
}

static int rows_against( const RfPlan* plan, const char* reason )
{
    int count = 0;
    for ( int i = 0; i < plan->count; ++i )
        count += plan->rows[i].excluded == reason;
    return count;
}

static void explain( RfPlan* plan, const RfRenderSettings* settings )
{
    char rounded[96];
    snprintf( rounded, sizeof rounded, "%d sample%s would be rounded up by more than a quarter", settings->spp,
              settings->spp == 1 ? "" : "s" );
    const char* const reasons[][3] = { { s_films, s_films, s_films },
                                       { s_sweeps, s_sweeps, "need several sweeps" },
                                       { s_rounded, rounded, rounded },
                                       { s_no_room, s_no_room, "do not fit in memory" } };
    const RfPlanRow* best = plan->rows + plan->chosen;
    for ( int i = 0; i < plan->count; ++i )
        best = plan->rows[i].excluded == NULL && plan->rows[i].gain > best->gain ? plan->rows + i : best;
    size_t size = sizeof plan->why;
    if ( !rf_has_groups( settings->estimator ) )
    {
        snprintf( plan->why, size, "the estimator '%s' reuses no frames", settings->estimator->name );
        return;
    }
    size_t used = (size_t)snprintf( plan->why, size,
                                    "the smallest group within 10 %% of the best gain at fixed ray costs, %.1f with group %d",
                                    best->gain, best->group );
    for ( size_t k = 0; k < sizeof reasons / sizeof reasons[0] && used < size; ++k )
    {
        int rows = rows_against( plan, reasons[k][0] );
        if ( rows > 0 )
            used += (size_t)snprintf( plan->why + used, size - used, "; %d row%s excluded: %s", rows, rows == 1 ? "" : "s",
                                      reasons[k][rows == 1 ? 1 : 2] );
    }
    if ( plan->adaptive != settings->adaptive && plan->rows[plan->chosen].eyes > 1 && used < size )
        snprintf( plan->why + used, size - used, "; without extra samples, which do not fit in memory" );
}

static RfResult count( const RfShot* shot, const RfRenderSettings* settings, const RfPlan* plan, Counts* counts, RfError* error )
{
    Probe probe;
    int group_eyes[RF_PLAN_ROWS], most = 1;
    for ( int i = 0; i < plan->count; ++i )
    {
        // rows that do not fit have no room for their records here
        group_eyes[i] = rf_plan_row_fits( plan->rows + i ) ? plan->rows[i].eyes : 1;
        most = group_eyes[i] > most ? group_eyes[i] : most;
    }
    RfResult result = begin_probe( shot, settings, most, &probe, error );
    if ( result == RF_OK )
    {
        count_plan( &probe, group_eyes, plan->count, counts );
        result = rf_check_worlds( &probe.worlds, error );
    }
    end_probe( &probe );
    return result;
}

// Only the smallest group has to fit.
static RfResult fit_rows( const RfShot* shot, const RfRenderSettings* settings, RfPlan* plan, RfError* error )
{
    for ( int i = 0; i < plan->count; ++i )
    {
        RfPlanRow* row = plan->rows + i;
        RfRenderSettings s = *settings;
        s.group = row->group;
        RfResult result = rf_fit_memory( shot, &s, &row->fit, error );
        if ( result != RF_OK && i == 0 )
            return result;
        if ( i > 0 )
            row->excluded = result != RF_OK ? s_no_room : reason_against( shot, settings, row );
    }
    return RF_OK;
}

static void weigh_rows( const RfShot* shot, const RfRenderSettings* settings, const RfEstimatorSizes* sizes, const Counts* counts,
                        RfPlan* plan )
{
    for ( int i = 0; i < plan->count; ++i )
    {
        RfPlanRow* row = plan->rows + i;
        if ( !rf_plan_row_fits( row ) )
            continue;
        RfGroupPlan groups = rf_plan_samples( shot, row->group, settings->spp );
        double own, reuse;
        fixed_costs( counts, sizes, i, row->eyes, &own, &reuse );
        row->reach = counts->share[i] > 0.0 ? counts->hits / counts->share[i] : 1.0;
        row->gain = gain_of( &groups, row->reach, own, reuse );
        count_rays( &groups, shot, counts, i, row );
    }
}

RfResult rf_plan_render( const RfShot* shot, const RfRenderSettings* settings, RfPlan* plan, RfError* error )
{
    RfRenderSettings common;
    *plan = ( RfPlan ){ .count = 0 };
    RfResult result = rf_resolve_common( shot, settings, &common, error );
    if ( result != RF_OK )
        return result;
    list_rows( shot, &common, plan );
    const RfScene* scene = rf_tracer_scene( shot->tracer );
    result = fit_rows( shot, &common, plan, error );
    Counts counts;
    if ( result == RF_OK )
        result = count( shot, &common, plan, &counts, error );
    if ( result != RF_OK )
        return result;
    RfGroupPlan groups = rf_plan_shots( shot->eyes, shot->eye_count, 0, common.spp );
    RfRenderSizes sizes = rf_render_sizes( scene, shot->eyes, &groups, 1, &common );
    weigh_rows( shot, &common, &sizes.of_estimator, &counts, plan );
    plan->hit_share = counts.hits / counts.samples;
    plan->glossy_share = counts.glossy / counts.samples;
    choose_row( plan );
    result = settle_adaptive( shot, &common, plan, error );
    if ( result != RF_OK )
        return result;
    weigh_rows( shot, &common, &sizes.of_estimator, &counts, plan ); // the chosen one's sweeps
    explain( plan, &common );
    rf_record_bytes( scene, &common, plan->rows[plan->chosen].eyes, &plan->bytes_diffuse, &plan->bytes_glossy );
    return RF_OK;
}

void rf_record_bytes( const RfScene* scene, const RfRenderSettings* settings, int eyes, size_t* diffuse, size_t* glossy )
{
    RfEye eye = { .width = 1, .height = 1 };
    RfEstimatorGroup group = rf_size_group( scene, rf_scene_traits( scene, &eye, 1, settings ), &eye, eyes, settings );
    RfEstimatorSizes sizes = settings->estimator->sizes( &group );
    *diffuse = sizes.diffuse_record;
    *glossy = sizes.glossy_record;
}

// Another group is named where it is so many times as efficient: a tenth is within the error of the model.
#define FASTER 1.25

// What paths of a group cost and bring: by the rows of a plan, between them by the line through the nearest two.
typedef struct Costs
{
    double reach;
    double reuse; // of a sample in another frame, over that of tracing it
} Costs;

static Costs costs_of_row( const RfShot* shot, const RfRenderSettings* settings, const RfPlanRow* row )
{
    RfGroupPlan plan = rf_plan_samples( shot, row->group, settings->spp );
    double traced = plan_work( &plan, 1.0, 0.0 ), others = plan_work( &plan, 0.0, 1.0 ), all = (double)plan.frames * plan.spp;
    Costs costs = { row->reach, 0.0 };
    if ( others > 0.0 && row->gain > 0.0 ) // gain = reach · all / ( traced + reuse · others )
        costs.reuse = fmax( ( row->reach * all / row->gain - traced ) / others, 0.0 );
    return costs;
}

static Costs costs_of( const RfShot* shot, const RfRenderSettings* settings, const RfPlan* plan, int group )
{
    const RfPlanRow *below = plan->rows, *above = NULL;
    for ( int i = 0; i < plan->count && above == NULL; ++i )
    {
        const RfPlanRow* row = plan->rows + i;
        if ( !rf_plan_row_fits( row ) )
            continue;
        below = row->group <= group ? row : below;
        above = row->group > group ? row : NULL;
    }
    Costs a = costs_of_row( shot, settings, below );
    if ( above == NULL )
        return a;
    Costs b = costs_of_row( shot, settings, above );
    double t = (double)( group - below->group ) / ( above->group - below->group );
    return ( Costs ){ a.reach + t * ( b.reach - a.reach ), a.reuse + t * ( b.reuse - a.reuse ) };
}

// The work of the frames asked for, where a sample costs 1, and `reuse` for each of them that it is tested for.
static double work_of( const RfGroupPlan* plan, const RfShot* shot, double reuse )
{
    double work = 0.0;
    for ( int g = 0, first = 0; g < plan->groups; ++g )
    {
        RfGroup group = rf_group( plan, g );
        int wanted = 0;
        while ( first < shot->frame_count && shot->frames[first] < group.first )
            ++first;
        while ( first + wanted < shot->frame_count && shot->frames[first + wanted] < group.first + group.eyes )
            ++wanted;
        if ( wanted > 0 )
            work += (double)group.passes * ( group.eyes + reuse * wanted * ( group.eyes - 1 ) );
    }
    return work;
}

// What is beyond the work that these frames have of a render of the whole path.
static double halo_of( const RfGroupPlan* plan, const RfShot* shot, double reuse )
{
    double whole = plan_work( plan, 1.0, reuse ), part = work_of( plan, shot, reuse );
    return fmax( 1.0 - whole * shot->frame_count / plan->frames / part, 0.0 );
}

RfResult rf_plan_halo( const RfShot* shot, const RfRenderSettings* settings, double least, RfHalo* halo, RfError* error )
{
    RfPlan plan;
    RfGroupPlan groups = rf_plan_samples( shot, settings->group, settings->spp );
    *halo = ( RfHalo ){ halo_of( &groups, shot, 0.0 ), settings->group, 0.0 };
    if ( halo->share < least ) // reuse only makes it less
        return RF_OK;
    RfResult result = rf_plan_render( shot, settings, &plan, error );
    if ( result != RF_OK )
        return result;
    Costs now = costs_of( shot, settings, &plan, settings->group );
    halo->share = halo_of( &groups, shot, now.reuse );
    double each = now.reach * groups.spp / work_of( &groups, shot, now.reuse ), best = FASTER * each;
    for ( int i = 0; i < plan.count; ++i )
    {
        const RfPlanRow* row = plan.rows + i;
        if ( row->excluded != NULL || !rf_plan_row_fits( row ) || row->group >= settings->group )
            continue;
        RfGroupPlan other = rf_plan_samples( shot, row->group, settings->spp );
        Costs costs = costs_of_row( shot, settings, row );
        double efficiency = costs.reach * other.spp / work_of( &other, shot, costs.reuse );
        if ( efficiency <= best )
            continue;
        best = efficiency;
        halo->group = row->group;
        halo->saved = 1.0 - each / best;
    }
    return RF_OK;
}

// Ranges of frames for several machines. A range renders all groups that hold its frames, so the groups at a cut are rendered
// on both sides: its halo. It is least where the frames asked for have a gap, more within the path, and most at its ends, where
// groups have more passes, or between frames of a camera that stands still.

#define UNEVEN 1.05 // the longest range may take so many times the least possible, if that makes halos smaller
#define HALVINGS 50

// Samples per pixel that frames trace: of [a, b) it is halo[a] + sum[b] - sum[a].
typedef struct Work
{
    int count;    // frames asked for
    double* sum;  // count + 1: of groups, each with the first of the frames that it holds
    double* halo; // count: of groups that hold the frame and one before it
} Work;

static double range_work( const Work* w, int first, int end ) { return w->halo[first] + w->sum[end] - w->sum[first]; }

static void add_frames( const RfGroupPlan* plan, const int* eyes, Work* w )
{
    int done = 0; // groups
    w->sum[0] = 0.0;
    for ( int i = 0; i < w->count; ++i )
    {
        int first, last;
        rf_groups_of_frame( plan, eyes[i], &first, &last );
        double fresh = 0.0, again = 0.0;
        for ( int g = first; g <= last; ++g )
        {
            RfGroup group = rf_group( plan, g );
            *( g < done ? &again : &fresh ) += (double)group.passes * group.eyes;
        }
        w->sum[i + 1] = w->sum[i] + fresh;
        w->halo[i] = again;
        done = last + 1;
    }
}

// First frame after the longest range from `first` on that stays within the limit; at least one frame.
static int farthest( const Work* w, int first, double limit )
{
    int end = first + 1;
    while ( end < w->count && range_work( w, first, end + 1 ) <= limit )
        ++end;
    return end;
}

static bool is_enough( const Work* w, int ranges, double limit )
{
    int end = 0;
    for ( int i = 0; i < ranges && end < w->count; ++i )
        end = farthest( w, end, limit );
    return end == w->count;
}

// The least that the longest of so many ranges can take.
static double least_limit( const Work* w, int ranges )
{
    double low = 0.0, high = range_work( w, 0, w->count );
    for ( int i = 0; i < w->count; ++i )
        low = fmax( low, range_work( w, i, i + 1 ) );
    if ( is_enough( w, ranges, low ) )
        return low;
    for ( int i = 0; i < HALVINGS; ++i )
    {
        double middle = 0.5 * ( low + high );
        *( is_enough( w, ranges, middle ) ? &high : &low ) = middle;
    }
    return high;
}

// The earliest ends of ranges such that those after them can take the rest.
static void find_earliest( const Work* w, int ranges, double limit, RfPlanRange* list )
{
    int first = w->count;
    for ( int k = ranges - 1; k > 0; --k )
    {
        int end = first--;
        while ( first > k && range_work( w, first - 1, end ) <= limit )
            --first;
        first = first > k ? first : k;
        list[k - 1].end = first;
    }
}

// The end with the least halo; of equal ones that which comes nearest to even ranges.
static int best_end( const Work* w, int earliest, int latest, double even )
{
    int best = earliest;
    for ( int end = earliest + 1; end <= latest; ++end )
    {
        double more = w->halo[end] - w->halo[best];
        if ( more < 0.0 || ( more == 0.0 && fabs( w->sum[end] - even ) < fabs( w->sum[best] - even ) ) )
            best = end;
    }
    return best;
}

static void cut( const Work* w, int ranges, RfPlanRange* list )
{
    double limit = UNEVEN * least_limit( w, ranges ), whole = w->sum[w->count];
    find_earliest( w, ranges, limit, list );
    for ( int k = 0, first = 0; k < ranges; ++k )
    {
        int latest = farthest( w, first, limit ), most = w->count - ( ranges - 1 - k );
        int earliest = k < ranges - 1 && list[k].end > first ? list[k].end : first + 1;
        latest = latest < most ? latest : most;
        int end = k == ranges - 1 ? w->count : best_end( w, earliest, latest, whole * ( k + 1 ) / ranges );
        list[k] = ( RfPlanRange ){ first, end, range_work( w, first, end ) / whole };
        first = end;
    }
}

RfResult rf_plan_ranges( const RfShot* shot, const RfRenderSettings* settings, int machines, RfPlanRange* ranges,
                         int* range_count, RfError* error )
{
    int frame_count = shot->frame_count;
    if ( frame_count < 1 || machines < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "ranges need at least one frame and one machine" );
    size_t count = (size_t)frame_count;
    Work w = { .count = frame_count,
               .sum = malloc( ( count + 1 ) * sizeof( double ) ),
               .halo = malloc( count * sizeof( double ) ) };
    RfResult result = RF_OK;
    if ( w.sum != NULL && w.halo != NULL )
    {
        RfGroupPlan plan = rf_plan_samples( shot, settings->group, settings->spp );
        add_frames( &plan, shot->frames, &w );
        *range_count = machines < frame_count ? machines : frame_count;
        cut( &w, *range_count, ranges );
    }
    else
        result = rf_fail( error, RF_ERROR_MEMORY, "out of memory for the ranges of %d frames", frame_count );
    free( w.sum );
    free( w.halo );
    return result;
}
