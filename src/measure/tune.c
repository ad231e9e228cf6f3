// Successive halving over trials: rounds, candidates, workers and the time budget of `tune`.
#include "measure/tune.h"

#include "base/system.h"
#include "measure/trial_runs.h"
#include "measure/tune_rows.h"
#include "render/settings.h"

#include <math.h>
#include <stdlib.h>

// Plans the rounds. Decisions depend on the arguments only, not on a clock.

#define REGION_FRAMES 7   // of a test region, at least
#define MIN_PIXELS 2500.0 // four pieces, and what is traced around them
#define MAX_REGIONS 24

// Fraction of the remaining time for each round.
static const double s_shares[RF_TUNE_ROUNDS] = { 0.3, 0.33, 0.5, 1.0 };
static const int s_regions[RF_TUNE_ROUNDS] = { 2, 2, 3, 4 };
static const int s_passes[RF_TUNE_ROUNDS] = { 2, 4, 4, 4 };

#define FEW 4    // with this many settings left, a round may use all the remaining time
#define HOPE 0.5 // fraction of the best efficiency below which a row is dropped

int rf_tune_passes( int eyes, int passes )
{
    return eyes < REGION_FRAMES ? passes * ( ( REGION_FRAMES + eyes / 2 ) / eyes ) : passes;
}

int rf_tune_region_frames( const RfTune* tune, const bool* candidate )
{
    int frames = REGION_FRAMES;
    for ( int i = 0; i < tune->count; ++i )
        frames = candidate[i] && tune->rows[i].eyes > frames ? tune->rows[i].eyes : frames;
    return frames;
}

double rf_tune_row_samples( const RfTrialRow* row, int passes ) { return 2.0 * row->eyes * rf_tune_passes( row->eyes, passes ); }

double rf_tune_round_cost( const RfTune* tune, const bool* candidate, const RfTuneRound* round, double cost_second )
{
    double cost = 0.0;
    for ( int i = 0; i < tune->count; ++i )
    {
        const RfTrialRow* row = tune->rows + i;
        double sample = row->rounds > 0 ? rf_trial_sample_seconds( &row->trial ) : row->cost * cost_second;
        cost += candidate[i] ? round->regions * round->pixels * rf_tune_row_samples( row, round->passes ) * sample : 0.0;
    }
    return cost;
}

// Pixels per frame such that what is kept of the test regions and the parallel trials fits in half the memory;
// the other half is for the renders.
static double pixels_that_fit( const RfTune* tune, const bool* candidate, const RfTuneOutlook* o, int regions )
{
    int eyes = rf_tune_region_frames( tune, candidate );
    double bytes = (double)rf_test_region_bytes( eyes, RF_CELL_PIXELS ) * regions +
                   (double)o->workers * (double)rf_trial_bytes( eyes, RF_CELL_PIXELS );
    return 0.5 * (double)o->memory / bytes * RF_CELL_PIXELS;
}

static int count_candidates( const RfTune* tune, const bool* candidate )
{
    int count = 0;
    for ( int i = 0; i < tune->count; ++i )
        count += candidate[i];
    return count;
}

bool rf_plan_tune_round( const RfTune* tune, const bool* candidate, const RfTuneOutlook* o, RfTuneRound* round )
{
    double all = (double)o->width * o->height,
           seconds = ( count_candidates( tune, candidate ) > FEW ? s_shares[o->number] : 1.0 ) * o->left;
    int passes = s_passes[o->number] > o->passes ? s_passes[o->number] : o->passes;
    *round = ( RfTuneRound ){ .regions = s_regions[o->number], .passes = passes, .pixels = 1.0 };
    double each = rf_tune_round_cost( tune, candidate, round, o->cost_second ); // per pixel
    double pixels = seconds * o->rate / each, most = pixels_that_fit( tune, candidate, o, round->regions );
    most = most < all ? most : all;
    double least = MIN_PIXELS < most ? MIN_PIXELS : most;
    for ( ; pixels < least && round->regions > 1; --round->regions ) // fewer positions rather than too small pieces
        pixels *= round->regions / ( round->regions - 1.0 );
    if ( pixels > most ) // more positions from the time left
        round->regions = (int)fmin( MAX_REGIONS, floor( round->regions * pixels / most ) );
    round->pixels = fmax( fmin( pixels, most ), least );
    if ( !o->must && pixels < least )
        return false;
    round->seconds = rf_tune_round_cost( tune, candidate, round, o->cost_second ) / o->rate;
    return true;
}

