#include "measure/tune_internal.h"

#include "base/random.h"
#include "base/system.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define OVERTIME 1.1 // times the budget, at which the last round is broken off
#define FIRST_PIXELS 1000.0
#define MOST_WORKERS 256

static const int s_kept[RF_TUNE_ROUNDS] = { 16, 8, 4, 1 }; // settings, after each round

typedef struct Tuner
{
    const RfTuneJob* job;
    RfTune* tune;
    RfRenderSettings common; // resolved
    bool candidate[RF_TUNE_ROWS];
    double start;
    int places;       // of the path that sites have been made at
    double cpu, wall; // spent by rounds so far
    double cost_second;
} Tuner;

// One round at work: its tasks are the sites, then each candidate at each of them.
typedef struct Work
{
    const Tuner* tuner;
    const RfTuneRound* round;
    RfTrialSite* sites;
    int rows[RF_TUNE_ROWS], row_count;
    int site_frames, first_place;
    int task_count;
    RfRenderSettings settings;  // of a trial
    RfTrial* trials;            // by site, then row
    bool* done;                 // likewise
    double deadline;            // +inf: none
    RfTrialWatch watch;
    atomic_int next;
    atomic_bool stop;
    pthread_mutex_t mutex; // of the rest
    RfResult result;       // the first failure
    RfError error;
} Work;

static bool go_on( void* user )
{
    Work* w = user;
    const RfTrialWatch* outer = w->tuner->job->watch;
    if ( rf_wall_seconds() > w->deadline || ( outer != NULL && outer->go_on != NULL && !outer->go_on( outer->user ) ) )
        atomic_store( &w->stop, true );
    return !atomic_load( &w->stop );
}

static RfResult make_site( Work* w, int index, RfError* error )
{
    const RfTuneJob* job = w->tuner->job;
    int frame = job->frames[(int)( rf_tune_place( w->first_place + index ) * job->frame_count )];
    return rf_create_trial_site( job->tracer, job->eyes, job->eye_count, frame, w->site_frames, w->round->width,
                                 w->round->height, &w->settings, &w->watch, w->sites + index, error );
}

static RfResult try_row( Work* w, int site, int k, RfError* error )
{
    const RfTuneRow* row = w->tuner->tune->rows + w->rows[k];
    RfRenderSettings settings = rf_tune_settings( row, &w->settings );
    settings.seed = rf_mix64( settings.seed ^ rf_mix64( (uint64_t)( w->first_place + site ) ) );
    int index = site * w->row_count + k;
    RfResult result = rf_run_trial( w->tuner->job->tracer, w->sites + site, rf_tune_windows( row->eyes ), w->round->passes,
                                    &settings, &w->watch, w->trials + index, error );
    w->done[index] = result == RF_OK;
    return result;
}

