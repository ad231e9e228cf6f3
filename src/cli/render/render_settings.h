// Reports settings that were changed when they were resolved.
#ifndef REFRAME_CLI_RENDER_RENDER_SETTINGS_H
#define REFRAME_CLI_RENDER_RENDER_SETTINGS_H

#include "reframe/camera.h"
#include "reframe/render.h"

// Prints on standard error which settings differ from those asked for, on a path of
// `path_frames` frames.
void rf_tell_settings( const RfRenderSettings* asked, const RfRenderSettings* used, const RfMemoryFit* fit, int path_frames );

// Prints the names of the effects that are on, left out and forced in a line on standard error.
void rf_tell_effects( const RfEffect* effects, int count );

// Says in which of the frames the camera stands still, and that these are rendered once, on standard error.
void rf_tell_runs( const RfCameraPath* path, const int* frames, int frame_count, int run_count );

#endif
