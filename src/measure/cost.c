// The measurement of cost: levels of ever more passes at some positions of the path.
#include "measure/cost.h"

#include "base/random.h"
#include "base/system.h"
#include "measure/image_error.h"
#include "measure/trial.h"
#include "render/groups.h"
#include "render/settings.h"
#include "reuse/tile/tile.h"
#include "trace/trace.h"

#include <math.h>

#define COST_UNITS ( RF_COST_LEVELS * RF_COST_POSITIONS )
#define COST_TASKS ( 2 * RF_COST_POSITIONS )

typedef struct CostStudy
{
    const RfCostJob* job;
    RfCost* cost;
    RfRenderSettings settings[2]; // resolved
    RfTestRegion regions[RF_COST_POSITIONS];
    double pixels;                 // to trace of each of their frames
    int workers;                   // trials at a time, with a thread each
    int threads;                   // of the render
    int level, first_passes;       // of the first level
    RfTrial trials[COST_UNITS][2]; // per position and level: path tracing and reuse, with different seeds
    RfCostUnit units[COST_UNITS];  // the measurements of these trials
    int unit_count;
    double start;
} CostStudy;

static inline double cost_frame_pixels( const RfCostJob* job ) { return (double)job->shot.eyes->width * job->shot.eyes->height; }

// Seconds of a frame of a curve with so many samples per pixel.
static inline double cost_frame_seconds( const RfCostJob* job, const RfCostCurve* c, double spp, double sample_seconds )
{
    return cost_frame_pixels( job ) * spp * sample_seconds + c->finish_seconds;
}

static const RfInterval s_unknown = { (double)NAN, (double)NAN, (double)NAN };

RfInterval rf_fit_slope( const double* x, const double* y, int count )
{
    double n = 0.0, su = 0.0, sv = 0.0, suu = 0.0, suv = 0.0, svv = 0.0;
    RfInterval slope = s_unknown;
    for ( int i = 0; i < count; ++i )
    {
        if ( !( x[i] > 0.0 && y[i] > 0.0 && isfinite( x[i] ) && isfinite( y[i] ) ) )
            continue;
        double u = log( x[i] ), v = log( y[i] );
        n += 1.0;
        su += u;
        sv += v;
        suu += u * u;
        suv += u * v;
        svv += v * v;
    }
    double spread = suu - su * su / n;
    if ( n < 2.0 || !( spread > 1e-12 * suu ) ) // all x are equal up to rounding
        return slope;
    slope.value = ( suv - su * sv / n ) / spread;
    if ( n < 3.0 )
        return slope;
    double rest = svv - sv * sv / n - slope.value * slope.value * spread;
    double margin = rf_student_quantile( (int)n - 2 ) * sqrt( fmax( rest, 0.0 ) / ( n - 2.0 ) / spread );
    slope.low = slope.value - margin;
    slope.high = slope.value + margin;
    return slope;
}

RfCostPart rf_sum_cost_units( const RfCostUnit* units, int count, int part )
{
    double weight = 0.0;
    RfCostPart sum = { 0.0, 0.0, 0.0, 0.0 };
    for ( int i = 0; i < count; ++i )
    {
        const RfCostPart* p = units[i].parts + part;
        weight += units[i].passes;
        sum.relmse += units[i].passes * p->relmse;
        sum.wall_seconds += p->wall_seconds;
        sum.cpu_seconds += p->cpu_seconds;
        sum.samples += p->samples;
    }
    return ( RfCostPart ){ sum.relmse / weight, sum.wall_seconds / sum.samples, sum.cpu_seconds / sum.samples, 1.0 };
}

// What the trials of a measurement of cost say, and what that predicts.

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
static void sum_trials( const CostStudy* s, int curve, RfTrial* sum )
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

static RfInterval speedup_of( const CostStudy* s )
{
    RfTrial sums[2];
    for ( int k = 0; k < 2; ++k )
        sum_trials( s, k, sums + k );
    return rf_trial_gain( sums, sums + 1 );
}

// All trials of a curve together, each weighing as its passes.
static double f1_squared_of( const CostStudy* s, int curve )
{
    double sum = 0.0, weights = 0.0;
    for ( int i = 0; i < s->unit_count; ++i )
    {
        double f1 = rf_trial_f1( &s->trials[i][curve], 1.0 );
        if ( !isfinite( f1 ) )
            continue;
        sum += s->units[i].passes * f1 * f1;
        weights += s->units[i].passes;
    }
    return weights > 0.0 ? sum / weights : (double)NAN;
}

