#include "measure/cost.h"

#include "base/random.h"
#include "base/system.h"
#include "render/groups.h"
#include "reuse/tile.h"
#include "trace/trace.h"

#include <math.h>
#include <string.h>

#define FIRST_PASSES 2
#define WANTED_LEVELS 4  // levels that the budget is planned for
#define MIN_PIXELS 20000 // traced of a frame at the least
#define PROBE_PIXELS 6000
#define UNITS ( RF_COST_LEVELS * RF_COST_POSITIONS )
#define MOST_TASKS ( 2 * RF_COST_POSITIONS )

typedef struct Study
{
    const RfCostJob* job;
    RfCost* cost;
    RfRenderSettings settings[2]; // resolved
    RfTestRegion regions[RF_COST_POSITIONS];
    double pixels; // to trace of each of their frames
    int workers;   // trials at a time, with a thread each
    int threads;   // of the render
    int level;
    RfTrial trials[UNITS][2]; // per position and level: path tracing and reuse, with different seeds
    RfCostUnit units[UNITS];  // the measurements of these trials
    int unit_count;
    double start;
} Study;

static double frame_pixels( const RfCostJob* job ) { return (double)job->eyes->width * job->eyes->height; }

static RfResult make_region( Study* s, double position, double pixels, RfTestRegion* region, RfError* error )
{
    const RfCostJob* job = s->job;
    int frame = job->frames[(int)( position * job->frame_count )];
    return rf_create_test_region( job->tracer, job->eyes, job->eye_count, frame, 2 * s->settings[1].group + 1, pixels,
                                  s->settings + 1, job->watch, region, error );
}

// Renders all frames of the region by path tracing (curve 0), or as one group with reuse.
static RfResult try_curve( const Study* s, const RfTestRegion* region, int curve, int passes, uint64_t salt, RfTrial* trial,
                           RfError* error )
{
    RfRenderSettings settings = s->settings[curve];
    settings.seed = rf_mix64( settings.seed ^ rf_mix64( salt ) );
    return rf_run_trial( s->job->tracer, region, curve == 0 ? region->frames : 1, passes, &settings, s->job->watch, trial,
                         error );
}

// Runs `task` for 0 … count − 1 on several threads, and returns the first failure.
typedef RfResult TaskFn( Study* study, int number, RfError* error );

static RfResult run_tasks( Study* s, int count, TaskFn* task, RfError* error )
{
    RfResult results[MOST_TASKS];
    RfError errors[MOST_TASKS];
#pragma omp parallel for schedule( dynamic, 1 ) num_threads( s->workers )
    for ( int i = 0; i < count; ++i )
    {
        rf_set_float_mode();
        results[i] = task( s, i, errors + i );
    }
    for ( int i = 0; i < count; ++i )
    {
        if ( results[i] == RF_OK )
            continue;
        *error = errors[i];
        return results[i];
    }
    return RF_OK;
}

// Estimates the seconds per traced pixel of a position at the first level, from a few pieces.
static RfResult probe( Study* s, double* pixel_seconds, RfError* error )
{
    double start = rf_wall_seconds();
    RfTestRegion region;
    RfTrial trial;
    RfResult result = make_region( s, 0.5, PROBE_PIXELS, &region, error );
    for ( int k = 0; k < 2 && result == RF_OK; ++k )
        result = try_curve( s, &region, k, FIRST_PASSES, 0x9b0be, &trial, error );
    *pixel_seconds = ( rf_wall_seconds() - start ) / region.pieces.pixels;
    rf_destroy_test_region( &region );
    return result;
}

static RfResult make_position( Study* s, int number, RfError* error )
{
    return make_region( s, ( number + 0.5 ) / s->cost->positions, s->pixels, s->regions + number, error );
}

// So many pixels that the budget allows WANTED_LEVELS levels, each taking twice as long as the one before.
static RfResult choose_pixels( Study* s, RfError* error )
{
    double pixel_seconds;
    s->pixels = s->job->pixels;
    if ( s->pixels > 0.0 )
        return RF_OK;
    RfResult result = probe( s, &pixel_seconds, error );
    double left = s->job->budget - ( rf_wall_seconds() - s->start );
    double pixels = left * s->workers / ( ( 1 << WANTED_LEVELS ) * pixel_seconds * s->cost->positions );
    s->pixels = pixels > MIN_PIXELS ? pixels : MIN_PIXELS;
    return result;
}

static RfResult make_regions( Study* s, RfError* error )
{
    s->cost->positions = s->job->frame_count < RF_COST_POSITIONS ? s->job->frame_count : RF_COST_POSITIONS;
    RfResult result = choose_pixels( s, error );
    if ( result == RF_OK )
        result = run_tasks( s, s->cost->positions, make_position, error );
    for ( int i = 0; i < s->cost->positions; ++i )
        s->cost->pixels += s->regions[i].pieces.pixels / s->cost->positions;
    return result;
}

