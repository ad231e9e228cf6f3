// Successive halving over trials: rounds, candidates, workers and the time budget of `tune`.
#include "measure/tune.h"

#include "base/random.h"
#include "base/remedy.h"
#include "base/system.h"
#include "measure/trial.h"
#include "measure/tune_rows.h"
#include "render/settings.h"
#include "trace/trace.h"

#include <math.h>
#include <omp.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

typedef struct TuneWork
{
    const RfTuneJob* job;
    const RfTune* tune;
    const RfTuneRound* round;
    RfTestRegion* regions;
    int rows[RF_TUNE_ROWS], row_count; // candidates
    int region_frames;
    int first_position; // index of the first region's position, over all rounds
    int threads, task_count;
    RfRenderSettings settings; // for a trial
    RfTrial* trials;           // by region, then row
    bool* done;                // same order
    double deadline;           // +inf: none
    RfTrialWatch watch;
    atomic_int next;
    atomic_bool stop;
    pthread_mutex_t mutex; // protects the fields below
    RfResult result;       // the first failure
    RfError error;
} TuneWork;

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

double rf_tune_row_samples( const RfTuneRow* row, int passes ) { return 2.0 * row->eyes * rf_tune_passes( row->eyes, passes ); }

double rf_tune_round_cost( const RfTune* tune, const bool* candidate, const RfTuneRound* round, double cost_second )
{
    double cost = 0.0;
    for ( int i = 0; i < tune->count; ++i )
    {
        const RfTuneRow* row = tune->rows + i;
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

static int count_candidates_in( const RfTune* tune, const bool* candidate )
{
    int count = 0;
    for ( int i = 0; i < tune->count; ++i )
        count += candidate[i];
    return count;
}

bool rf_plan_tune_round( const RfTune* tune, const bool* candidate, const RfTuneOutlook* o, RfTuneRound* round )
{
    double all = (double)o->width * o->height,
           seconds = ( count_candidates_in( tune, candidate ) > FEW ? s_shares[o->number] : 1.0 ) * o->left;
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

#define MAX_WORKERS 256

static bool should_continue( void* user )
{
    TuneWork* w = user;
    const RfTrialWatch* outer = w->job->watch;
    if ( rf_wall_seconds() > w->deadline ||
         ( outer != NULL && outer->should_continue != NULL && !outer->should_continue( outer->user ) ) )
        atomic_store( &w->stop, true );
    return !atomic_load( &w->stop );
}

static RfResult make_region( TuneWork* w, int index, RfError* error )
{
    const RfTuneJob* job = w->job;
    int frame = job->shot.frames[(int)( rf_tune_position( w->first_position + index ) * job->shot.frame_count )];
    RfRenderSettings settings = w->settings;
    settings.seed = rf_mix64( settings.seed ^ (uint64_t)( w->first_position + index ) ); // other pieces each time
    RfTestSite site = { frame, w->region_frames, w->round->pixels };
    return rf_create_test_region( &job->shot, &w->watch, &site, &settings, w->regions + index, error );
}

static RfResult try_row( TuneWork* w, int region, int k, RfError* error )
{
    const RfTuneRow* row = w->tune->rows + w->rows[k];
    RfRenderSettings settings = rf_tune_settings( row, &w->settings );
    settings.seed = rf_mix64( settings.seed ^ rf_mix64( (uint64_t)( w->first_position + region ) ) );
    int index = region * w->row_count + k, passes = rf_tune_passes( row->eyes, w->round->passes );
    RfResult result = rf_run_trial( w->regions + region, 1, passes, &settings, w->trials + index, error );
    w->done[index] = result == RF_OK;
    return result;
}

static void* run_worker( void* user )
{
    TuneWork* w = user;
    RfError error;
    rf_set_float_mode();
    int task;
    while ( ( task = atomic_fetch_add( &w->next, 1 ) ) < w->task_count && !atomic_load( &w->stop ) )
    {
        RfResult result =
            w->trials == NULL ? make_region( w, task, &error ) : try_row( w, task / w->row_count, task % w->row_count, &error );
        if ( result == RF_OK )
            continue;
        atomic_store( &w->stop, true );
        pthread_mutex_lock( &w->mutex );
        if ( w->result == RF_OK || w->result == RF_ERROR_INTERRUPTED )
        {
            w->result = result;
            w->error = error;
        }
        pthread_mutex_unlock( &w->mutex );
    }
    return NULL;
}

// Runs all tasks on as many threads as can be started, including this one.
static void run_tasks( TuneWork* w, int tasks )
{
    pthread_t threads[MAX_WORKERS];
    int wanted = w->threads < tasks ? w->threads : tasks, count = 0;
    w->task_count = tasks;
    atomic_store( &w->next, 0 );
    // Makes this thread OpenMP's first one, since it outlives the others: libomp 14 looks
    // at its first thread whenever a tool (ThreadSanitizer's archer) watches a critical section.
    (void)omp_get_max_threads();
    while ( count + 1 < wanted && count < MAX_WORKERS && pthread_create( threads + count, NULL, run_worker, w ) == 0 )
        count += 1;
    run_worker( w );
    for ( int i = 0; i < count; ++i )
        pthread_join( threads[i], NULL );
}

// Frees what the round holds.
static void end_tune_work( TuneWork* w )
{
    for ( int i = 0; w->regions != NULL && i < w->round->regions; ++i )
        rf_destroy_test_region( w->regions + i );
    free( w->regions );
    free( w->trials );
    free( w->done );
    pthread_mutex_destroy( &w->mutex );
}

// Is a row tried sooner than another? A deadline may leave out the last ones.
static bool goes_before( const RfTuneRow* a, const RfTuneRow* b )
{
    int rank[2] = { rf_is_plain_row( a ) ? 2 : a->usual, rf_is_plain_row( b ) ? 2 : b->usual };
    return rank[0] != rank[1] ? rank[0] > rank[1] : a->efficiency > b->efficiency;
}

// Starts a round. `common` is the job's settings, resolved. Call end_tune_work afterwards.
static void begin_tune_work( const RfTuneJob* job, const RfTune* tune, const RfRenderSettings* common, const bool* candidate,
                             const RfTuneRound* round, int first_position, TuneWork* w )
{
    memset( w, 0, sizeof *w );
    w->job = job;
    w->tune = tune;
    w->round = round;
    w->deadline = job->deadline > 0.0 ? job->deadline : (double)INFINITY;
    w->watch = ( RfTrialWatch ){ should_continue, w };
    pthread_mutex_init( &w->mutex, NULL );
    w->first_position = first_position;
    w->region_frames = rf_tune_region_frames( tune, candidate );
    for ( int i = 0; i < tune->count; ++i )
    {
        int k = candidate[i] ? w->row_count++ : -1;
        for ( ; k > 0 && goes_before( tune->rows + i, tune->rows + w->rows[k - 1] ); --k )
            w->rows[k] = w->rows[k - 1];
        if ( k >= 0 )
            w->rows[k] = i;
    }
    w->threads = common->threads;
    w->settings = *common;
    w->settings.threads = 1;
    w->settings.memory = common->memory / (size_t)common->threads;
}

static RfResult fail_memory( RfError* error )
{
    return rf_fail( error, RF_ERROR_MEMORY, "the system has no memory left to try settings" );
}

// Creates the test regions. Fails with RF_ERROR_INTERRUPTED at the deadline.
static RfResult make_tune_regions( TuneWork* w, RfError* error )
{
    w->regions = calloc( (size_t)w->round->regions, sizeof *w->regions );
    if ( w->regions == NULL )
        return fail_memory( error );
    run_tasks( w, w->round->regions );
    if ( w->result != RF_OK )
        *error = w->error;
    return w->result;
}

// Runs the trials. Fails with RF_ERROR_INTERRUPTED at the deadline.
static RfResult run_tune_trials( TuneWork* w, RfError* error )
{
    size_t count = (size_t)w->round->regions * (size_t)w->row_count;
    w->done = calloc( count, sizeof *w->done );
    w->trials = calloc( count, sizeof *w->trials );
    if ( w->done == NULL || w->trials == NULL )
        return fail_memory( error );
    run_tasks( w, (int)count );
    if ( w->result != RF_OK )
        *error = w->error;
    return w->result;
}

// Adds the trials of the regions at which all rows were tried, in the first round at least those of the first region; returns
// the number of these regions.
static int take_tune_trials( const TuneWork* w, RfTune* tune )
{
    int complete = 0;
    for ( int s = 0; s < w->round->regions; ++s )
    {
        int done = 0;
        for ( int k = 0; k < w->row_count; ++k )
            done += w->done[s * w->row_count + k];
        if ( done < w->row_count && ( done == 0 || tune->round_count > 0 || s > 0 ) )
            continue;
        for ( int k = 0; k < w->row_count; ++k )
        {
            if ( !w->done[s * w->row_count + k] )
                continue;
            rf_add_trial( &tune->rows[w->rows[k]].trial, w->trials + s * w->row_count + k );
            tune->rows[w->rows[k]].rounds += complete == 0;
        }
        complete += 1;
    }
    return complete;
}

// CPU seconds spent so far.
static double tune_work_seconds( const TuneWork* w )
{
    double cpu = 0.0;
    for ( int i = 0; w->regions != NULL && i < w->round->regions; ++i )
        cpu += w->regions[i].seconds;
    for ( int i = 0; w->trials != NULL && i < w->round->regions * w->row_count; ++i )
    {
        const RfTrial* trial = w->trials + i;
        if ( trial->timed_samples > 0.0 )
            cpu += rf_trial_sample_seconds( trial ) * trial->samples;
    }
    return cpu;
}

#define SLACK 0.9           // of the time left for a round without a later one: trials end at different times
#define LEAST_ROWS 3        // path tracing, what is usual and another one
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

static RfResult run_round( Tuner* t, const RfTuneRound* round, int* complete, RfError* error )
{
    TuneWork w;
    begin_tune_work( t->job, t->tune, &t->common, t->candidate, round, t->positions, &w );
    *complete = 0;
    double start = rf_wall_seconds();
    RfResult result = make_tune_regions( &w, error );
    if ( result == RF_OK )
        result = run_tune_trials( &w, error );
    if ( w.done != NULL && ( result == RF_OK || result == RF_ERROR_INTERRUPTED ) )
        *complete = take_tune_trials( &w, t->tune );
    t->cpu += tune_work_seconds( &w );
    t->wall += rf_wall_seconds() - start;
    t->positions += round->regions;
    end_tune_work( &w );
    return result;
}

// Renders a few pieces to measure the speed of this machine in this scene.
static RfResult calibrate( Tuner* t, RfError* error )
{
    const RfTuneJob* job = t->job;
    double all = (double)job->shot.eyes->width * job->shot.eyes->height;
    RfTuneRound round = { .pixels = fmin( FIRST_PIXELS, all ),
                          .regions = t->common.threads,
                          .passes = rf_usual_passes( &t->common ) };
    TuneWork w;
    begin_tune_work( job, t->tune, &t->common, t->candidate, &round, 0, &w );
    double start = rf_wall_seconds(), cost = 0.0;
    RfResult result = make_tune_regions( &w, error );
    double samples = result == RF_OK ? w.regions->samples * round.regions : 1.0, cpu = tune_work_seconds( &w );
    t->cpu += cpu;
    t->wall += rf_wall_seconds() - start;
    end_tune_work( &w );
    for ( int k = 0; k < w.row_count; ++k ) // the most expensive row costs about as much as the pilot image, or more
        cost = t->tune->rows[w.rows[k]].cost > cost ? t->tune->rows[w.rows[k]].cost : cost;
    t->cost_second = 1.5 * cpu / ( samples * cost );
    return result;
}

static int count_candidates( const Tuner* t )
{
    int count = 0;
    for ( int i = 0; i < t->tune->count; ++i )
        count += t->candidate[i];
    return count;
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
        .must = number == 0 && ( t->job->deadline == 0.0 || count_candidates( t ) < LEAST_ROWS ),
    };
}

static bool is_stopped( const Tuner* t )
{
    const RfTrialWatch* watch = t->job->watch;
    return watch != NULL && watch->should_continue != NULL && !watch->should_continue( watch->user );
}

// Was that the deadline?
static bool is_late( const Tuner* t, RfResult result ) { return result == RF_ERROR_INTERRUPTED && !is_stopped( t ); }

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
    for ( int kept = count_candidates( t ) - 1;; --kept )
    {
        RfTuneOutlook outlook = make_outlook( t, number );
        if ( rf_plan_tune_round( t->tune, t->candidate, &outlook, round ) )
            return true;
        rf_cut_tune_candidates( t->tune, kept, t->candidate ); // path tracing and what is usual stay besides
        if ( number > 0 && ( count_candidates( t ) < LEAST_ROWS || kept <= 0 ) )
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
        job->report( job->user, t->tune, round, count_candidates( t ) );
    int complete;
    RfResult result = run_round( t, round, &complete, error );
    t->tune->round_count += complete > 0;
    round->regions = complete;
    rf_smooth_tune_rows( t->tune );
    rf_predict_tune_rows( t->tune, (double)job->shot.eyes->width * job->shot.eyes->height, job->shot.frame_count );
    if ( is_late( t, result ) )
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
    Tuner t = { .job = job, .tune = tune, .start = rf_wall_seconds() };
    *tune = ( RfTune ){ .goal = job->goal, .chosen = -1 };
    RfResult result = rf_list_tune_rows( job, tune, &t.common, error );
    for ( int i = 0; i < tune->count; ++i )
        t.candidate[i] = tune->rows[i].excluded == NULL;
    if ( result == RF_OK )
        t.common.threads = rf_tune_workers( job, tune, &t.common );
    if ( result == RF_OK )
        result = calibrate( &t, error );
    bool last = is_late( &t, result );
    if ( last )
    {
        tune->needed = 4.0 * job->budget;
        result = RF_OK;
    }
    for ( int number = 0; number < RF_TUNE_ROUNDS && result == RF_OK && !last && count_candidates( &t ) > ( number > 0 );
          ++number )
        result = next_round( &t, number, &last, error );
    rf_predict_tune_rows( tune, (double)job->shot.eyes->width * job->shot.eyes->height, job->shot.frame_count );
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