// What all trials say together: slopes, errors and times of both curves, and the gain.
static void fit_cost_curves( CostStudy* s )
{
    RfCostCurve* curves[2] = { &s->cost->plain, &s->cost->reuse };
    for ( int k = 0; k < 2; ++k )
    {
        RfCostPart sum = rf_sum_cost_units( s->units, s->unit_count, k );
        curves[k]->slope = slope_of( curves[k] );
        curves[k]->relmse = sum.relmse;
        curves[k]->f1_squared = f1_squared_of( s, k );
        curves[k]->sample_seconds = sum.wall_seconds;
    }
    s->cost->speedup = speedup_of( s );
    s->cost->seconds = rf_wall_seconds() - s->start;
}

// So many samples, at least two.
static RfCostPrediction predict_samples( const RfCostJob* job, const RfCostCurve* curve, double wanted, int per_sweep )
{
    RfCostPrediction p = { .frame_seconds = (double)NAN, .seconds = (double)NAN };
    if ( !( wanted <= RF_MAX_SPP ) )
        return p;
    RfGroupPlan plan = rf_plan_shots( job->shot.eyes, job->shot.eye_count, curve->group, wanted < 2.0 ? 2 : (int)wanted );
    double samples = 0.0, unused = 0.0;
    for ( int first = 0; first < job->shot.frame_count; first += per_sweep )
    {
        int end = job->shot.frame_count - first < per_sweep ? job->shot.frame_count : first + per_sweep;
        rf_add_group_samples( &plan, job->shot.frames, first, end, &samples, &unused );
    }
    p.spp = plan.spp;
    p.frame_seconds = cost_frame_seconds( job, curve, plan.spp, curve->sample_seconds );
    p.seconds = samples * cost_frame_pixels( job ) * curve->sample_seconds + job->shot.frame_count * curve->finish_seconds;
    return p;
}

RfCostPrediction rf_predict_cost( const RfCostJob* job, const RfCostCurve* curve, double relmse, int per_sweep )
{
    return predict_samples( job, curve, ceil( curve->relmse / relmse ), per_sweep );
}

RfCostPrediction rf_predict_flicker_cost( const RfCostJob* job, const RfCostCurve* curve, double flicker, int per_sweep )
{
    return predict_samples( job, curve, ceil( curve->f1_squared / ( flicker * flicker ) ), per_sweep );
}

// What the measurement of cost renders with.

