#include "measure/tune_work.h"

#include "base/random.h"
#include "base/remedy.h"
#include "base/system.h"
#include "measure/tune_internal.h"
#include "trace/trace.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

#define MAX_WORKERS 256

static bool should_continue( void* user )
{
    RfTuneWork* w = user;
    const RfTrialWatch* outer = w->job->watch;
    if ( rf_wall_seconds() > w->deadline ||
         ( outer != NULL && outer->should_continue != NULL && !outer->should_continue( outer->user ) ) )
        atomic_store( &w->stop, true );
    return !atomic_load( &w->stop );
}

static RfResult make_region( RfTuneWork* w, int index, RfError* error )
{
    const RfTuneJob* job = w->job;
    int frame = job->frames[(int)( rf_tune_position( w->first_position + index ) * job->frame_count )];
    RfRenderSettings settings = w->settings;
    settings.seed = rf_mix64( settings.seed ^ (uint64_t)( w->first_position + index ) ); // other pieces each time
    return rf_create_test_region( job->tracer, job->eyes, job->eye_count, frame, w->region_frames, w->round->pixels, &settings,
                                  &w->watch, w->regions + index, error );
}

static RfResult try_row( RfTuneWork* w, int region, int k, RfError* error )
{
    const RfTuneRow* row = w->tune->rows + w->rows[k];
    RfRenderSettings settings = rf_tune_settings( row, &w->settings );
    settings.seed = rf_mix64( settings.seed ^ rf_mix64( (uint64_t)( w->first_position + region ) ) );
    int index = region * w->row_count + k;
    RfResult result = rf_run_trial( w->job->tracer, w->regions + region, rf_tune_groups( row->eyes ), w->round->passes, &settings,
                                    &w->watch, w->trials + index, error );
    w->done[index] = result == RF_OK;
    return result;
}

static void* run_worker( void* user )
{
    RfTuneWork* w = user;
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
static void run_tasks( RfTuneWork* w, int tasks )
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

void rf_end_tune_work( RfTuneWork* w )
{
    for ( int i = 0; w->regions != NULL && i < w->round->regions; ++i )
        rf_destroy_test_region( w->regions + i );
    free( w->regions );
    free( w->trials );
    free( w->done );
    pthread_mutex_destroy( &w->mutex );
}

void rf_begin_tune_work( const RfTuneJob* job, const RfTune* tune, const RfRenderSettings* common, const bool* candidate,
                         const RfTuneRound* round, int first_position, double deadline, RfTuneWork* w )
{
    memset( w, 0, sizeof *w );
    w->job = job;
    w->tune = tune;
    w->round = round;
    w->deadline = deadline;
    w->watch = ( RfTrialWatch ){ should_continue, w };
    pthread_mutex_init( &w->mutex, NULL );
    w->first_position = first_position;
    w->region_frames = rf_tune_region_frames( tune, candidate );
    for ( int i = 0; i < tune->count; ++i )
    {
        if ( candidate[i] )
            w->rows[w->row_count++] = i;
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

RfResult rf_make_tune_regions( RfTuneWork* w, RfError* error )
{
    w->regions = calloc( (size_t)w->round->regions, sizeof *w->regions );
    if ( w->regions == NULL )
        return fail_memory( error );
    run_tasks( w, w->round->regions );
    if ( w->result != RF_OK )
        *error = w->error;
    return w->result;
}

RfResult rf_run_tune_trials( RfTuneWork* w, RfError* error )
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

int rf_take_tune_trials( const RfTuneWork* w, RfTune* tune )
{
    int complete = 0;
    for ( int s = 0; s < w->round->regions; ++s )
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

double rf_tune_work_seconds( const RfTuneWork* w )
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
