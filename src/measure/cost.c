// The measurement of cost: levels of ever more passes at some positions of the path.
#include "measure/cost.h"

#include "base/system.h"
#include "base/try.h"
#include "measure/image_error.h"
#include "render/estimator.h"
#include "render/groups.h"
#include "render/settings.h"
#include "reuse/tile/tile.h"
#include "scene/leave_out.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

#define COST_ROUNDS 100
#define COST_TASKS ( 2 * RF_COST_POSITIONS ) // of a round: path tracing and reuse by turns, with different seeds

typedef struct CostStudy
{
    const RfCostJob* job;
    RfCost* cost;
    RfRenderSettings settings[2]; // resolved
    RfTrialRuns runs;
    double pixels;            // to trace of each frame of a region
    int threads;              // of the render
    int first_passes, passes; // of the first level and of this one
    double clamp;             // threshold of the first round; 0: none is tried
    int round;
    RfTrial sums[2];                 // of all rounds: each weighs as its passes, since more samples determine the error better
    RfTrial clamped[RF_COST_CLAMPS]; // of reuse, by the clamp of the round
    double start;
} CostStudy;

static double cost_frame_pixels( const RfCostJob* job ) { return (double)job->shot.eyes->width * job->shot.eyes->height; }

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

static void add_trial( CostStudy* s, int curve, int position, const RfTrial* trial )
{
    RfTrialRow* row = ( curve == 0 ? &s->cost->plain : &s->cost->reuse )->rows;
    for ( int passes = s->first_passes; passes < s->passes; passes *= 2 )
        row += 1;
    rf_add_trial( &row->trial, trial );
    row->rounds += 1;
    int first = 0; // of the pieces of this position, the same in all rounds
    for ( int k = 0; k < position; ++k )
        first += s->runs.regions[k].pieces.count;
    rf_add_weighed_trial( s->sums + curve, trial, s->passes, first );
    if ( curve == 1 )
        rf_add_weighed_trial( s->clamped + s->round % RF_COST_CLAMPS, trial, s->passes, first );
}

// What all trials say together. All threads of a render work as fast as those of the trials.
static void fit_cost_curve( CostStudy* s, int curve, RfCostCurve* c )
{
    const RfTrial* sum = s->sums + curve;
    double f1 = rf_trial_f1( sum, 1.0 );
    c->error = rf_trial_error( sum );
    c->relmse = rf_trial_relmse( sum, 1.0 );
    c->f1_squared = f1 * f1;
    c->sample_seconds = rf_trial_sample_seconds( sum ) / s->threads;
    c->finish_seconds = sum->finish_pixels > 0.0
                            ? fmax( sum->finish_seconds, 0.0 ) / sum->finish_pixels * cost_frame_pixels( s->job ) / s->threads
                            : 0.0;
    for ( c->count = 0; c->count < RF_COST_LEVELS && c->rows[c->count].rounds > 0; ++c->count )
    {
        RfTrialRow* row = c->rows + c->count;
        row->group = c->group;
        row->eyes = c->eyes;
        row->tile = c->tile;
        row->spp = s->first_passes << c->count;
        row->samples = cost_frame_pixels( s->job ) * row->spp;
        row->fit.threads = s->threads;
        rf_predict_trial_row( row, cost_frame_pixels( s->job ), 1, 1.0 );
    }
    c->slope = slope_of( c );
}

static void fit_clamps( CostStudy* s )
{
    for ( int i = 0; i < RF_COST_CLAMPS && s->clamped[i].clamp.threshold > 0.0; ++i )
    {
        const RfTrial* sum = s->clamped + i;
        double missing = fmax( sum->clamp.removed, 0.0 ) / sum->clamp.light, bias = sum->clamp.bias / sum->weight;
        s->cost->clamps[i] = ( RfCostClamp ){ .threshold = sum->clamp.threshold / sum->clamp.frames,
                                              .error = rf_trial_clamped_error( sum ),
                                              // were the same share missing everywhere, in three channels, it were least
                                              .bias = fmax( bias, 3.0 * missing * missing ),
                                              .missing = missing };
        s->cost->clamp_count = i + 1;
    }
}

#define LITTLE_LIGHT 0.0005 // of all: a clamp that takes no more is none, and its error differs by chance

static bool takes_light( const RfCostClamp* clamp ) { return clamp->missing > LITTLE_LIGHT; }

