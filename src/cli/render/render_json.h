// The result of a render as JSON.
#ifndef REFRAME_CLI_RENDER_RENDER_JSON_H
#define REFRAME_CLI_RENDER_RENDER_JSON_H

#include "cli/options/render_options.h"
#include "cli/render/render_command.h"
#include "reframe/render.h"
#include "reframe/scene.h"

#include <jansson.h>

// One element of "frames", with the names of the scene's materials; with a noise or a flicker in the settings also whether it was reached. `same_as` is the
// frame of this run whose picture it repeats, from 0; else −1. NULL where memory ran out.
json_t* rf_frame_json( const RfFrameResult* result, const RfScene* scene, const RfCameraPath* path,
                       const RfRenderSettings* settings, int same_as );

// The complete JSON of a render with these frames, which it takes over. NULL where memory ran out.
struct RfRenderJob;
json_t* rf_render_json( const struct RfRenderJob* job, json_t* frames, bool interrupted );

// All effects with name, on, why, left_out, forced, and the option that decides (null: none).
json_t* rf_effects_json( const RfScene* scene, const RfRenderSettings* settings );

// Sets "moving" and "changing" of `to`, and "sharing": null without a tracer. `options` say which path,
// with settings that are resolved.
RfResult rf_add_changes( const RfScene* scene, const RfTracer* tracer, const RfRenderOptions* options, json_t* to,
                         RfError* error );

#define RF_CHANGE_TEXT 400

// "intensity, colour; scaled in 12 of 48 frames, else shared; 3 % of the light"
void rf_format_change( const json_t* change, const json_t* sharing, char text[RF_CHANGE_TEXT] );

// "in groups of 7 frames 54 % of the light is shared, 12 % scaled, 34 % own-frame"; nothing where it is not known.
void rf_format_sharing( const json_t* sharing, char text[RF_CHANGE_TEXT] );

// The specks of a frame: pixels, share, rest_relmse, rest_noise_percent, kinds, materials. NULL where memory ran out.
json_t* rf_specks_json( const RfSpecks* specks, const RfScene* scene );

// The same of all frames in the array "frames" of a render's JSON that have it, with their number in "frames"; NULL where none has.
json_t* rf_sum_specks( const json_t* frames );

// Share of the error from which specks are worth a sentence.
#define RF_SPECKS_STAND_OUT 0.3

// "10 specks hold 99 % of the error, mostly on 'steel' (glints); the rest has about 15 % noise (relMSE 0.0675)", of what
// rf_sum_specks returns. False where they carry less.
bool rf_format_specks( const json_t* sum, char* text, size_t size );

// What helps against specks: options, to be put behind rf_format_specks; NULL: nothing that is not on already.
const char* rf_speck_advice( const json_t* sum, const RfRenderSettings* settings );

// Adds "clipped_pixels" of the file of frame `number`, as its header says, and if there are any "clipped_layers".
void rf_add_clipped( const char* pattern, int number, json_t* row );

// Warns of them, in the frames that were rendered and those that were kept.
void rf_warn_of_clipped( RfRenderJob* job );

// Loads the JSON of `render` from a file that must hold it and replaces *json. `option` begins the error line.
RfResult rf_load_render_json( const char* path, const char* option, json_t** json, RfError* error );

// Loads the first in a folder, by name; *json stays NULL where there is none. Files that are something else are ignored.
RfResult rf_find_render_json( const char* folder, json_t** json, RfError* error );

#endif