// Orders efficiencies, largest first.
static int descending( const void* a, const void* b )
{
    double x = *(const double*)a, y = *(const double*)b;
    return ( x < y ) - ( x > y );
}

void rf_cut_tune_candidates( const RfTune* tune, int kept, bool* candidate )
{
    double sorted[RF_TUNE_ROWS];
    int count = 0;
    for ( int i = 0; i < tune->count; ++i )
    {
        candidate[i] = candidate[i] && isfinite( tune->rows[i].efficiency );
        if ( candidate[i] )
            sorted[count++] = tune->rows[i].efficiency;
    }
    if ( count == 0 )
        return;
    qsort( sorted, (size_t)count, sizeof *sorted, descending );
    double hope = tune->round_count > 0 ? HOPE : 0.0; // before, efficiencies are guesses
    double last = kept > 0 ? sorted[kept < count ? kept - 1 : count - 1] : (double)INFINITY;
    double bar = fmax( hope * sorted[0], last );
    for ( int i = 0; i < tune->count; ++i )
        candidate[i] =
            candidate[i] && ( tune->rows[i].efficiency >= bar || tune->rows[i].usual || rf_is_plain_row( tune->rows + i ) );
}

double rf_tune_position( int index )
{
    double position = 0.0, part = 0.5;
    for ( int i = index + 1; i > 0; i /= 2, part /= 2.0 )
        position += i % 2 * part;
    return position;
}

// Is a row tried sooner than another? A deadline may leave out the last ones.
static bool goes_before( const RfTrialRow* a, const RfTrialRow* b )
{
    int rank[2] = { rf_is_plain_row( a ) ? 2 : a->usual, rf_is_plain_row( b ) ? 2 : b->usual };
    return rank[0] != rank[1] ? rank[0] > rank[1] : a->efficiency > b->efficiency;
}

#define SLACK 0.9           // of the time left for a round without a later one: trials end at different times
#define LEAST_ROWS 3        // path tracing, what is usual and another one
#define FIRST_PIXELS 2500.0 // traced of a frame, to measure the speed

static const int s_kept[RF_TUNE_ROUNDS] = { 16, 8, 4, 1 }; // candidates kept after each round

typedef struct Tuner
{
    const RfTuneJob* job;
    RfTune* tune;
    RfTrialRuns runs;
    RfRenderSettings common; // resolved
    bool candidate[RF_TUNE_ROWS];
    double start;
    int positions;    // positions used for test regions so far
    double cpu, wall; // seconds spent by the rounds so far
    double cost_second;
} Tuner;

// Places the regions of a round, at further positions of the path.
static RfResult make_regions( Tuner* t, const RfTuneRound* round, int first, RfError* error )
{
    const RfShot* shot = &t->job->shot;
    RfTestSite* sites = calloc( (size_t)round->regions, sizeof *sites );
    if ( sites == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "the system has no memory left to try settings" );
    int frames = rf_tune_region_frames( t->tune, t->candidate );
    for ( int i = 0; i < round->regions; ++i )
        sites[i] =
            ( RfTestSite ){ shot->frames[(int)( rf_tune_position( first + i ) * shot->frame_count )], frames, round->pixels };
    t->runs.first = first;
    RfResult result = rf_make_trial_regions( &t->runs, sites, round->regions, error );
    free( sites );
    return result;
}

// The candidates, those first that are to be tried first.
static int order_candidates( const Tuner* t, int order[RF_TUNE_ROWS] )
{
    const RfTrialRow* rows = t->tune->rows;
    int count = 0;
    for ( int i = 0; i < t->tune->count; ++i )
    {
        int k = t->candidate[i] ? count++ : -1;
        for ( ; k > 0 && goes_before( rows + i, rows + order[k - 1] ); --k )
            order[k] = order[k - 1];
        if ( k >= 0 )
            order[k] = i;
    }
    return count;
}

