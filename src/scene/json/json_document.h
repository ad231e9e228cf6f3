// Reads our own JSON files (scene files, camera paths) and our objects inside glTF. The reader
// is strict: every error is one line with the JSON path of the value, such as
// `materials.vase.exponent: must be a number >= 0, got "high"`. The glTF reader shares the parser, which gives line and
// column in errors, and the description of values in messages.
#ifndef REFRAME_SCENE_JSON_JSON_DOCUMENT_H
#define REFRAME_SCENE_JSON_JSON_DOCUMENT_H

#include "reframe/error.h"

#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stddef.h>

typedef struct RfJsonDocument
{
    char* path;    // of the file
    json_t* root;  // an object
    uint64_t hash; // of the file's bytes
} RfJsonDocument;

// Reads and parses a file. On failure the document is empty.
RfResult rf_open_json( const char* path, RfJsonDocument* document, RfError* error );

// Frees a document and clears it.
void rf_close_json( RfJsonDocument* document );

// Resolves a file name found in `file`: `name` itself if absolute, else relative to the folder
// of `file`. The caller frees it; NULL if out of memory.
char* rf_path_beside( const char* file, const char* name );

// A value and its position in the document. Everything it points to must outlive it.
typedef struct RfField
{
    const char* file;
    RfError* error;
    const json_t* json; // NULL: missing
    bool notes;         // the object may have "$schema" and "about", a comment
    char path[208];     // "keys[3].position"; "" is the whole document
} RfField;

// The root object, which may have notes.
RfField rf_root_field( const RfJsonDocument* document, RfError* error );

// A field of another document: `path` is for messages.
RfField rf_make_field( const char* file, const char* path, const json_t* json, RfError* error );

// A member of an object; its json is NULL if it is missing.
RfField rf_field_member( const RfField* object, const char* key );

// An item of an array.
RfField rf_field_item( const RfField* array, size_t index );

static inline bool rf_has_member( const RfField* object, const char* key )
{
    return json_object_get( object->json, key ) != NULL;
}

// Fails with RF_ERROR_SCENE; the message is prefixed with the file and the path.
RfResult rf_field_fail( const RfField* field, const char* format, ... ) __attribute__( ( format( printf, 2, 3 ) ) );

// Fails with "must be …, got …" or "is missing: must be …".
RfResult rf_field_must_be( const RfField* field, const char* want );

// Fails unless the field is an object whose keys are all in the list, which ends with NULL.
RfResult rf_field_keys( const RfField* object, const char* const* keys );

// Fails if the member is missing; `want` describes the expected value.
RfResult rf_field_require( const RfField* object, const char* key, const char* want );

typedef struct RfRange
{
    double low, high;
    bool open; // `low` itself is excluded
} RfRange;

static inline RfRange rf_range( double low, double high ) { return ( RfRange ){ low, high, false }; }

static inline RfRange rf_above( double low, double high ) { return ( RfRange ){ low, high, true }; }

// Reads a number. A missing value leaves `value` unchanged; a wrong type or a value out of
// range is an error. The same holds for the types below.
RfResult rf_field_number( const RfField* field, RfRange range, double* value );

// Reads an array of `count` numbers.
RfResult rf_field_numbers( const RfField* field, RfRange range, int count, double* values );

// Reads a boolean.
RfResult rf_field_bool( const RfField* field, bool* value );

// Reads a string that must not be empty.
RfResult rf_field_text( const RfField* field, const char** text );

// Reads the member "light_group" of an object, the name of a light group (scene/light_groups.h); NULL: there is none.
RfResult rf_field_light_group( const RfField* object, const char** name );

// Reads the index of a word in `words`, which ends with NULL.
RfResult rf_field_choice( const RfField* field, const char* const* words, int* index );

// Checks for an array of `least` to `most` items.
RfResult rf_field_array( const RfField* field, const char* item, size_t least, size_t most );

// Parses a text that must be an object; duplicate keys, NaN, numbers that overflow and invalid
// UTF-8 are errors. Fails with RF_ERROR_FORMAT; the message begins with `path`. A syntax error
// gives line and column and ends with `advice`; a document that is not an object is described
// after `where` ("document: " or "").
RfResult rf_parse_json( const char* path, const void* text, size_t size, const char* advice, const char* where, json_t** root,
                        RfError* error );

// "an object", "a string", "an integer" and so on.
const char* rf_json_kind( const json_t* value );

// An integer in either notation: 3 and 3.0 are the same in JSON, though the parser
// distinguishes them. False if the value is not an integer or too large to be exact.
bool rf_json_integer( const json_t* value, int64_t* whole );

#endif