const RfCostClamp* rf_best_clamp( const RfCost* cost, double spp, double* relmse )
{
    const RfCostClamp* best = NULL;
    for ( int i = 0; i < cost->clamp_count; ++i )
    {
        double error = cost->clamps[i].error.value / spp + cost->clamps[i].bias;
        if ( !takes_light( cost->clamps + i ) || ( best != NULL && !isless( error, *relmse ) ) )
            continue;
        best = cost->clamps + i;
        *relmse = error;
    }
    return best;
}

// At least two.
RfCostPrediction rf_predict_samples( const RfCostJob* job, const RfCostCurve* curve, double wanted, int per_sweep )
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
    p.frame_seconds = cost_frame_pixels( job ) * plan.spp * curve->sample_seconds + curve->finish_seconds;
    p.seconds = samples * cost_frame_pixels( job ) * curve->sample_seconds + job->shot.frame_count * curve->finish_seconds;
    return p;
}

RfCostPrediction rf_predict_cost( const RfCostJob* job, const RfCostCurve* curve, double relmse, int per_sweep )
{
    return rf_predict_samples( job, curve, ceil( curve->relmse / relmse ), per_sweep );
}

RfCostPrediction rf_predict_flicker_cost( const RfCostJob* job, const RfCostCurve* curve, double flicker, int per_sweep )
{
    return rf_predict_samples( job, curve, ceil( curve->f1_squared / ( flicker * flicker ) ), per_sweep );
}

RfCostPrediction rf_predict_clamped_cost( const RfCostJob* job, const RfCost* cost, double relmse, int per_sweep,
                                          const RfCostClamp** clamp )
{
    double least = cost->reuse.relmse / relmse;
    *clamp = NULL;
    for ( int i = 0; i < cost->clamp_count; ++i )
    {
        const RfCostClamp* c = cost->clamps + i;
        double wanted = c->error.value / ( relmse - c->bias );
        if ( !takes_light( c ) || !isless( c->bias, relmse ) || !isless( wanted, least ) )
            continue;
        least = wanted;
        *clamp = c;
    }
    RfCostPrediction p = rf_predict_samples( job, &cost->reuse, ceil( least ), per_sweep );
    if ( p.spp > 0 && p.spp == rf_predict_cost( job, &cost->reuse, relmse, per_sweep ).spp ) // whole groups need as many
        *clamp = NULL;
    return p;
}

// As many trials at a time as have room for their films and records, with a thread each.
static void share_threads( CostStudy* s )
{
    RfRenderSettings settings = s->settings[1];
    RfMemoryFit fit;
    settings.threads = 1;
    int longest = rf_longest_shot( s->job->shot.eyes, s->job->shot.eye_count );
    int eyes = 2 * settings.group + 1 < longest ? 2 * settings.group + 1 : longest;
    s->threads = s->settings[1].threads;
    s->runs.workers = s->threads < COST_TASKS ? s->threads : COST_TASKS;
    RfShot group = { s->job->shot.tracer, s->job->shot.eyes, eyes, NULL, eyes };
    if ( rf_fit_memory( &group, &settings, &fit, NULL ) == RF_OK )
        s->runs.workers = rf_trial_workers( settings.memory, &fit, s->runs.workers );
    for ( int k = 0; k < 2; ++k )
    {
        s->settings[k].threads = 1;
        s->settings[k].memory /= (size_t)s->runs.workers;
    }
}

