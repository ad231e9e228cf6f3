// The measurement of cost: levels of ever more passes at some positions of the path.
#include "measure/cost.h"

#include "base/system.h"
#include "base/try.h"
#include "measure/image_error.h"
#include "reframe/plan.h"
#include "render/estimator.h"
#include "render/groups.h"
#include "render/settings.h"
#include "reuse/tile/tile.h"
#include "scene/leave_out.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

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
    RfTrial sums[2];                 // of all rounds, as weight_of says
    RfTrial clamped[RF_COST_CLAMPS]; // of reuse, by the clamp of the round
    double start;
} CostStudy;

static double cost_frame_pixels( const RfCostJob* job ) { return (double)job->shot.eyes->width * job->shot.eyes->height; }

// The row of so many samples, powers of two times first_passes up to most_passes, which are listed in rising order.
static RfTrialRow* row_of( RfCostCurve* c, int spp )
{
    int at = 0;
    while ( at < c->count && c->rows[at].spp < spp )
        at += 1;
    if ( at < c->count && c->rows[at].spp == spp )
        return c->rows + at;
    memmove( c->rows + at + 1, c->rows + at, (size_t)( c->count++ - at ) * sizeof *c->rows );
    c->rows[at] = ( RfTrialRow ){ .group = c->group, .eyes = c->eyes, .tile = c->tile, .spp = spp };
    return c->rows + at;
}

// What a trial counts in the fit: of what is rare more samples say more.
static double weight_of( const CostStudy* s, int passes ) { return sqrt( (double)passes / s->first_passes ); }

static void add_trial( CostStudy* s, int curve, int position, int passes, const RfTrial* trial )
{
    RfTrialRow* row = row_of( curve == 0 ? &s->cost->plain : &s->cost->reuse, passes );
    double weight = weight_of( s, passes );
    rf_add_trial( &row->trial, trial );
    row->rounds += 1;
    int first = 0; // of the pieces of this position, the same in all rounds
    for ( int k = 0; k < position; ++k )
        first += s->runs.regions[k].pieces.count;
    rf_add_weighed_trial( s->sums + curve, trial, weight, first );
    if ( curve == 1 )
        rf_add_weighed_trial( s->clamped + s->round % RF_COST_CLAMPS, trial, weight, first );
}

// The margin of the logarithm of an error.
static double margin_of( RfInterval error ) { return log( error.high / error.value ); }

// CPU seconds of a sample by all rows, without what a trial takes to begin: the slope of a line through their seconds, whose relative
// errors are alike.
static double sample_seconds_of( const CostStudy* s, const RfCostCurve* c, const RfTrial* sum )
{
    double weight = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for ( const RfTrialRow* row = c->rows; row < c->rows + c->count; ++row )
    {
        double w = row->rounds * weight_of( s, row->spp ) / ( (double)row->spp * row->spp );
        double seconds = row->spp * rf_trial_sample_seconds( &row->trial );
        weight += w;
        x += w * row->spp;
        y += w * seconds;
        xx += w * row->spp * row->spp;
        xy += w * row->spp * seconds;
    }
    if ( c->count < 2 )
        return rf_trial_sample_seconds( sum );
    double last = rf_trial_sample_seconds( &c->rows[c->count - 1].trial ),
           slope = ( weight * xy - x * y ) / ( weight * xx - x * x );
    return fmin( fmax( slope, 0.5 * last ), last ); // times of a busy machine may differ
}

// What all trials say together. All threads of a render work as fast as those of the trials.
static void fit_cost_curve( CostStudy* s, int curve, RfCostCurve* c )
{
    const RfTrial* sum = s->sums + curve;
    RfErrorPoint points[RF_COST_LEVELS];
    double f1 = rf_trial_f1( sum, 1.0 );
    c->sample_seconds = sample_seconds_of( s, c, sum ) / s->threads;
    c->finish_seconds = sum->finish_pixels > 0.0
                            ? fmax( sum->finish_seconds, 0.0 ) / sum->finish_pixels * cost_frame_pixels( s->job ) / s->threads
                            : 0.0;
    for ( int i = 0; i < c->count; ++i )
    {
        RfTrialRow* row = c->rows + i;
        row->samples = cost_frame_pixels( s->job ) * row->spp;
        row->fit.threads = s->threads;
        rf_predict_trial_row( row, cost_frame_pixels( s->job ), 1, 1.0 );
        points[i] = ( RfErrorPoint ){ row->spp, row->relmse, weight_of( s, row->spp ) * row->rounds / s->cost->positions };
    }
    c->line = rf_fit_error_line( points, c->count, margin_of( rf_trial_error( sum ) ) );
    // every group of a render takes some of what a trial takes to begin
    double most = rf_trial_sample_seconds( &c->rows[c->count - 1].trial ) / s->threads;
    c->time_margin = hypot( rf_trial_time_margin( sum ), log( most / c->sample_seconds ) );
    c->f1_squared = f1 * f1 / c->line.samples;
}

