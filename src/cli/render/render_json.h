// The result of a render as JSON.
#ifndef REFRAME_CLI_RENDER_RENDER_JSON_H
#define REFRAME_CLI_RENDER_RENDER_JSON_H

#include "cli/options/render_options.h"
#include "reframe/scene.h"

#include <jansson.h>

// One element of "frames", with the names of the scene's materials; with a noise or a flicker in the settings also whether it was reached. `same_as` is the
// frame of this run whose picture it repeats, from 0; else −1. NULL where memory ran out.
json_t* rf_frame_json( const RfFrameResult* result, const RfScene* scene, const RfCameraPath* path,
                       const RfRenderSettings* settings, int same_as );

// What one run of `render` did.
typedef struct RfRenderRun
{
    const RfRenderStats* stats;
    double seconds, seconds_scene; // in all; until the scene was loaded
    json_t* frames;                // taken over by rf_render_json
    int kept;                      // of them, from before
    int repeated;                  // of them, the picture of the frame before them once more
    double beyond_depth;           // share of the light
    bool interrupted;
    json_t* warnings; // lines; stays the caller's
    const RfEffect* effects;
    int effect_count;
} RfRenderRun;

// The complete JSON. NULL where memory ran out.
json_t* rf_render_json( const RfRenderOptions* options, const RfRenderRun* run );

// All effects with name, on, why, left_out, forced, and the option that decides (null: none).
json_t* rf_effects_json( const RfScene* scene, const RfRenderSettings* settings );

#endif
