// The measurement of cost: levels of ever more passes at some positions of the path.
#include "measure/cost_internal.h"

#include "base/random.h"
#include "base/system.h"
#include "trace/trace.h"

#include <math.h>

#define WANTED_LEVELS 4  // levels that the budget is planned for
#define MIN_PIXELS 20000 // traced of a frame at the least
#define PROBE_PIXELS 6000

static RfResult make_region( RfCostStudy* s, double position, double pixels, RfTestRegion* region, RfError* error )
{
    const RfCostJob* job = s->job;
    int frame = job->frames[(int)( position * job->frame_count )];
    return rf_create_test_region( job->tracer, job->eyes, job->eye_count, frame, 2 * s->settings[1].group + 1, pixels,
                                  s->settings + 1, job->watch, region, error );
}

// Renders all frames of the region one by one, or as one group with reuse.
static RfResult try_curve( const RfCostStudy* s, const RfTestRegion* region, int curve, int passes, uint64_t salt, RfTrial* trial,
                           RfError* error )
{
    RfRenderSettings settings = s->settings[curve];
    settings.seed = rf_mix64( settings.seed ^ rf_mix64( salt ) );
    return rf_run_trial( s->job->tracer, region, settings.group == 0 ? region->frames : 1, passes, &settings, s->job->watch,
                         trial, error );
}

// Runs `task` for 0 … count − 1 on several threads, and returns the first failure.
typedef RfResult TaskFn( RfCostStudy* study, int number, RfError* error );

static RfResult run_tasks( RfCostStudy* s, int count, TaskFn* task, RfError* error )
{
    RfResult results[RF_COST_TASKS];
    RfError errors[RF_COST_TASKS];
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
static RfResult probe( RfCostStudy* s, double* pixel_seconds, RfError* error )
{
    double start = rf_wall_seconds();
    RfTestRegion region;
    RfTrial trial;
    RfResult result = make_region( s, 0.5, PROBE_PIXELS, &region, error );
    for ( int k = 0; k < 2 && result == RF_OK; ++k )
        result = try_curve( s, &region, k, s->first_passes, 0x9b0be, &trial, error );
    *pixel_seconds = ( rf_wall_seconds() - start ) / rf_region_pixels( &region );
    rf_destroy_test_region( &region );
    return result;
}

static RfResult make_position( RfCostStudy* s, int number, RfError* error )
{
    return make_region( s, ( number + 0.5 ) / s->cost->positions, s->pixels, s->regions + number, error );
}

// So many pixels that the budget allows WANTED_LEVELS levels, each taking twice as long as the one before.
static RfResult choose_pixels( RfCostStudy* s, RfError* error )
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

static RfResult make_regions( RfCostStudy* s, RfError* error )
{
    s->cost->positions = s->job->frame_count < RF_COST_POSITIONS ? s->job->frame_count : RF_COST_POSITIONS;
    RfResult result = choose_pixels( s, error );
    if ( result == RF_OK )
        result = run_tasks( s, s->cost->positions, make_position, error );
    for ( int i = 0; i < s->cost->positions; ++i )
        s->cost->pixels += rf_region_pixels( s->regions + i ) / s->cost->positions;
    return result;
}

// Adds the row of a level: the mean over its positions.
static void add_row( RfCostStudy* s, int curve, RfCostCurve* c, int passes )
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
                                         .seconds = rf_cost_frame_seconds( s->job, c, passes, wall / samples ),
                                         .cpu_seconds = rf_cost_frame_seconds( s->job, c, passes, cpu / samples ),
                                         .relmse = relmse };
}

// Takes the time for finishing a frame from the first level.
static void fit_finish_time( RfCostStudy* s, int curve, RfCostCurve* c )
{
    double seconds = 0.0, pixels = 0.0;
    for ( int i = 0; i < s->unit_count; ++i )
    {
        seconds += s->trials[i][curve].finish_seconds;
        pixels += s->trials[i][curve].finish_pixels;
    }
    c->finish_seconds = pixels > 0.0 ? fmax( seconds, 0.0 ) / pixels * rf_cost_frame_pixels( s->job ) : 0.0;
}

// All threads of the render work as fast as those of the trials.
static RfCostPart part_of( const RfCostStudy* s, const RfTrial* trial )
{
    return ( RfCostPart ){ .relmse = trial->relmse / trial->weight,
                           .wall_seconds = trial->wall_seconds / s->threads,
                           .cpu_seconds = trial->cpu_seconds,
                           .samples = trial->timed_samples };
}

static RfResult try_position( RfCostStudy* s, int number, RfError* error )
{
    int position = number / 2, curve = number % 2;
    return try_curve( s, s->regions + position, curve, s->first_passes << s->level,
                      (uint64_t)( s->level * RF_COST_POSITIONS + position + 1 ), &s->trials[s->unit_count + position][curve],
                      error );
}

static RfResult run_level( RfCostStudy* s, int level, RfError* error )
{
    int passes = s->first_passes << level;
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
static RfResult run_levels( RfCostStudy* s, RfError* error )
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

RfResult rf_measure_cost( const RfCostJob* job, RfCost* cost, RfError* error )
{
    RfCostStudy s = { .job = job, .cost = cost, .start = rf_wall_seconds() };
    *cost = ( RfCost ){ .positions = 0 };
    RfResult result = rf_resolve_cost_settings( &s, error );
    if ( result == RF_OK )
        result = make_regions( &s, error );
    if ( result == RF_OK )
        result = run_levels( &s, error );
    if ( s.unit_count > 0 )
        rf_fit_cost_curves( &s );
    for ( int i = 0; i < RF_COST_POSITIONS; ++i )
        rf_destroy_test_region( s.regions + i );
    if ( result == RF_OK && !( cost->plain.relmse > 0.0 && cost->reuse.relmse > 0.0 ) )
        return rf_fail( error, RF_ERROR_SCENE,
                        "the error of the test images cannot be measured: they are black, or have NaN or infinite pixels" );
    return result;
}