static void* work( void* user )
{
    Work* w = user;
    RfError error;
    rf_set_float_mode();
    int task;
    while ( ( task = atomic_fetch_add( &w->next, 1 ) ) < w->task_count && !atomic_load( &w->stop ) )
    {
        RfResult result = w->trials == NULL ? make_site( w, task, &error ) : try_row( w, task / w->row_count, task % w->row_count, &error );
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

// All tasks, by as many threads as can be had, this one among them.
static void share_out( Work* w, int tasks )
{
    pthread_t threads[MOST_WORKERS];
    int wanted = w->tuner->common.threads < tasks ? w->tuner->common.threads : tasks, count = 0;
    w->task_count = tasks;
    atomic_store( &w->next, 0 );
    while ( count + 1 < wanted && count < MOST_WORKERS && pthread_create( threads + count, NULL, work, w ) == 0 )
        count += 1;
    work( w );
    for ( int i = 0; i < count; ++i )
        pthread_join( threads[i], NULL );
}

static void destroy_work( Work* w )
{
    for ( int i = 0; w->sites != NULL && i < w->round->sites; ++i )
        rf_destroy_trial_site( w->sites + i );
    free( w->sites );
    free( w->trials );
    free( w->done );
    pthread_mutex_destroy( &w->mutex );
}

static void init_work( const Tuner* t, const RfTuneRound* round, double deadline, Work* w )
{
    memset( w, 0, sizeof *w );
    w->tuner = t;
    w->round = round;
    w->deadline = deadline;
    w->watch = ( RfTrialWatch ){ go_on, w };
    pthread_mutex_init( &w->mutex, NULL );
    w->first_place = t->places;
    w->site_frames = rf_tune_site_frames( t->tune, t->candidate );
    for ( int i = 0; i < t->tune->count; ++i )
    {
        if ( t->candidate[i] )
            w->rows[w->row_count++] = i;
    }
    w->settings = t->common;
    w->settings.threads = 1;
    w->settings.memory = t->common.memory / (size_t)t->common.threads;
}

static RfResult fail_memory( RfError* error )
{
    return rf_fail( error, RF_ERROR_MEMORY, "no memory left to try settings: lower --size or --threads" );
}

static RfResult make_sites( Work* w, RfError* error )
{
    w->sites = calloc( (size_t)w->round->sites, sizeof *w->sites );
    if ( w->sites == NULL )
        return fail_memory( error );
    share_out( w, w->round->sites );
    if ( w->result != RF_OK )
        *error = w->error;
    return w->result;
}

static RfResult run_trials( Work* w, RfError* error )
{
    size_t count = (size_t)w->round->sites * (size_t)w->row_count;
    w->done = calloc( count, sizeof *w->done );
    w->trials = calloc( count, sizeof *w->trials );
    if ( w->done == NULL || w->trials == NULL )
        return fail_memory( error );
    share_out( w, (int)count );
    if ( w->result != RF_OK )
        *error = w->error;
    return w->result;
}

// Sites at which all rows were tried; returns how many.
static int take_trials( const Work* w, RfTune* tune )
{
    int complete = 0;
    for ( int s = 0; s < w->round->sites; ++s )
    {
        int done = 0;
        for ( int k = 0; k < w->row_count; ++k )
            done += w->done[s * w->row_count + k];
        if ( done < w->row_count )
            continue;
        for ( int k = 0; k < w->row_count; ++k )
            rf_add_trial( &tune->rows[w->rows[k]].trial, w->trials + s * w->row_count + k );
        complete += 1;
    }
    for ( int k = 0; k < w->row_count && complete > 0; ++k )
        tune->rows[w->rows[k]].rounds += 1;
    return complete;
}

static double site_seconds( const Work* w )
{
    double cpu = 0.0;
    for ( int i = 0; i < w->round->sites; ++i )
        cpu += w->sites[i].seconds;
    return cpu;
}

// Time that rounds take for their rows, and for the rest.
static void account( Tuner* t, const Work* w, double wall )
{
    t->cpu += site_seconds( w );
    t->wall += wall;
    for ( int i = 0; w->trials != NULL && i < w->round->sites * w->row_count; ++i )
    {
        const RfTrial* trial = w->trials + i;
        if ( trial->timed_samples > 0.0 )
            t->cpu += trial->cpu_seconds / trial->timed_samples * trial->samples;
    }
}

static RfResult run_round( Tuner* t, const RfTuneRound* round, double deadline, int* complete, RfError* error )
{
    Work w;
    init_work( t, round, deadline, &w );
    *complete = 0;
    double start = rf_wall_seconds();
    RfResult result = make_sites( &w, error );
    if ( result == RF_OK )
        result = run_trials( &w, error );
    if ( w.done != NULL && ( result == RF_OK || result == RF_ERROR_INTERRUPTED ) )
        *complete = take_trials( &w, t->tune );
    account( t, &w, rf_wall_seconds() - start );
    t->places += round->sites;
    destroy_work( &w );
    return result;
}

// A little picture tells how fast this machine is in this scene.
static RfResult calibrate( Tuner* t, RfError* error )
{
    const RfTuneJob* job = t->job;
    double scale = sqrt( FIRST_PIXELS / ( (double)job->eyes->width * job->eyes->height ) );
    RfTuneRound round = { .width = job->eyes->width, .height = job->eyes->height, .sites = t->common.threads, .passes = 2 };
    if ( scale < 1.0 )
    {
        round.width = (int)( job->eyes->width * scale ) + 1;
        round.height = (int)( job->eyes->height * scale ) + 1;
    }
    Work w;
    init_work( t, &round, (double)INFINITY, &w );
    double start = rf_wall_seconds(), cost = 0.0;
    RfResult result = make_sites( &w, error );
    double samples = result == RF_OK ? w.sites->samples * round.sites : 1.0, cpu = site_seconds( &w );
    account( t, &w, rf_wall_seconds() - start );
    destroy_work( &w );
    for ( int k = 0; k < w.row_count; ++k ) // the dearest is like the site's own, or dearer
        cost = t->tune->rows[w.rows[k]].cost > cost ? t->tune->rows[w.rows[k]].cost : cost;
    t->cost_second = 1.5 * cpu / ( samples * cost );
    return result;
}

static RfTuneOutlook look_out( const Tuner* t, int number )
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
    return watch != NULL && watch->go_on != NULL && !watch->go_on( watch->user );
}

// A round for the candidates, or where there is no time for so many for the better
// half of them; false: not even for two.
static bool plan_round( Tuner* t, int number, RfTuneRound* round )
{
    RfTuneOutlook outlook = look_out( t, number );
    while ( !rf_plan_tune_round( t->tune, t->candidate, &outlook, round ) )
    {
        rf_cut_tune_candidates( t->tune, ( count_candidates( t ) + 1 ) / 2, t->candidate );
        if ( count_candidates( t ) < 2 )
            return false;
    }
    return true;
}

// What a round that was broken off at its deadline did not get done is left out.
static RfResult next_round( Tuner* t, int number, bool* last, RfError* error )
{
    const RfTuneJob* job = t->job;
    RfTuneRound* round = t->tune->rounds + number;
    *last = !plan_round( t, number, round );
    if ( *last )
        return RF_OK;
    if ( job->say != NULL )
        job->say( job->user, t->tune, round, count_candidates( t ) );
    double deadline = number == 0 ? (double)INFINITY : t->start + OVERTIME * job->budget;
    int complete;
    RfResult result = run_round( t, round, deadline, &complete, error );
    t->tune->round_count += complete > 0;
    round->sites = complete;
    rf_weigh_tune_rows( t->tune, (double)job->eyes->width * job->eyes->height, job->frame_count );
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
    *tune = ( RfTune ){ .chosen = -1 };
    RfResult result = rf_list_tune_rows( job, tune, &t.common, error );
    for ( int i = 0; i < tune->count; ++i )
        t.candidate[i] = tune->rows[i].excluded == NULL;
    if ( result == RF_OK )
        result = calibrate( &t, error );
    bool last = false;
    for ( int number = 0; number < RF_TUNE_ROUNDS && result == RF_OK && !last && count_candidates( &t ) > ( number > 0 ); ++number )
        result = next_round( &t, number, &last, error );
    rf_weigh_tune_rows( tune, (double)job->eyes->width * job->eyes->height, job->frame_count );
    tune->seconds = rf_wall_seconds() - t.start;
    if ( result == RF_OK && tune->chosen < 0 )
        return rf_fail( error, RF_ERROR_SCENE, "no setting has an error that can be measured: the pictures are black, or hold what is no number" );
    return result;
}