// Adds the trials of the regions at which all rows were tried, in the first round at least those of the first region; returns
// the number of these regions.
static int take_trials( const RfTrialRuns* runs, const int* order, RfTune* tune )
{
    int complete = 0;
    for ( int s = 0; s < runs->region_count; ++s )
    {
        const bool* here = runs->done + s * runs->task_count;
        int done = 0;
        for ( int k = 0; k < runs->task_count; ++k )
            done += here[k];
        if ( done < runs->task_count && ( done == 0 || tune->round_count > 0 || s > 0 ) )
            continue;
        for ( int k = 0; k < runs->task_count; ++k )
        {
            if ( !here[k] )
                continue;
            rf_add_trial( &tune->rows[order[k]].trial, runs->trials + s * runs->task_count + k );
            tune->rows[order[k]].rounds += complete == 0;
        }
        complete += 1;
    }
    return complete;
}

static RfResult run_round( Tuner* t, const RfTuneRound* round, int* complete, RfError* error )
{
    RfTrialTask tasks[RF_TUNE_ROWS];
    int order[RF_TUNE_ROWS], count = order_candidates( t, order );
    for ( int k = 0; k < count; ++k )
    {
        const RfTrialRow* row = t->tune->rows + order[k];
        tasks[k] = ( RfTrialTask ){ rf_tune_settings( row, &t->runs.pilot ), 1, rf_tune_passes( row->eyes, round->passes ) };
    }
    *complete = 0;
    double start = rf_wall_seconds();
    RfResult result = make_regions( t, round, t->positions, error );
    if ( result == RF_OK )
        result = rf_run_trials( &t->runs, tasks, count, error );
    if ( t->runs.done != NULL && ( result == RF_OK || result == RF_ERROR_INTERRUPTED ) )
        *complete = take_trials( &t->runs, order, t->tune );
    t->cpu += rf_trial_runs_seconds( &t->runs );
    t->wall += rf_wall_seconds() - start;
    t->positions += round->regions;
    return result;
}

// Renders a few pieces to measure the speed of this machine in this scene.
static RfResult calibrate( Tuner* t, RfError* error )
{
    const RfShot* shot = &t->job->shot;
    RfTuneRound round = { .pixels = fmin( FIRST_PIXELS, (double)shot->eyes->width * shot->eyes->height ),
                          .regions = t->common.threads };
    double start = rf_wall_seconds(), cost = 0.0;
    RfResult result = make_regions( t, &round, 0, error );
    double samples = result == RF_OK ? t->runs.regions->samples * round.regions : 1.0;
    t->cpu = rf_trial_runs_seconds( &t->runs );
    t->wall = rf_wall_seconds() - start;
    for ( int i = 0; i < t->tune->count; ++i ) // the most expensive row costs about as much as the pilot image, or more
        cost = t->candidate[i] && t->tune->rows[i].cost > cost ? t->tune->rows[i].cost : cost;
    t->cost_second = 1.5 * t->cpu / ( samples * cost );
    return result;
}

static RfTuneOutlook make_outlook( const Tuner* t, int number )
{
    double left = t->job->budget - ( rf_wall_seconds() - t->start );
    return ( RfTuneOutlook ){
        .number = number,
        .width = t->job->shot.eyes->width,
        .height = t->job->shot.eyes->height,
        .left = left > 0.0 ? SLACK * left : 0.0,
        .rate = t->wall > 0.0 && t->cpu > 0.0 ? t->cpu / t->wall : 1.0,
        .cost_second = t->cost_second,
        .memory = t->common.memory,
        .workers = t->common.threads,
        .passes = rf_usual_passes( &t->common ),
        .must = number == 0 && ( t->job->deadline == 0.0 || count_candidates( t->tune, t->candidate ) < LEAST_ROWS ),
    };
}

