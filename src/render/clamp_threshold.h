// The threshold of the clamp (src/reuse/estimators.md, E15): as it was given, or found by a pilot.
#ifndef REFRAME_RENDER_CLAMP_THRESHOLD_H
#define REFRAME_RENDER_CLAMP_THRESHOLD_H

#include "reframe/error.h"

#include <stdint.h>

// What is clamped.
typedef enum RfClampKind
{
    RF_CLAMP_PATHS,  // indirect light at hits
    RF_CLAMP_CHAINS, // lights that camera rays find by chains
    RF_CLAMP_KINDS
} RfClampKind;

// Of a frame, luminance.
typedef struct RfClampThresholds
{
    float threshold[RF_CLAMP_KINDS];
} RfClampThresholds;

// What a path brings to a pixel.
typedef struct RfWatchedPath
{
    int32_t pixel;
    RfClampKind kind;
    float luminance;
} RfWatchedPath;

// A list of such paths, for one thread.
typedef struct RfClampWatch
{
    RfWatchedPath* paths;
    int count, capacity; // paths beyond the capacity are not listed
} RfClampWatch;

static inline void rf_watch_path( RfClampWatch* watch, RfClampKind kind, int32_t pixel, float luminance )
{
    if ( luminance > 0.0f && watch->count < watch->capacity )
        watch->paths[watch->count++] = ( RfWatchedPath ){ pixel, kind, luminance };
}

typedef struct RfRenderer RfRenderer;

// With settings.clamp: allocates and fills renderer->clamps, a threshold for each frame of the path. Deterministic, of settings and
// path alone. Fails with RF_ERROR_MEMORY.
RfResult rf_find_clamps( RfRenderer* renderer, RfError* error );

#endif