static double frame_seconds( const RfCostJob* job, const RfCostCurve* c, double spp, double sample_seconds )
{
    return frame_pixels( job ) * spp * sample_seconds + c->finish_seconds;
}

// Adds the row of a level: the mean over its positions.
static void add_row( Study* s, int curve, RfCostCurve* c, int passes )
{
    double relmse = 0.0, wall = 0.0, cpu = 0.0, samples = 0.0;
    for ( int i = s->unit_count - s->cost->positions; i < s->unit_count; ++i )
    {
        const RfCostPart* part = s->units[i].parts + curve;
        relmse += part->relmse / passes / s->cost->positions;
        wall += part->wall_seconds;
        cpu += part->cpu_seconds;
        samples += part->samples;
    }
    c->rows[c->count++] = ( RfCostRow ){ .spp = passes,
                                         .seconds = frame_seconds( s->job, c, passes, wall / samples ),
                                         .cpu_seconds = frame_seconds( s->job, c, passes, cpu / samples ),
                                         .relmse = relmse };
}

// Takes the time for finishing a frame from the first level.
static void fit_finish_time( Study* s, int curve, RfCostCurve* c )
{
    double seconds = 0.0, pixels = 0.0;
    for ( int i = 0; i < s->unit_count; ++i )
    {
        seconds += s->trials[i][curve].finish_seconds;
        pixels += s->trials[i][curve].finish_pixels;
    }
    c->finish_seconds = pixels > 0.0 ? fmax( seconds, 0.0 ) / pixels * frame_pixels( s->job ) : 0.0;
}

// All threads of the render work as fast as those of the trials.
static RfCostPart part_of( const Study* s, const RfTrial* trial )
{
    return ( RfCostPart ){ .relmse = trial->relmse / trial->weight,
                           .wall_seconds = trial->wall_seconds / s->threads,
                           .cpu_seconds = trial->cpu_seconds,
                           .samples = trial->timed_samples };
}

static RfResult try_position( Study* s, int number, RfError* error )
{
    int position = number / 2, curve = number % 2;
    return try_curve( s, s->regions + position, curve, FIRST_PASSES << s->level,
                      (uint64_t)( s->level * RF_COST_POSITIONS + position + 1 ), &s->trials[s->unit_count + position][curve],
                      error );
}

static RfResult run_level( Study* s, int level, RfError* error )
{
    int passes = FIRST_PASSES << level;
    if ( s->job->report != NULL )
        s->job->report( s->job->user, s->cost, passes );
    s->level = level;
    RfResult result = run_tasks( s, 2 * s->cost->positions, try_position, error );
    if ( result != RF_OK )
        return result;
    for ( int i = 0; i < s->cost->positions; ++i )
    {
        const RfTrial* trials = s->trials[s->unit_count];
        s->units[s->unit_count++] = ( RfCostUnit ){ passes, { part_of( s, trials ), part_of( s, trials + 1 ) } };
    }
    RfCostCurve* curves[2] = { &s->cost->plain, &s->cost->reuse };
    for ( int k = 0; k < 2; ++k )
    {
        if ( level == 0 )
            fit_finish_time( s, k, curves[k] );
        add_row( s, k, curves[k], passes );
    }
    return RF_OK;
}

// Runs levels as long as one that takes twice as long as the last still fits the budget.
static RfResult run_levels( Study* s, RfError* error )
{
    double last = 0.0;
    int levels = s->job->pixels > 0.0 ? 1 : RF_COST_LEVELS;
    for ( int level = 0; level < levels; ++level )
    {
        double begin = rf_wall_seconds();
        if ( level > 0 && begin - s->start + 2.0 * last > s->job->budget )
            break;
        RfResult result = run_level( s, level, error );
        if ( result != RF_OK )
            return result;
        last = rf_wall_seconds() - begin;
    }
    return RF_OK;
}

static RfInterval slope_of( const RfCostCurve* c )
{
    double seconds[RF_COST_LEVELS], errors[RF_COST_LEVELS];
    for ( int i = 0; i < c->count; ++i )
    {
        seconds[i] = c->rows[i].seconds;
        errors[i] = c->rows[i].relmse;
    }
    return rf_fit_slope( seconds, errors, c->count );
}

// All trials of a curve as one: each weighs as its passes, since more samples determine the error better. The pieces of a
// position are the same in all levels.
static void sum_trials( const Study* s, int curve, RfTrial* sum )
{
    *sum = ( RfTrial ){ 0 };
    for ( int i = 0; i < s->unit_count; ++i )
    {
        RfTrial trial = s->trials[i][curve];
        int first = 0, position = i % s->cost->positions;
        for ( int k = 0; k < position; ++k )
            first += s->regions[k].pieces.count;
        for ( int k = 0; k < trial.piece_count; ++k )
        {
            sum->pieces[first + k].weight += s->units[i].passes * trial.pieces[k].weight;
            sum->pieces[first + k].relmse += s->units[i].passes * trial.pieces[k].relmse;
        }
        int pieces = first + trial.piece_count;
        trial.piece_count = 0;
        rf_add_trial( sum, &trial );
        sum->piece_count = pieces > sum->piece_count ? pieces : sum->piece_count;
    }
}