static int count_tried( const RfTune* tune )
{
    int count = 0;
    for ( int i = 0; i < tune->count; ++i )
        count += tune->rows[i].rounds > 0;
    return count;
}

// Plans a round for the candidates, or for the better ones if time is too short; false if it is too short even for two that
// are to be compared. The first round is planned in any case.
static bool plan_round( Tuner* t, int number, RfTuneRound* round )
{
    for ( int kept = count_candidates( t->tune, t->candidate ) - 1;; --kept )
    {
        RfTuneOutlook outlook = make_outlook( t, number );
        if ( rf_plan_tune_round( t->tune, t->candidate, &outlook, round ) )
            return true;
        rf_cut_tune_candidates( t->tune, kept, t->candidate ); // path tracing and what is usual stay besides
        if ( number > 0 && ( count_candidates( t->tune, t->candidate ) < LEAST_ROWS || kept <= 0 ) )
            return false;
    }
}

// Runs a round; work left undone at the deadline is ignored.
static RfResult next_round( Tuner* t, int number, bool* last, RfError* error )
{
    const RfTuneJob* job = t->job;
    RfTuneRound* round = t->tune->rounds + number;
    *last = !plan_round( t, number, round );
    if ( *last )
        return RF_OK;
    if ( job->report != NULL )
        job->report( job->user, t->tune, round, count_candidates( t->tune, t->candidate ) );
    int complete;
    RfResult result = run_round( t, round, &complete, error );
    t->tune->round_count += complete > 0;
    round->regions = complete;
    rf_smooth_tune_rows( t->tune );
    rf_predict_tune_rows( t->tune, (double)job->shot.eyes->width * job->shot.eyes->height, job->shot.frame_count );
    if ( rf_is_late( &t->runs, result ) )
    {
        if ( number == 0 && count_tried( t->tune ) < 2 ) // nothing to compare
            t->tune->needed = 2.0 * fmax( job->budget, rf_wall_seconds() - t->start + round->seconds );
        *last = true;
        return RF_OK;
    }
    rf_cut_tune_candidates( t->tune, s_kept[number], t->candidate );
    return result;
}

RfResult rf_tune( const RfTuneJob* job, RfTune* tune, RfError* error )
{
    Tuner t = { .job = job,
                .tune = tune,
                .runs = { .shot = job->shot, .watch = job->watch, .deadline = job->deadline },
                .start = rf_wall_seconds() };
    *tune = ( RfTune ){ .goal = job->goal, .chosen = -1 };
    RfResult result = rf_list_tune_rows( job, tune, &t.common, error );
    for ( int i = 0; i < tune->count; ++i )
        t.candidate[i] = tune->rows[i].excluded == NULL;
    if ( result == RF_OK )
    {
        t.common.threads = t.runs.workers = rf_tune_workers( job, tune, &t.common );
        t.runs.pilot = t.common;
        t.runs.pilot.threads = 1;
        t.runs.pilot.memory /= (size_t)t.common.threads;
        result = calibrate( &t, error );
    }
    bool last = rf_is_late( &t.runs, result );
    if ( last )
    {
        tune->needed = 4.0 * job->budget;
        result = RF_OK;
    }
    for ( int number = 0;
          number < RF_TUNE_ROUNDS && result == RF_OK && !last && count_candidates( tune, t.candidate ) > ( number > 0 );
          ++number )
        result = next_round( &t, number, &last, error );
    rf_predict_tune_rows( tune, (double)job->shot.eyes->width * job->shot.eyes->height, job->shot.frame_count );
    rf_end_trial_runs( &t.runs );
    if ( tune->needed > 0.0 && tune->chosen >= 0 )
    {
        tune->rows[tune->chosen].chosen = false;
        tune->chosen = -1;
    }
    tune->seconds = rf_wall_seconds() - t.start;
    if ( result == RF_OK && tune->chosen < 0 && tune->needed == 0.0 )
        return rf_fail( error, RF_ERROR_SCENE,
                        "no error can be measured: the test images are black, or have NaN or infinite pixels" );
    return result;
}
