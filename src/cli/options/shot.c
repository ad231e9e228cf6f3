// Frames of a camera at rest are rendered once, and paths that are cut short are warned of.
#include "cli/options/shot.h"

#include "cli/messages.h"

#include <stdlib.h>

int* rf_runs_of_frames( const RfCameraPath* path, const int* frames, int frame_count, int* run_count )
{
    int* runs = malloc( ( (size_t)frame_count + 1 ) * sizeof *runs );
    *run_count = 0;
    for ( int i = 0; i < frame_count && runs != NULL; ++i )
    {
        int run = path->run_of_frame[frames[i]];
        if ( *run_count == 0 || runs[*run_count - 1] != run )
            runs[( *run_count )++] = run;
    }
    return runs;
}

#define LITTLE_LIGHT 0.0005 // of all: JSON and headers alone say it

RfResult rf_warn_of_depth( const RfShot* shot, const RfRenderSettings* settings, RfLog* log, double* share, RfError* error )
{
    RfResult result = rf_find_light_beyond_depth( shot, settings, share, error );
    if ( result == RF_OK && *share >= LITTLE_LIGHT )
        rf_warn( log, "--max-depth %d: about %.2g %% of the light is beyond and missing: raise it, or leave it out",
                 settings->max_depth, 100.0 * *share );
    return result;
}
