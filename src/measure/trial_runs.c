// The tasks of a round of trials on several threads, until the deadline.
#include "measure/trial_runs.h"

#include "base/random.h"
#include "base/system.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>

RfRenderSettings rf_trial_settings( const RfRenderSettings* settings )
{
    RfRenderSettings s = *settings;
    s.noise = s.flicker = s.time = 0.0;
    s.adaptive = RF_ADAPTIVE_OFF;
    s.clamp = s.clamp_chains = 0.0;
    s.aovs &= ~RF_AOV_BIT( RF_AOV_REMOVED );
    return s;
}

// Exponents of rooms are 1.0 to 1.3, the most where light is direct; errors of a trial scatter by a sixth.
#define USUAL_EXPONENT 1.12
#define EXPONENT_SPREAD 0.08
#define TRIAL_SPREAD 0.15
#define SPREAD_FREEDOM 4 // how many deviations TRIAL_SPREAD counts as

static bool is_point( const RfErrorPoint* p ) { return isgreater( p->error, 0.0 ) && isfinite( p->error ) && p->weight > 0.0; }

RfErrorLine rf_fit_error_line( const RfErrorPoint* points, int count, double margin )
{
    const RfInterval none = { (double)NAN, (double)NAN, (double)NAN };
    double prior = TRIAL_SPREAD * TRIAL_SPREAD / ( EXPONENT_SPREAD * EXPONENT_SPREAD );
    double weight = 0.0, x = 0.0, y = 0.0, xx = prior, xy = -prior * USUAL_EXPONENT;
    double rest = SPREAD_FREEDOM * TRIAL_SPREAD * TRIAL_SPREAD, freedom = SPREAD_FREEDOM - 1;
    for ( const RfErrorPoint* p = points; p < points + count; ++p )
    {
        double w = is_point( p ) ? p->weight : 0.0;
        weight += w;
        x += w > 0.0 ? w * log( p->samples ) : 0.0;
        y += w > 0.0 ? w * log( p->error ) : 0.0;
        freedom += w > 0.0;
    }
    if ( weight == 0.0 )
        return ( RfErrorLine ){ (double)NAN, none, none };
    x /= weight;
    y /= weight;
    for ( const RfErrorPoint* p = points; p < points + count; ++p )
    {
        double u = is_point( p ) ? log( p->samples ) - x : 0.0;
        xx += u != 0.0 ? p->weight * u * u : 0.0;
        xy += u != 0.0 ? p->weight * u * ( log( p->error ) - y ) : 0.0;
    }
    double exponent = -xy / xx;
    rest += prior * ( exponent - USUAL_EXPONENT ) * ( exponent - USUAL_EXPONENT );
    for ( const RfErrorPoint* p = points; p < points + count; ++p )
    {
        double away = is_point( p ) ? log( p->error ) - y + exponent * ( log( p->samples ) - x ) : 0.0;
        rest += away != 0.0 ? p->weight * away * away : 0.0;
    }
    double spread = rf_student_quantile( (int)freedom ) * sqrt( rest / freedom );
    double slack = fmin( spread / sqrt( xx ), 1.96 * EXPONENT_SPREAD );
    return ( RfErrorLine ){ exp( x ),
                            rf_log_interval( exp( y ), sqrt( margin * margin + spread * spread / weight ) ),
                            { exponent, exponent - slack, exponent + slack } };
}

RfErrorLine rf_usual_line( double samples, RfInterval error )
{
    double slack = 1.96 * EXPONENT_SPREAD;
    return ( RfErrorLine ){ samples, error, { USUAL_EXPONENT, USUAL_EXPONENT - slack, USUAL_EXPONENT + slack } };
}

// The margin of the logarithm of an error so far from the middle of the line.
static double line_margin( const RfErrorLine* line, double way )
{
    double slack = ( line->exponent.high - line->exponent.value ) * way, margin = log( line->error.high / line->error.value );
    return sqrt( margin * margin + slack * slack );
}

RfInterval rf_line_error( const RfErrorLine* line, double samples )
{
    double way = log( samples / line->samples );
    return rf_log_interval( line->error.value * exp( -line->exponent.value * way ), line_margin( line, way ) );
}

RfInterval rf_line_samples( const RfErrorLine* line, double error )
{
    double way = log( line->error.value / error ) / line->exponent.value;
    return rf_log_interval( line->samples * exp( way ), line_margin( line, way ) / line->exponent.value );
}

void rf_predict_trial_row( RfTrialRow* row, double pixels, int frames, double factor )
{
    static const RfTrial none = { 0 };
    const RfTrial* trial = row->rounds > 0 ? &row->trial : &none;
    double passes = rf_trial_passes( trial );
    RfInterval error = rf_trial_error( trial );
    RfErrorLine line = rf_usual_line(
        passes, ( RfInterval ){ factor * error.value / passes, factor * error.low / passes, factor * error.high / passes } );
    double finish = trial->finish_pixels > 0.0 ? trial->finish_seconds / trial->finish_pixels : 0.0;
    row->cpu_seconds =
        row->samples * rf_trial_sample_seconds( trial ) * exp( row->log_time ) + frames * pixels * fmax( finish, 0.0 );
    row->seconds = row->cpu_seconds / row->fit.threads;
    row->error = rf_line_error( &line, row->spp );
    row->relmse = row->error.value;
    row->f1 = rf_trial_f1( trial, row->spp ) * pow( row->spp / passes, 0.5 * ( 1.0 - line.exponent.value ) );
    row->phi = trial->weight > 0.0 ? rf_trial_phi( trial ) : (double)NAN;
}

