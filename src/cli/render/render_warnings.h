// What render warns of before the work.
#ifndef REFRAME_CLI_RENDER_RENDER_WARNINGS_H
#define REFRAME_CLI_RENDER_RENDER_WARNINGS_H

#include "cli/options/render_options.h"
#include "reframe/camera.h"
#include "reframe/effects.h"

// A picture that will be black or empty.
void rf_warn_of_scene( const RfRenderOptions* options, const RfScene* scene, const RfTracer* tracer, RfLog* log );

// A single pass, which gives no estimate of its variance.
void rf_warn_of_variance( const RfRenderSettings* settings, const RfCameraPath* path, const int* frames, int frame_count,
                          RfLog* log );

// A reconstruction that is biased, or that so few samples cannot have.
void rf_warn_of_reconstruction( const RfRenderSettings* settings, RfLog* log );

// Light paths that were asked for and that there are none of, or whose normalisation is biased.
void rf_warn_of_light_paths( const RfRenderSettings* settings, const RfEffect* effect, RfLog* log );

#endif
