// Where the error of rendered frames is, as JSON and in words.
#ifndef REFRAME_CLI_RENDER_SPECKS_JSON_H
#define REFRAME_CLI_RENDER_SPECKS_JSON_H

#include "reframe/render.h"

#include <jansson.h>
#include <stdbool.h>

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

#endif