static bool may_go_on( const RfTrialWatch* watch )
{
    return watch == NULL || watch->should_continue == NULL || watch->should_continue( watch->user );
}

static bool should_continue( void* user )
{
    RfTrialRuns* runs = user;
    if ( ( runs->deadline > 0.0 && rf_wall_seconds() > runs->deadline ) || !may_go_on( runs->watch ) )
        atomic_store( &runs->stop, true );
    return !atomic_load( &runs->stop );
}

bool rf_is_late( const RfTrialRuns* runs, RfResult result ) { return result == RF_ERROR_INTERRUPTED && may_go_on( runs->watch ); }

static RfResult make_region( RfTrialRuns* runs, int index, RfError* error )
{
    RfRenderSettings settings = runs->pilot;
    settings.seed = rf_mix64( settings.seed ^ (uint64_t)( runs->first + index ) );
    return rf_create_test_region( &runs->shot, &runs->stopper, runs->sites + index, &settings, runs->regions + index, error );
}

static RfResult run_trial( RfTrialRuns* runs, int index, RfError* error )
{
    int region = index / runs->task_count;
    const RfTrialTask* task = runs->tasks + index % runs->task_count;
    RfRenderSettings settings = task->settings;
    settings.seed = rf_mix64( settings.seed ^ rf_mix64( (uint64_t)( runs->first + region ) ) );
    RfResult result = rf_run_trial( runs->regions + region, task->groups, task->passes, &settings, runs->trials + index, error );
    runs->done[index] = result == RF_OK;
    return result;
}

// The first failure stops all; a deadline is the least of failures.
static RfResult run_tasks( RfTrialRuns* runs, int count, RfResult ( *task )( RfTrialRuns* runs, int index, RfError* error ),
                           RfError* error )
{
    RfResult first = RF_OK;
    atomic_store( &runs->stop, false );
#pragma omp parallel for schedule( dynamic, 1 ) num_threads( runs->workers )
    for ( int i = 0; i < count; ++i )
    {
        RfError failure = { 0 };
        if ( atomic_load( &runs->stop ) )
            continue;
        rf_set_float_mode();
        RfResult result = task( runs, i, &failure );
        if ( result == RF_OK )
            continue;
        atomic_store( &runs->stop, true );
#pragma omp critical
        if ( first == RF_OK || first == RF_ERROR_INTERRUPTED )
        {
            first = result;
            *error = failure;
        }
    }
    return first;
}

static RfResult fail_memory( RfError* error ) { return rf_fail( error, RF_ERROR_MEMORY, "out of memory trying settings" ); }

static void free_trials( RfTrialRuns* runs )
{
    free( runs->trials );
    free( runs->done );
    runs->trials = NULL;
    runs->done = NULL;
    runs->task_count = 0;
}

void rf_end_trial_runs( RfTrialRuns* runs )
{
    for ( int i = 0; i < runs->region_count; ++i )
        rf_destroy_test_region( runs->regions + i );
    free( runs->regions );
    runs->regions = NULL;
    runs->region_count = 0;
    free_trials( runs );
}

RfResult rf_make_trial_regions( RfTrialRuns* runs, const RfTestSite* sites, int count, RfError* error )
{
    rf_end_trial_runs( runs );
    runs->regions = calloc( (size_t)count, sizeof *runs->regions );
    if ( runs->regions == NULL )
        return fail_memory( error );
    runs->region_count = count;
    runs->sites = sites;
    runs->stopper = ( RfTrialWatch ){ should_continue, runs };
    return run_tasks( runs, count, make_region, error );
}

RfResult rf_run_trials( RfTrialRuns* runs, const RfTrialTask* tasks, int count, RfError* error )
{
    size_t trials = (size_t)runs->region_count * (size_t)count;
    free_trials( runs );
    runs->trials = calloc( trials, sizeof *runs->trials );
    runs->done = calloc( trials, sizeof *runs->done );
    if ( runs->trials == NULL || runs->done == NULL )
        return fail_memory( error );
    runs->tasks = tasks;
    runs->task_count = count;
    return run_tasks( runs, (int)trials, run_trial, error );
}

double rf_trial_runs_seconds( const RfTrialRuns* runs )
{
    double cpu = 0.0;
    for ( int i = 0; i < runs->region_count; ++i )
        cpu += runs->regions[i].seconds;
    for ( int i = 0; i < runs->region_count * runs->task_count; ++i )
    {
        const RfTrial* trial = runs->trials + i;
        if ( trial->timed_samples > 0.0 )
            cpu += rf_trial_sample_seconds( trial ) * trial->samples;
    }
    return cpu;
}

int rf_trial_workers( size_t memory, const RfMemoryFit* fit, int most )
{
    size_t room = memory / ( 2 * ( fit->bytes_films + fit->bytes_hits + fit->bytes_lists ) + 1 );
    return room < 1 ? 1 : room < (size_t)most ? (int)room : most;
}