static void fit_clamps( CostStudy* s )
{
    for ( int i = 0; i < RF_COST_CLAMPS && s->clamped[i].clamp.threshold > 0.0; ++i )
    {
        const RfTrial* sum = s->clamped + i;
        double missing = fmax( sum->clamp.removed, 0.0 ) / sum->clamp.light, bias = sum->clamp.bias / sum->weight;
        double samples = rf_trial_passes( sum );
        RfInterval error = rf_trial_clamped_error( sum );
        error = rf_log_interval( error.value / samples, margin_of( error ) );
        s->cost->clamps[i] = ( RfCostClamp ){ .threshold = sum->clamp.threshold / sum->clamp.frames,
                                              .line = { samples, error, s->cost->reuse.line.exponent },
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
        double error = rf_line_error( &cost->clamps[i].line, spp ).value + cost->clamps[i].bias;
        if ( !takes_light( cost->clamps + i ) || ( best != NULL && !isless( error, *relmse ) ) )
            continue;
        best = cost->clamps + i;
        *relmse = error;
    }
    return best;
}

#define FAR 4.0 // times the samples that were tried: said to be beyond them

// At least two.
RfCostPrediction rf_predict_samples( const RfCostJob* job, const RfCostCurve* curve, double wanted, int per_sweep )
{
    RfCostPrediction p = { 0, (double)NAN, (double)NAN, (double)NAN, (double)NAN, 0 };
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
    p.seconds = samples * cost_frame_pixels( job ) * curve->sample_seconds * ( curve->alone > 0.0 ? curve->alone : 1.0 ) +
                job->shot.frame_count * curve->finish_seconds;
    int most = curve->count > 0 ? curve->rows[curve->count - 1].spp : p.spp;
    p.tried = p.spp > FAR * most ? most : 0;
    return p;
}

// The same with the interval of the samples, and of the seconds that they take.
static RfCostPrediction predict_interval( const RfCostJob* job, const RfCostCurve* curve, RfInterval samples, int per_sweep )
{
    RfCostPrediction p = rf_predict_samples( job, curve, ceil( samples.value ), per_sweep );
    double less = log( p.frame_seconds / rf_predict_samples( job, curve, ceil( samples.low ), per_sweep ).frame_seconds );
    double more = log( rf_predict_samples( job, curve, ceil( samples.high ), per_sweep ).frame_seconds / p.frame_seconds );
    p.low = p.frame_seconds * exp( -hypot( less, curve->time_margin ) );
    p.high = p.frame_seconds * exp( hypot( more, curve->time_margin ) );
    return p;
}

RfCostPrediction rf_predict_cost( const RfCostJob* job, const RfCostCurve* curve, double relmse, int per_sweep )
{
    return predict_interval( job, curve, rf_line_samples( &curve->line, relmse ), per_sweep );
}

RfCostPrediction rf_predict_flicker_cost( const RfCostJob* job, const RfCostCurve* curve, double flicker, int per_sweep )
{
    RfErrorLine line = curve->line;
    line.error = rf_log_interval( curve->f1_squared, margin_of( line.error ) );
    return predict_interval( job, curve, rf_line_samples( &line, flicker * flicker ), per_sweep );
}

// Seconds of the frames asked for with so many samples, whole passes or not.
static double equal_seconds( const RfCostJob* job, const RfCostCurve* c, double samples, int per_sweep )
{
    double finish = job->shot.frame_count * c->finish_seconds, whole = 2.0 * c->eyes;
    return finish + ( rf_predict_samples( job, c, whole, per_sweep ).seconds - finish ) * samples / whole;
}

RfInterval rf_cost_speedup( const RfCostJob* job, const RfCost* cost, double relmse, const int per_sweep[2] )
{
    const RfCostCurve* curves[2] = { &cost->plain, &cost->reuse };
    double seconds[2], square = margin_of( cost->gain ) * margin_of( cost->gain );
    for ( int k = 0; k < 2; ++k )
    {
        const RfErrorLine* line = &curves[k]->line;
        double samples = rf_line_samples( line, relmse ).value;
        double slack = ( line->exponent.high / line->exponent.value - 1.0 ) * log( samples / line->samples );
        seconds[k] = equal_seconds( job, curves[k], samples, per_sweep[k] );
        square += slack * slack;
    }
    return rf_log_interval( seconds[0] / seconds[1], sqrt( square ) );
}

RfCostPrediction rf_predict_clamped_cost( const RfCostJob* job, const RfCost* cost, double relmse, int per_sweep,
                                          const RfCostClamp** clamp )
{
    RfInterval least = rf_line_samples( &cost->reuse.line, relmse );
    *clamp = NULL;
    for ( int i = 0; i < cost->clamp_count; ++i )
    {
        const RfCostClamp* c = cost->clamps + i;
        RfInterval wanted = rf_line_samples( &c->line, relmse - c->bias );
        if ( !takes_light( c ) || !isless( c->bias, relmse ) || !isless( wanted.value, least.value ) )
            continue;
        least = wanted;
        *clamp = c;
    }
    RfCostPrediction p = predict_interval( job, &cost->reuse, least, per_sweep );
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
    bool plainly = reuse->group == 0 && reuse->tile.kind == RF_TILE_NONE && reuse->estimator == plain->estimator;
    if ( plainly && asked.tile.kind == RF_TILE_AUTO ) // path tracing is best here: by how much?
        reuse->tile = ( RfTile ){ RF_TILE_BLOCK, 3, 3 };
    else if ( plainly )
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

#define ALL_FRAMES 1      // rounds in which path tracing has the frames of reuse
#define WANTED_LEVELS 3   // sample counts that the budget is planned for
#define FEW_PIXELS 4000.0 // traced of a frame: four pieces and what is around them
#define MIN_PIXELS 1000.0 // one piece
#define PROBE_PIXELS 1000.0
#define SLACK 0.9 // of the time left: trials end at different times

static int most_passes( const CostStudy* s ) { return s->first_passes << ( RF_COST_LEVELS - 1 ); }

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

// How many times the passes of the round path tracing gets, on as many times fewer frames, towards those that the least error takes:
// a power of two.
static int plain_times( CostStudy* s )
{
    int times = 1, frames = s->runs.regions->frames;
    if ( s->round < ALL_FRAMES || !( s->job->least > 0.0 ) )
        return 1;
    fit_cost_curve( s, 0, &s->cost->plain );
    double wanted = rf_line_samples( &s->cost->plain.line, s->job->least ).value;
    while ( 2 * times <= frames && 2.0 * times * s->passes <= sqrt( 2.0 ) * wanted && times * s->passes < most_passes( s ) )
        times *= 2;
    return times;
}

// Renders all frames of each region one by one, or few of them with more passes, and all as one group with reuse.
static RfResult run_round( CostStudy* s, RfError* error )
{
    RfTrialTask tasks[2];
    int times = plain_times( s ), frames = s->runs.regions->frames;
    tasks[0] = ( RfTrialTask ){ s->settings[0], frames / times, times * s->passes };
    tasks[1] = ( RfTrialTask ){ s->settings[1], s->settings[1].group == 0 ? INT_MAX : 1, s->passes };
    if ( s->job->report != NULL )
        s->job->report( s->job->user, s->cost, s->passes );
    s->runs.first = s->round * RF_COST_POSITIONS + 1;
    RF_TRY( rf_run_trials( &s->runs, tasks, 2, error ) );
    for ( int i = 0; i < 2 * s->cost->positions; ++i )
        add_trial( s, i % 2, i / 2, tasks[i % 2].passes, s->runs.trials + i );
    s->round += 1;
    s->settings[1].clamp = s->clamp * s_clamp_steps[s->round % RF_COST_CLAMPS];
    return RF_OK;
}

// Runs rounds with twice the passes each as long as there is time, and then as many passes as the rest of it allows.
static RfResult run_rounds( CostStudy* s, RfError* error )
{
    int most = most_passes( s );
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

// RfCostCurve.alone, by the fixed costs of rays.
static double cost_alone( const RfCostJob* job, RfRenderSettings settings )
{
    const RfShot* shot = &job->shot;
    RfHalo halo;
    settings.spp = 2 * ( 2 * settings.group + 1 );
    if ( shot->frame_count == shot->eye_count || settings.group == 0 ||
         rf_plan_halo( shot, &settings, 0.0, &halo, NULL ) != RF_OK )
        return 1.0;
    RfGroupPlan plan = rf_plan_shots( shot->eyes, shot->eye_count, settings.group, settings.spp );
    double whole = 0.0, samples = 0.0, others = 0.0;
    for ( int i = 0; i < shot->eye_count; ++i )
        whole += rf_frame_passes( &plan, i );
    rf_add_group_samples( &plan, shot->frames, 0, shot->frame_count, &samples, &others );
    return whole * shot->frame_count / shot->eye_count / ( 1.0 - halo.share ) / samples;
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
    cost->reuse.alone = cost_alone( job, s->settings[1] );
    cost->gain = rf_trial_gain( s->sums, s->sums + 1 );
    cost->seconds = rf_wall_seconds() - s->start;
    rf_end_trial_runs( &s->runs );
    free( s );
    if ( result == RF_OK && !( cost->plain.line.error.value > 0.0 && cost->reuse.line.error.value > 0.0 ) )
        return rf_fail( error, RF_ERROR_SCENE,
                        "the error of the test images cannot be measured: they are black, or have NaN or infinite pixels" );
    return result;
}
