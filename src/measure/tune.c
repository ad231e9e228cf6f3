#include "base/system.h"
#include "measure/tune_internal.h"
#include "measure/tune_work.h"
#include "render/settings.h"

#include <math.h>

#define OVERTIME 1.1        // times the budget: when the last round is aborted
#define FIRST_PIXELS 2500.0 // traced of a frame, to measure the speed

static const int s_kept[RF_TUNE_ROUNDS] = { 16, 8, 4, 1 }; // candidates kept after each round

typedef struct Tuner
{
    const RfTuneJob* job;
    RfTune* tune;
    RfRenderSettings common; // resolved
    bool candidate[RF_TUNE_ROWS];
    double start;
    int positions;    // positions used for test regions so far
    double cpu, wall; // seconds spent by the rounds so far
    double cost_second;
} Tuner;

static RfResult run_round( Tuner* t, const RfTuneRound* round, double deadline, int* complete, RfError* error )
{
    RfTuneWork w;
    rf_begin_tune_work( t->job, t->tune, &t->common, t->candidate, round, t->positions, deadline, &w );
    *complete = 0;
    double start = rf_wall_seconds();
    RfResult result = rf_make_tune_regions( &w, error );
    if ( result == RF_OK )
        result = rf_run_tune_trials( &w, error );
    if ( w.done != NULL && ( result == RF_OK || result == RF_ERROR_INTERRUPTED ) )
        *complete = rf_take_tune_trials( &w, t->tune );
    t->cpu += rf_tune_work_seconds( &w );
    t->wall += rf_wall_seconds() - start;
    t->positions += round->regions;
    rf_end_tune_work( &w );
    return result;
}

// Renders a few pieces to measure the speed of this machine in this scene.
static RfResult calibrate( Tuner* t, RfError* error )
{
    const RfTuneJob* job = t->job;
    double all = (double)job->eyes->width * job->eyes->height;
    RfTuneRound round = { .pixels = fmin( FIRST_PIXELS, all ),
                          .regions = t->common.threads,
                          .passes = rf_usual_passes( &t->common ) };
    RfTuneWork w;
    rf_begin_tune_work( job, t->tune, &t->common, t->candidate, &round, 0, (double)INFINITY, &w );
    double start = rf_wall_seconds(), cost = 0.0;
    RfResult result = rf_make_tune_regions( &w, error );
    double samples = result == RF_OK ? w.regions->samples * round.regions : 1.0, cpu = rf_tune_work_seconds( &w );
    t->cpu += cpu;
    t->wall += rf_wall_seconds() - start;
    rf_end_tune_work( &w );
    for ( int k = 0; k < w.row_count; ++k ) // the most expensive row costs about as much as the pilot image, or more
        cost = t->tune->rows[w.rows[k]].cost > cost ? t->tune->rows[w.rows[k]].cost : cost;
    t->cost_second = 1.5 * cpu / ( samples * cost );
    return result;
}

static RfTuneOutlook make_outlook( const Tuner* t, int number )
{
    double left = t->job->budget - ( rf_wall_seconds() - t->start );
    return ( RfTuneOutlook ){
        .number = number,
        .width = t->job->eyes->width,
        .height = t->job->eyes->height,
        .left = left > 0.0 ? left : 0.0,
        .rate = t->wall > 0.0 && t->cpu > 0.0 ? t->cpu / t->wall : 1.0,
        .cost_second = t->cost_second,
        .memory = t->common.memory,
        .workers = t->common.threads,
        .passes = rf_usual_passes( &t->common ),
    };
}

static int count_candidates( const Tuner* t )
{
    int count = 0;
    for ( int i = 0; i < t->tune->count; ++i )
        count += t->candidate[i];
    return count;
}

static bool is_stopped( const Tuner* t )
{
    const RfTrialWatch* watch = t->job->watch;
    return watch != NULL && watch->should_continue != NULL && !watch->should_continue( watch->user );
}

// Plans a round for the candidates, or for the better half of them if time is too short; false
// if it is too short even for two.
static bool plan_round( Tuner* t, int number, RfTuneRound* round )
{
    RfTuneOutlook outlook = make_outlook( t, number );
    while ( !rf_plan_tune_round( t->tune, t->candidate, &outlook, round ) )
    {
        rf_cut_tune_candidates( t->tune, count_candidates( t ) / 2, t->candidate ); // path tracing stays besides
        if ( count_candidates( t ) < 3 )                                            // path tracing is one of them
            return false;
    }
    return true;
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
        job->report( job->user, t->tune, round, count_candidates( t ) );
    double deadline = number == 0 ? (double)INFINITY : t->start + OVERTIME * job->budget;
    int complete;
    RfResult result = run_round( t, round, deadline, &complete, error );
    t->tune->round_count += complete > 0;
    round->regions = complete;
    rf_smooth_tune_rows( t->tune );
    rf_predict_tune_rows( t->tune, (double)job->eyes->width * job->eyes->height, job->frame_count );
    if ( result == RF_ERROR_INTERRUPTED && !is_stopped( t ) )
    {
        *last = true;
        return RF_OK;
    }
    rf_cut_tune_candidates( t->tune, s_kept[number], t->candidate );
    return result;
}

RfResult rf_tune( const RfTuneJob* job, RfTune* tune, RfError* error )
{
    Tuner t = { .job = job, .tune = tune, .start = rf_wall_seconds() };
    *tune = ( RfTune ){ .goal = job->goal, .chosen = -1 };
    RfResult result = rf_list_tune_rows( job, tune, &t.common, error );
    for ( int i = 0; i < tune->count; ++i )
        t.candidate[i] = tune->rows[i].excluded == NULL;
    if ( result == RF_OK )
        t.common.threads = rf_tune_workers( job, tune, &t.common );
    if ( result == RF_OK )
        result = calibrate( &t, error );
    bool last = false;
    for ( int number = 0; number < RF_TUNE_ROUNDS && result == RF_OK && !last && count_candidates( &t ) > ( number > 0 );
          ++number )
        result = next_round( &t, number, &last, error );
    rf_predict_tune_rows( tune, (double)job->eyes->width * job->eyes->height, job->frame_count );
    tune->seconds = rf_wall_seconds() - t.start;
    if ( result == RF_OK && tune->chosen < 0 )
        return rf_fail( error, RF_ERROR_SCENE,
                        "no error can be measured: the test images are black, or have NaN or infinite pixels" );
    return result;
}