// As many trials at a time as have room for their films and records, with a thread each.
static void share_threads( CostStudy* s )
{
    RfRenderSettings settings = s->settings[1];
    RfMemoryFit fit;
    settings.threads = 1;
    int longest = rf_longest_shot( s->job->shot.eyes, s->job->shot.eye_count );
    int eyes = 2 * settings.group + 1 < longest ? 2 * settings.group + 1 : longest;
    s->threads = s->settings[1].threads;
    s->workers = s->threads < COST_TASKS ? s->threads : COST_TASKS;
    RfShot group = { s->job->shot.tracer, s->job->shot.eyes, eyes, NULL, eyes };
    if ( rf_fit_memory( &group, &settings, &fit, NULL ) == RF_OK )
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

// Settings of both curves, how many trials run at a time, and the threads and memory of each.
static RfResult resolve_cost_settings( CostStudy* s, RfError* error )
{
    const RfCostJob* job = s->job;
    RfRenderSettings asked = *job->settings;
    asked.noise = asked.flicker = asked.time = 0.0;
    asked.adaptive = RF_ADAPTIVE_OFF;
    RfRenderSettings *plain = s->settings, *reuse = s->settings + 1;
    RfResult result = rf_resolve_settings( &job->shot, &asked, reuse, error );
    if ( result != RF_OK )
        return result;
    *plain = *reuse;
    plain->estimator = rf_default_render_settings().estimator;
    plain->group = 0;
    plain->tile = rf_no_tile();
    RfGroupPlan groups = rf_plan_shots( job->shot.eyes, job->shot.eye_count, reuse->group, 1 );
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

#define WANTED_LEVELS 4  // levels that the budget is planned for
#define MIN_PIXELS 20000 // traced of a frame at the least
#define PROBE_PIXELS 6000

static RfResult make_region( CostStudy* s, double position, double pixels, RfTestRegion* region, RfError* error )
{
    const RfCostJob* job = s->job;
    int frame = job->shot.frames[(int)( position * job->shot.frame_count )];
    RfTestSite site = { frame, 2 * s->settings[1].group + 1, pixels };
    return rf_create_test_region( &job->shot, job->watch, &site, s->settings + 1, region, error );
}

// Renders all frames of the region one by one, or as one group with reuse.
static RfResult try_curve( const CostStudy* s, const RfTestRegion* region, int curve, int passes, uint64_t salt, RfTrial* trial,
                           RfError* error )
{
    RfRenderSettings settings = s->settings[curve];
    settings.seed = rf_mix64( settings.seed ^ rf_mix64( salt ) );
    return rf_run_trial( region, settings.group == 0 ? region->frames : 1, passes, &settings, trial, error );
}

// Runs `task` for 0 … count − 1 on several threads, and returns the first failure.
typedef RfResult TaskFn( CostStudy* study, int number, RfError* error );

static RfResult run_tasks( CostStudy* s, int count, TaskFn* task, RfError* error )
{
    RfResult results[COST_TASKS];
    RfError errors[COST_TASKS];
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
static RfResult probe( CostStudy* s, double* pixel_seconds, RfError* error )
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

static RfResult make_position( CostStudy* s, int number, RfError* error )
{
    return make_region( s, ( number + 0.5 ) / s->cost->positions, s->pixels, s->regions + number, error );
}

// So many pixels that the budget allows WANTED_LEVELS levels, each taking twice as long as the one before.
static RfResult choose_pixels( CostStudy* s, RfError* error )
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

static RfResult make_regions( CostStudy* s, RfError* error )
{
    s->cost->positions = s->job->shot.frame_count < RF_COST_POSITIONS ? s->job->shot.frame_count : RF_COST_POSITIONS;
    RfResult result = choose_pixels( s, error );
    if ( result == RF_OK )
        result = run_tasks( s, s->cost->positions, make_position, error );
    for ( int i = 0; i < s->cost->positions; ++i )
        s->cost->pixels += rf_region_pixels( s->regions + i ) / s->cost->positions;
    return result;
}

// Adds the row of a level: the mean over its positions.
static void add_row( CostStudy* s, int curve, RfCostCurve* c, int passes )
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
                                         .seconds = cost_frame_seconds( s->job, c, passes, wall / samples ),
                                         .cpu_seconds = cost_frame_seconds( s->job, c, passes, cpu / samples ),
                                         .relmse = relmse };
}

// Takes the time for finishing a frame from the first level.
static void fit_finish_time( CostStudy* s, int curve, RfCostCurve* c )
{
    double seconds = 0.0, pixels = 0.0;
    for ( int i = 0; i < s->unit_count; ++i )
    {
        seconds += s->trials[i][curve].finish_seconds;
        pixels += s->trials[i][curve].finish_pixels;
    }
    c->finish_seconds = pixels > 0.0 ? fmax( seconds, 0.0 ) / pixels * cost_frame_pixels( s->job ) : 0.0;
}

// All threads of the render work as fast as those of the trials.
static RfCostPart part_of( const CostStudy* s, const RfTrial* trial )
{
    return ( RfCostPart ){ .relmse = trial->relmse / trial->weight,
                           .wall_seconds = trial->wall_seconds / s->threads,
                           .cpu_seconds = trial->cpu_seconds,
                           .samples = trial->timed_samples };
}

static RfResult try_position( CostStudy* s, int number, RfError* error )
{
    int position = number / 2, curve = number % 2;
    return try_curve( s, s->regions + position, curve, s->first_passes << s->level,
                      (uint64_t)( s->level * RF_COST_POSITIONS + position + 1 ), &s->trials[s->unit_count + position][curve],
                      error );
}

static RfResult run_level( CostStudy* s, int level, RfError* error )
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
static RfResult run_levels( CostStudy* s, RfError* error )
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
    CostStudy s = { .job = job, .cost = cost, .start = rf_wall_seconds() };
    *cost = ( RfCost ){ .positions = 0 };
    RfResult result = resolve_cost_settings( &s, error );
    if ( result == RF_OK )
        result = make_regions( &s, error );
    if ( result == RF_OK )
        result = run_levels( &s, error );
    if ( s.unit_count > 0 )
        fit_cost_curves( &s );
    for ( int i = 0; i < RF_COST_POSITIONS; ++i )
        rf_destroy_test_region( s.regions + i );
    if ( result == RF_OK && !( cost->plain.relmse > 0.0 && cost->reuse.relmse > 0.0 ) )
        return rf_fail( error, RF_ERROR_SCENE,
                        "the error of the test images cannot be measured: they are black, or have NaN or infinite pixels" );
    return result;
}
