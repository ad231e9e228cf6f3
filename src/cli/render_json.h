// The machine-readable result of a render, keys as in the documentation.
#ifndef REFRAME_CLI_RENDER_JSON_H
#define REFRAME_CLI_RENDER_JSON_H

#include "cli/render_options.h"
#include "scene/scene.h"

#include <jansson.h>

// One element of "frames"; with `noise`, the relMSE wanted, also whether it was
// reached. NULL where memory ran out.
json_t* rf_frame_json( const RfFrameResult* result, double noise );

// The whole; takes over `frames`. NULL where memory ran out.
json_t* rf_render_json( const RfRenderOptions* options, const RfScene* scene, const RfRenderStats* stats,
                        double seconds, double seconds_scene, json_t* frames );

// The effects of a scene that are on, by name; or all with name, on and why.
json_t* rf_effect_names_json( const RfScene* scene );
json_t* rf_effects_json( const RfScene* scene );

#endif
