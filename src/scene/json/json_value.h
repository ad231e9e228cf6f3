// Shared by all readers of JSON files: parsing, with line and column in errors, and describing
// values in messages.
#ifndef REFRAME_SCENE_JSON_JSON_VALUE_H
#define REFRAME_SCENE_JSON_JSON_VALUE_H

#include "reframe/error.h"

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Parses a text that must be an object; duplicate keys, NaN, numbers that overflow and invalid
// UTF-8 are errors. Fails with RF_ERROR_FORMAT; the message begins with `path`. A syntax error
// gives line and column and ends with `advice`; a document that is not an object is described
// after `where` ("document: " or "").
RfResult rf_parse_json( const char* path, const void* text, size_t size, const char* advice, const char* where, json_t** root,
                        RfError* error );

// "an object", "a string", "an integer" and so on.
const char* rf_json_kind( const json_t* value );

// The value itself if it is short enough for one line, else its kind.
void rf_describe_json( const json_t* json, char* text, size_t size );

// An integer in either notation: 3 and 3.0 are the same in JSON, though the parser
// distinguishes them. False if the value is not an integer or too large to be exact.
bool rf_json_integer( const json_t* value, int64_t* whole );

#endif
