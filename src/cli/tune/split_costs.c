// Compares renders with and without layers of light: their memory by the plan, their time by short renders.
#include "cli/tune/split_costs.h"

#include "cli/messages.h"
#include "measure/trial_runs.h"
#include "scene/light_groups.h"

#include <math.h>
#include <stdio.h>

#define PIXELS 4096.0 // of each frame that is measured
#define PASSES 2

static RfRenderSettings without_split( const RfRenderSettings* settings )
{
    RfRenderSettings plain = *settings;
    plain.light_groups = NULL;
    plain.aovs &= ~RF_PASS_AOVS;
    return plain;
}

static RfResult count_films( const RfShot* shot, const RfRenderSettings* settings, int* films, RfError* error )
{
    RfLightGroups groups;
    RfResult result = rf_find_light_groups( rf_tracer_scene( shot->tracer ), settings->light_groups, &groups, error );
    if ( result != RF_OK )
        return result;
    *films = groups.count + __builtin_popcount( settings->aovs & RF_PASS_AOVS );
    rf_destroy_light_groups( &groups );
    return RF_OK;
}

static RfResult measure_time( const RfShot* shot, const RfRenderSettings* settings, const RfRenderSettings* plain, double* share,
                              RfError* error )
{
    RfTestRegion region;
    RfTrial trials[2] = { 0 };
    RfTestSite site = { .centre = shot->eye_count / 2, .frames = 2 * settings->group + 1, .pixels = PIXELS };
    RfResult result = rf_create_test_region( shot, NULL, &site, plain, &region, error );
    for ( int k = 0; k < 2 && result == RF_OK; ++k )
    {
        RfRenderSettings one = rf_trial_settings( k == 0 ? plain : settings );
        one.threads = 1;
        result = rf_run_trial( &region, 1, PASSES, &one, trials + k, error );
    }
    rf_destroy_test_region( &region );
    if ( result == RF_OK )
        *share = rf_trial_sample_seconds( trials + 1 ) / rf_trial_sample_seconds( trials ) - 1.0;
    return result;
}

RfResult rf_find_split_costs( const RfShot* shot, const RfRenderSettings* settings, bool measure, RfSplitCosts* costs,
                              RfError* error )
{
    RfMemoryFit fit[2];
    RfRenderSettings plain = without_split( settings );
    *costs = ( RfSplitCosts ){ .time_share = (double)NAN };
    RfResult result = count_films( shot, settings, &costs->films, error );
    if ( result != RF_OK || costs->films == 0 )
        return result;
    result = rf_fit_memory( shot, settings, fit, error );
    if ( result == RF_OK )
        result = rf_fit_memory( shot, &plain, fit + 1, error );
    if ( result != RF_OK )
        return result;
    size_t of_batch = fit[0].bytes_hits / (size_t)fit[0].batches - fit[1].bytes_hits / (size_t)fit[1].batches;
    costs->bytes_films = fit[0].bytes_films > fit[1].bytes_films ? fit[0].bytes_films - fit[1].bytes_films : 0;
    costs->bytes_hits = of_batch * (size_t)fit[0].batches;
    return measure ? measure_time( shot, settings, &plain, &costs->time_share, error ) : RF_OK;
}

void rf_print_split_costs( const RfSplitCosts* costs )
{
    char time[64] = "time: not measured";
    if ( costs->films == 0 )
        return;
    if ( isfinite( costs->time_share ) )
        snprintf( time, sizeof time, "%.0f %% more time", 100.0 * fmax( costs->time_share, 0.0 ) );
    rf_print( "light groups and passes: %d film%s more of each frame, %.1f MiB of films and %.1f MiB of hits more, %s\n",
              costs->films, costs->films == 1 ? "" : "s", (double)costs->bytes_films / 1048576.0,
              (double)costs->bytes_hits / 1048576.0, time );
}

json_t* rf_split_costs_json( const RfSplitCosts* costs )
{
    if ( costs->films == 0 )
        return json_null();
    return json_pack( "{s:i, s:I, s:I, s:o}", "films", costs->films, "bytes_films", (json_int_t)costs->bytes_films, "bytes_hits",
                      (json_int_t)costs->bytes_hits, "time_share", rf_json_number( costs->time_share ) );
}
