#include "cli/render/frame_errors.h"

#include <math.h>
#include <stdio.h>

static void note_solve( RfFrameErrors* errors, RfSolved solved, int number )
{
    if ( solved == RF_SOLVED_ROUGHLY && errors->roughly++ == 0 )
        errors->first_rough = number;
    if ( solved == RF_SOLVED_NOT && errors->not_solved++ == 0 )
        errors->first_not_solved = number;
}

void rf_note_frame_error( RfFrameErrors* errors, const RfFrameResult* result, int number )
{
    ++errors->frames;
    errors->relmse_sum += result->relmse_estimate;
    errors->likely_sum += result->relmse_likely;
    errors->lower_bounds += result->relmse_is_lower_bound;
    errors->missed += result->noise_missed;
    errors->flicker_missed += result->flicker_missed;
    if ( isgreater( result->flicker_likely, errors->worst_flicker ) )
    {
        errors->worst_flicker = result->flicker_likely;
        errors->worst_pair = number;
    }
    note_solve( errors, result->solved, number );
    if ( errors->frames > 1 && islessequal( result->relmse_likely, errors->worst_relmse ) )
        return;
    errors->worst_relmse = result->relmse_likely;
    errors->worst_frame = number;
    errors->worst_is_lower_bound = result->relmse_is_lower_bound;
}

void rf_stop_flicker( RfFrameResult* result )
{
    result->flicker_estimate = result->flicker_likely = result->flicker_worst_ten_share = 0.0;
    result->flicker_is_lower_bound = result->flicker_missed = false;
    result->reached = !result->noise_missed;
}

void rf_print_frame_errors( const RfFrameErrors* errors )
{
    double told = errors->relmse_sum / errors->frames, likely = errors->likely_sum / errors->frames;
    if ( errors->frames == 0 || isfinite( told ) == 0 )
        return;
    if ( errors->lower_bounds > 0 )
        printf( ", relMSE at least %.3g, likely %.3g by its estimate", told, likely );
    else
        printf( ", relMSE %.3g by its estimate", told );
}

void rf_warn_of_solves( const RfFrameErrors* errors, RfLog* log )
{
    if ( errors->roughly > 0 )
        rf_warn( log,
                 "the reconstruction of %d frame%s stopped before it converged, frame %d the first: raise --spp, or try "
                 "--reconstruction l2",
                 errors->roughly, errors->roughly == 1 ? "" : "s", errors->first_rough );
    if ( errors->not_solved > 0 )
        rf_warn( log,
                 "%d frame%s could not be reconstructed, since samples are infinite or NaN, frame %d the first: there the "
                 "pixels are as they are with --reconstruction none",
                 errors->not_solved, errors->not_solved == 1 ? "" : "s", errors->first_not_solved );
}

void rf_warn_of_stop( const RfFrameErrors* errors, const RfRenderSettings* settings, const RfRenderStats* stats, int frame_count,
                      int run_count, RfLog* log )
{
    if ( stats->missed > 0 )
        rf_warn( log, "--noise %g: not reached in %d of %d frames, frame %d %shas %.3g: allow more %s", settings->noise,
                 stats->missed, frame_count, errors->worst_frame, errors->worst_is_lower_bound ? "likely " : "",
                 errors->worst_relmse, settings->time > 0.0 ? "--time or --spp" : "--spp" );
    if ( stats->flicker_missed > 0 )
        rf_warn( log, "--flicker %g: not reached in %d of %d frames, frames %d and %d have a likely F1 of %.3g: allow more %s",
                 settings->flicker, stats->flicker_missed, frame_count, errors->worst_pair - 1, errors->worst_pair,
                 errors->worst_flicker, settings->time > 0.0 ? "--time or --spp" : "--spp" );
    if ( stats->hurried )
        rf_warn( log, "--time %g: too short for this size and these groups: the least, 2 samples per pixel, took %.3g s a frame",
                 settings->time, stats->seconds / run_count );
}
