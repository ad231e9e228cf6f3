// What every reader of JSON files shares: parsing with errors by line and
// column, and values in words.
#ifndef REFRAME_SCENE_JSON_JSON_VALUE_H
#define REFRAME_SCENE_JSON_JSON_VALUE_H

#include "reframe/error.h"

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Parses a whole text, which must be an object; duplicate keys, NaN, numbers
// that overflow and broken UTF-8 are errors. Fails with RF_ERROR_FORMAT, naming
// `path`: where it cannot be parsed with line and column, and what to do by
// `advice`; where it can and is no object with what it is, and
// `where` ("document: " or nothing) before it.
RfResult rf_parse_json( const char* path, const void* text, size_t size, const char* advice, const char* where, json_t** root,
                        RfError* error );

// "an object", "a string", "an integer" and so on.
const char* rf_json_kind( const json_t* value );

// The value itself where it is short enough to be read in a line, else its kind.
void rf_describe_json( const json_t* json, char* text, size_t size );

// A whole number, however it is written: JSON does not tell 3 from 3.0, though
// the parser does. False where the value is none, or too large to be exact.
bool rf_json_whole( const json_t* value, int64_t* whole );

#endif
