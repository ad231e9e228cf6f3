// What moves and changes in a scene, and how its light is shared, as JSON and in words.
#ifndef REFRAME_CLI_RENDER_CHANGES_JSON_H
#define REFRAME_CLI_RENDER_CHANGES_JSON_H

#include "cli/options/render_options.h"

#include <jansson.h>

// Sets "moving" and "changing" of `to`, and "sharing": null without a tracer. `options` say which path,
// with settings that are resolved.
RfResult rf_add_changes( const RfScene* scene, const RfTracer* tracer, const RfRenderOptions* options, json_t* to,
                         RfError* error );

#define RF_CHANGE_TEXT 400

// "intensity, colour; scaled in 12 of 48 frames, else shared; 3 % of the light"
void rf_format_change( const json_t* change, const json_t* sharing, char text[RF_CHANGE_TEXT] );

// "in groups of 7 frames 54 % of the light is shared, 12 % scaled, 34 % own-frame"; nothing where it is not known.
void rf_format_sharing( const json_t* sharing, char text[RF_CHANGE_TEXT] );

#endif
