// A set of light paths of a scene, without a render around it.
#ifndef REFRAME_TESTS_LIGHT_PATH_SET_H
#define REFRAME_TESTS_LIGHT_PATH_SET_H

#include "light_paths/light_paths.h"
#include "path/wavefront.h"

typedef struct LightPathSet
{
    RfTracer* tracer;
    RfRenderSettings settings;
    RfEstimatorGroup group; // points to `settings`
    RfPathSettings path;
    RfLightPaths* paths;
} LightPathSet;

// Draws the set of the first pass of a group of one eye, whose film has this many pixels; all emitters are connected. It must stay where
// it is.
void draw_light_path_set( const RfScene* scene, int width, int height, LightPathSet* set );

void free_light_path_set( LightPathSet* set );

#endif
