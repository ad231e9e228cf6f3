#include "cli/render/frame_errors.h"

#include <math.h>
#include <stdio.h>

void rf_note_frame_error( RfFrameErrors* errors, const RfFrameResult* result, int number )
{
    ++errors->frames;
    errors->relmse_sum += result->relmse_estimate;
    errors->likely_sum += result->relmse_likely;
    errors->lower_bounds += result->relmse_is_lower_bound;
    errors->missed += !result->reached;
    if ( errors->frames > 1 && islessequal( result->relmse_likely, errors->worst_relmse ) )
        return;
    errors->worst_relmse = result->relmse_likely;
    errors->worst_frame = number;
    errors->worst_is_lower_bound = result->relmse_is_lower_bound;
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

void rf_warn_of_stop( const RfFrameErrors* errors, const RfRenderSettings* settings, const RfRenderStats* stats, int frame_count,
                      int run_count, RfLog* log )
{
    if ( stats->missed > 0 )
        rf_warn( log, "--noise %g: not reached in %d of %d frames, frame %d %shas %.3g: allow more %s", settings->noise,
                 stats->missed, frame_count, errors->worst_frame, errors->worst_is_lower_bound ? "likely " : "",
                 errors->worst_relmse, settings->time > 0.0 ? "--time or --spp" : "--spp" );
    if ( stats->hurried )
        rf_warn( log, "--time %g: too short for this size and these groups: the least, 2 samples per pixel, took %.3g s a frame",
                 settings->time, stats->seconds / run_count );
}
