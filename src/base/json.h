// Reads JSON: our own files (scene files, camera paths), our objects inside glTF, and glTF itself. The reader is strict, and it
// keeps the first error: where something has failed, all that follows leaves its values as they are and returns that failure, so
// that a sequence of reads is checked once, at its end. A missing value leaves what it would be read into unchanged. Every error
// is one line with the JSON path of the value, such as `materials.vase.exponent: must be a number >= 0, got "high"`.
#ifndef REFRAME_BASE_JSON_H
#define REFRAME_BASE_JSON_H

#include "reframe/error.h"

#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

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

// Parses a text that must be an object; duplicate keys, NaN, numbers that overflow and invalid
// UTF-8 are errors. Fails with RF_ERROR_FORMAT; the message begins with `path`. A syntax error
// gives line and column and ends with `advice`; a document that is not an object is described
// after `where` ("document: " or "").
RfResult rf_parse_json( const char* path, const void* text, size_t size, const char* advice, const char* where, json_t** root,
                        RfError* error );

// Resolves a file name found in `file`: `name` itself if absolute, else relative to the folder
// of `file`. The caller frees it; NULL if out of memory.
char* rf_path_beside( const char* file, const char* name );

const char* rf_json_kind( const json_t* value );

// A JSON string of any bytes: text that is not UTF-8 (file names may be anything) has '?' for what is not ASCII.
json_t* rf_json_text( const char* text );

// An integer in either notation: 3 and 3.0 are the same in JSON, though the parser
// distinguishes them. False if the value is not an integer or too large to be exact.
bool rf_json_integer( const json_t* value, int64_t* whole );

// Where the first error of a reading is kept: `error` or, where the caller has none, one that nobody sees. It is cleared.
RfError* rf_begin_reading( RfError* error );

// A value and its position in the document. Everything it points to must outlive it.
typedef struct RfField
{
    const char* file;
    RfError* error;     // of rf_begin_reading
    const json_t* json; // NULL: missing
    bool notes;         // the object may have "$schema" and "about", a comment
    bool gltf;          // its errors are violations of glTF's specification: RF_ERROR_FORMAT
    int owner;          // bytes of `path` that are of the object or array that has it
    char path[200];     // "keys[3].position"; "" is the whole document
} RfField;

// The root object, which may have notes. A reading begins.
RfField rf_root_field( const RfJsonDocument* document, RfError* error );
RfField rf_make_field( const char* file, const char* path, const json_t* json, RfError* error );

// A member of an object; its json is NULL if it is missing.
RfField rf_field_member( const RfField* object, const char* key );
RfField rf_field_item( const RfField* array, size_t index );

static inline bool rf_has_member( const RfField* object, const char* key )
{
    return json_object_get( object->json, key ) != NULL;
}

static inline RfResult rf_json_result( const RfField* field ) { return field->error->code; }

// Fails with RF_ERROR_SCENE, or RF_ERROR_FORMAT for glTF; the message is prefixed with the file and the path.
RfResult rf_field_fail( const RfField* field, const char* format, ... ) __attribute__( ( format( printf, 2, 3 ) ) );

// Fails for what a file that this one names is at fault, naming both.
RfResult rf_field_fail_as( const RfField* field, RfResult result, const RfError* error );
RfResult rf_field_no_memory( const RfField* field );

// Fails with "must be …, got …" or "is missing: must be …".
RfResult rf_field_must_be( const RfField* field, const char* want );

// Fails unless the field is an object whose keys are all in the list, which ends with NULL.
RfResult rf_field_keys( const RfField* object, const char* const* keys );

// Fails if the member is missing; `want` describes the expected value, except of glTF.
RfResult rf_field_require( const RfField* object, const char* key, const char* want );

typedef struct RfRange
{
    double low, high;
    bool open; // `low` itself is excluded
} RfRange;

static inline RfRange rf_range( double low, double high ) { return ( RfRange ){ low, high, false }; }

static inline RfRange rf_above( double low, double high ) { return ( RfRange ){ low, high, true }; }

static inline RfRange rf_any_number( void ) { return ( RfRange ){ -HUGE_VAL, HUGE_VAL, false }; }

// What is at most 1e-4 beyond a limit is at it, as programs write numbers of glTF with few digits.
double rf_round_into( RfRange range, double number );

// Fails for a number that is not in a range.
RfResult rf_field_check( const RfField* field, RfRange range, double value );

// Each kind of value is read from a field, or from the member of an object. A wrong type or a value out of range is an error.
RfResult rf_field_number( const RfField* field, RfRange range, double* value );
RfResult rf_get_number( const RfField* object, const char* key, RfRange range, double* value );

// An array of `count` numbers.
RfResult rf_field_numbers( const RfField* field, RfRange range, int count, double* values );
RfResult rf_get_numbers( const RfField* object, const char* key, RfRange range, int count, double* values );

// A whole number.
RfResult rf_field_whole( const RfField* field, double low, double high, int* value );
RfResult rf_get_whole( const RfField* object, const char* key, double low, double high, int* value );
RfResult rf_get_integer( const RfField* object, const char* key, int64_t low, int64_t high, int64_t* value );

RfResult rf_field_bool( const RfField* field, bool* value );
RfResult rf_get_bool( const RfField* object, const char* key, bool* value );

// A string, which the document owns; it must not be empty, except in glTF.
RfResult rf_field_text( const RfField* field, const char** text );
RfResult rf_get_text( const RfField* object, const char* key, const char** text );

// The index of a word in `words`, which ends with NULL.
RfResult rf_field_choice( const RfField* field, const char* const* words, int* index );
RfResult rf_get_choice( const RfField* object, const char* key, const char* const* words, int* index );

// Checks for an array of `least` to `most` items.
RfResult rf_field_array( const RfField* field, const char* item, size_t least, size_t most );

// A member that is an object or an array of any length; without json where it is missing or something else.
RfField rf_get_object( const RfField* object, const char* key );
RfField rf_get_array( const RfField* object, const char* key );

#endif