// Settings of both curves, how many trials run at a time, and the threads and memory of each.
static RfResult resolve_cost_settings( CostStudy* s, RfError* error )
{
    const RfCostJob* job = s->job;
    RfRenderSettings asked = rf_trial_settings( job->settings );
    asked.aovs &= ~RF_PASS_AOVS;
    asked.light_groups = NULL;
    RfRenderSettings *plain = s->settings, *reuse = s->settings + 1;
    RF_TRY( rf_resolve_settings( &job->shot, &asked, reuse, error ) );
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

// Thresholds that are tried by turns, times the one that was found: it is best for one error, and others ask for others.
static const double s_clamp_steps[RF_COST_CLAMPS] = { 1.0, 4.0, 0.25, 16.0 };

#define WANTED_LEVELS 3   // sample counts that the budget is planned for
#define FEW_PIXELS 4000.0 // traced of a frame: four pieces and what is around them
#define MIN_PIXELS 1000.0 // one piece
#define PROBE_PIXELS 1000.0
#define SLACK 0.9 // of the time left: trials end at different times

static RfResult make_regions( CostStudy* s, RfError* error )
{
    const RfShot* shot = &s->job->shot;
    RfTestSite sites[RF_COST_POSITIONS];
    int count = s->cost->positions;
    for ( int i = 0; i < count; ++i )
        sites[i] = ( RfTestSite ){ shot->frames[(int)( ( i + 0.5 ) / count * shot->frame_count )], 2 * s->settings[1].group + 1,
                                   s->pixels };
    s->runs.first = 1;
    s->runs.pilot = s->settings[1];
    return rf_make_trial_regions( &s->runs, sites, count, error );
}

static bool no_more( void* user, const RfProgress* progress )
{
    (void)user, (void)progress;
    return false;
}

// The threshold that --clamp auto takes for the relMSE wanted: a render that ends when it has begun. Without one, none is tried.
static void find_clamp( CostStudy* s )
{
    const RfTestRegion* region = s->runs.regions;
    RfRenderSettings settings = rf_trial_settings( s->job->settings );
    RfRenderStats stats = { .clamp = 0.0 };
    settings.group = s->settings[1].group;
    settings.clamp = RF_CLAMP_AUTO;
    settings.spp = s->first_passes; // the pilot is for the error
    settings.noise = s->job->relmse;
    settings.aovs = 0;
    settings.light_groups = NULL;
    settings.queue = 0;
    int frame = region->frames / 2;
    RfShot shot = { s->job->shot.tracer, region->eyes, region->frames, &frame, 1 };
    // what is removed without caustics is no part of the picture asked for: picture and removed would not be the exact one
    bool whole = !rf_is_left_out( rf_tracer_scene( s->job->shot.tracer ), RF_EFFECT_CAUSTICS );
    if ( s->job->relmse > 0.0 && settings.weights == RF_WEIGHTS_EXACT && settings.estimator->clamps && whole )
        rf_render( &shot, &settings, &( RfRenderCallbacks ){ .progress = no_more }, &stats, NULL );
    s->clamp = isgreater( stats.clamp, 0.0 ) && stats.clamp <= RF_MAX_CLAMP ? stats.clamp : 0.0;
    s->settings[1].clamp = s->clamp;
}

// So many pixels that the budget allows WANTED_LEVELS rounds, each taking twice as long as the one before. Where these are few,
// fewer rounds, then fewer positions. The pilot pictures of a piece tell how fast this machine is.
static RfResult choose_pixels( CostStudy* s, RfError* error )
{
    double start = rf_wall_seconds(), samples = 0.0, frames = 0.0;
    s->pixels = PROBE_PIXELS;
    RfResult result = make_regions( s, error );
    for ( int i = 0; i < s->runs.region_count; ++i )
    {
        samples += s->runs.regions[i].samples;
        frames += s->runs.regions[i].frames;
    }
    double sample_seconds = ( rf_wall_seconds() - start ) / samples;
    if ( result != RF_OK )
        return result;
    find_clamp( s );
    double now = rf_wall_seconds(), left = SLACK * ( s->job->budget - ( now - s->start ) );
    // both renders of a trial by both curves, and as much again for the pilot pictures of all rounds
    double first = 4.0 * s->first_passes * frames * sample_seconds, pilots = s->first_passes * frames * sample_seconds;
    double all = cost_frame_pixels( s->job ), few = fmin( FEW_PIXELS, all );
    int levels = WANTED_LEVELS;
    while ( levels > 1 && left < few * ( pilots + first * ( ( 1 << levels ) - 1 ) ) )
        levels -= 1;
    for ( ; s->cost->positions > 1 && left < few * ( pilots + first ); --s->cost->positions )
    {
        pilots *= 1.0 - 1.0 / s->cost->positions;
        first *= 1.0 - 1.0 / s->cost->positions;
    }
    s->pixels = fmax( left / ( pilots + first * ( ( 1 << levels ) - 1 ) ), MIN_PIXELS );
    s->pixels = fmin( s->pixels, all );
    s->cost->needed = now - s->start + s->pixels * ( pilots + first );
    return RF_OK;
}

static RfResult begin( CostStudy* s, RfError* error )
{
    s->cost->positions = s->job->shot.frame_count < RF_COST_POSITIONS ? s->job->shot.frame_count : RF_COST_POSITIONS;
    RfResult result = choose_pixels( s, error );
    if ( result == RF_OK )
        result = make_regions( s, error );
    for ( int i = 0; i < s->cost->positions && result == RF_OK; ++i )
        s->cost->pixels += rf_region_pixels( s->runs.regions + i ) / s->cost->positions;
    return result;
}

// Renders all frames of each region one by one, and as one group with reuse.
static RfResult run_round( CostStudy* s, RfError* error )
{
    RfTrialTask tasks[2];
    for ( int k = 0; k < 2; ++k )
        tasks[k] = ( RfTrialTask ){ s->settings[k], s->settings[k].group == 0 ? INT_MAX : 1, s->passes };
    if ( s->job->report != NULL )
        s->job->report( s->job->user, s->cost, s->passes );
    s->runs.first = s->round * RF_COST_POSITIONS + 1;
    RF_TRY( rf_run_trials( &s->runs, tasks, 2, error ) );
    for ( int i = 0; i < 2 * s->cost->positions; ++i )
        add_trial( s, i % 2, i / 2, s->runs.trials + i );
    s->round += 1;
    s->settings[1].clamp = s->clamp * s_clamp_steps[s->round % RF_COST_CLAMPS];
    return RF_OK;
}

// Runs rounds with twice the passes each as long as there is time, and then as many passes as the rest of it allows.
static RfResult run_rounds( CostStudy* s, RfError* error )
{
    int most = s->first_passes << ( RF_COST_LEVELS - 1 );
    double each = 0.0; // seconds per pass
    for ( s->passes = s->first_passes; s->round < COST_ROUNDS; )
    {
        double begin = rf_wall_seconds(), left = SLACK * ( s->job->budget - ( begin - s->start ) );
        while ( s->round > 0 && s->passes > s->first_passes && left < each * s->passes )
            s->passes /= 2;
        if ( s->round > 0 && left < each * s->passes )
            break;
        RfResult result = run_round( s, error );
        if ( rf_is_late( &s->runs, result ) && s->round > 0 )
            break;
        if ( result != RF_OK )
            return result;
        each = ( rf_wall_seconds() - begin ) / s->passes;
        s->passes = s->passes < most ? 2 * s->passes : most;
    }
    return RF_OK;
}

static RfResult fail_late( const CostStudy* s, RfError* error )
{
    // where not even the speed of the machine is known, a guess
    double needed = s->cost->needed > 0.0 ? s->cost->needed : 4.0 * s->job->budget;
    return rf_fail( error, RF_ERROR_SCENE, "nothing is known within the budget of %.0f s: the first round needs about %.0f s",
                    s->job->budget, fmax( needed, 1.5 * s->job->budget ) );
}

RfResult rf_measure_cost( const RfCostJob* job, RfCost* cost, RfError* error )
{
    CostStudy* s = calloc( 1, sizeof *s );
    *cost = ( RfCost ){ .positions = 0 };
    if ( s == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory trying settings" );
    *s = ( CostStudy ){ .job = job,
                        .cost = cost,
                        .runs = { .shot = job->shot, .watch = job->watch, .deadline = job->deadline },
                        .start = rf_wall_seconds() };
    RfResult result = resolve_cost_settings( s, error );
    if ( result == RF_OK )
        result = begin( s, error );
    if ( result == RF_OK )
        result = run_rounds( s, error );
    if ( rf_is_late( &s->runs, result ) )
        result = fail_late( s, error );
    for ( int k = 0; k < 2 && s->round > 0; ++k )
        fit_cost_curve( s, k, k == 0 ? &cost->plain : &cost->reuse );
    fit_clamps( s );
    cost->speedup = rf_trial_gain( s->sums, s->sums + 1 );
    cost->seconds = rf_wall_seconds() - s->start;
    rf_end_trial_runs( &s->runs );
    free( s );
    if ( result == RF_OK && !( cost->plain.relmse > 0.0 && cost->reuse.relmse > 0.0 ) )
        return rf_fail( error, RF_ERROR_SCENE,
                        "the error of the test images cannot be measured: they are black, or have NaN or infinite pixels" );
    return result;
}
