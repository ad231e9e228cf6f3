// What render, tune and cost find out about a shot before they work.
#ifndef REFRAME_CLI_OPTIONS_SHOT_H
#define REFRAME_CLI_OPTIONS_SHOT_H

#include "reframe/camera.h"
#include "reframe/render.h"

// Warns where max_depth takes light, and says its share; 0 without a limit.
RfResult rf_warn_of_depth( const RfShot* shot, const RfRenderSettings* settings, RfLog* log, double* share, RfError* error );

// The runs of the path that hold any of the frames, ascending, and their number: what is to be rendered. The
// caller frees them; NULL where memory ran out.
int* rf_runs_of_frames( const RfCameraPath* path, const int* frames, int frame_count, int* run_count );

#endif