static RfInterval speedup_of( const Study* s )
{
    RfTrial sums[2];
    for ( int k = 0; k < 2; ++k )
        sum_trials( s, k, sums + k );
    return rf_trial_gain( sums, sums + 1 );
}

static void fit_curves( Study* s )
{
    RfCostCurve* curves[2] = { &s->cost->plain, &s->cost->reuse };
    for ( int k = 0; k < 2; ++k )
    {
        RfCostPart sum = rf_sum_cost_units( s->units, s->unit_count, k );
        curves[k]->slope = slope_of( curves[k] );
        curves[k]->relmse = sum.relmse;
        curves[k]->sample_seconds = sum.wall_seconds;
    }
    s->cost->speedup = speedup_of( s );
    s->cost->seconds = rf_wall_seconds() - s->start;
}

// As many trials at a time as have room for their films and records, with a thread each.
static void share_threads( Study* s )
{
    RfRenderSettings settings = s->settings[1];
    RfMemoryFit fit;
    settings.threads = 1;
    int eyes = 2 * settings.group + 1 < s->job->eye_count ? 2 * settings.group + 1 : s->job->eye_count;
    s->threads = s->settings[1].threads;
    s->workers = s->threads < MOST_TASKS ? s->threads : MOST_TASKS;
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

static RfResult resolve_settings( Study* s, RfError* error )
{
    const RfCostJob* job = s->job;
    RfRenderSettings asked = *job->settings;
    asked.noise = asked.time = 0.0;
    asked.hold_all = false;
    asked.adaptive = RF_ADAPTIVE_OFF;
    RfRenderSettings *plain = s->settings, *reuse = s->settings + 1;
    RfResult result = rf_resolve_settings( job->tracer, job->eyes, job->eye_count, &asked, reuse, error );
    if ( result != RF_OK )
        return result;
    *plain = *reuse;
    plain->group = 0;
    plain->tile = rf_no_tile();
    RfGroupPlan groups = rf_plan_groups( job->eye_count, reuse->group, 1 );
    reuse->group = groups.eyes / 2;
    if ( reuse->group == 0 && reuse->tile.kind == RF_TILE_NONE )
        return rf_fail( error, RF_ERROR_USAGE,
                        "group 0 with tile 1 is path tracing, which all is compared with: take a larger group or a tile" );
    share_threads( s );
    s->cost->plain = ( RfCostCurve ){ .group = 0, .eyes = 1, .tile = plain->tile };
    s->cost->reuse = ( RfCostCurve ){ .group = reuse->group, .eyes = groups.eyes, .tile = reuse->tile };
    return RF_OK;
}

RfResult rf_measure_cost( const RfCostJob* job, RfCost* cost, RfError* error )
{
    Study s = { .job = job, .cost = cost, .start = rf_wall_seconds() };
    *cost = ( RfCost ){ .positions = 0 };
    RfResult result = resolve_settings( &s, error );
    if ( result == RF_OK )
        result = make_regions( &s, error );
    if ( result == RF_OK )
        result = run_levels( &s, error );
    if ( s.unit_count > 0 )
        fit_curves( &s );
    for ( int i = 0; i < RF_COST_POSITIONS; ++i )
        rf_destroy_test_region( s.regions + i );
    if ( result == RF_OK && !( cost->plain.relmse > 0.0 && cost->reuse.relmse > 0.0 ) )
        return rf_fail( error, RF_ERROR_SCENE,
                        "the error of the test images cannot be measured: they are black, or have NaN or infinite pixels" );
    return result;
}

RfCostPrediction rf_predict_cost( const RfCostJob* job, const RfCostCurve* curve, double relmse, int per_sweep )
{
    double wanted = ceil( curve->relmse / relmse );
    RfCostPrediction p = { .frame_seconds = (double)NAN, .seconds = (double)NAN };
    if ( !( wanted <= RF_MAX_SPP ) )
        return p;
    RfGroupPlan plan = rf_plan_groups( job->eye_count, curve->group, wanted < 2.0 ? 2 : (int)wanted );
    double samples = 0.0, unused = 0.0;
    for ( int first = 0; first < job->frame_count; first += per_sweep )
    {
        int end = job->frame_count - first < per_sweep ? job->frame_count : first + per_sweep;
        rf_add_group_samples( &plan, job->frames, first, end, &samples, &unused );
    }
    p.spp = plan.spp;
    p.frame_seconds = frame_seconds( job, curve, plan.spp, curve->sample_seconds );
    p.seconds = samples * frame_pixels( job ) * curve->sample_seconds + job->frame_count * curve->finish_seconds;
    return p;
}
