// Rays from cameras to points: from the one place of a pinhole or a panorama, in packets, or in parallel.
#ifndef REFRAME_REUSE_HARVEST_EYE_RAYS_H
#define REFRAME_REUSE_HARVEST_EYE_RAYS_H

#include "scene/eye.h"
#include "trace/trace.h"

// rf_trace_from_origin from where the camera's rays to the points start. At most RF_LANES of them.
int rf_trace_from_eye( const RfTracer* tracer, const RfEye* eye, int count, const float* const point[3], float* weight );

// The same through thin panes; panes of untested points are left alone.
int rf_trace_from_eye_past_panes( const RfTracer* tracer, const RfEye* eye, int count, const float* const point[3], float* weight,
                                  const RfPaneLanes* panes );

// rf_trace_mirrors from there.
void rf_trace_mirrors_from_eye( const RfTracer* tracer, const RfEye* eye, int count, const float* const point[3],
                                const uint8_t* mirror, float* const hit[3], uint32_t* triangle, float* weight );

#endif
