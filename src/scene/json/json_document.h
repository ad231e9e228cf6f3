// Reading of our own JSON files (scene files, camera paths) and of our objects
// inside glTF: nothing is guessed, and every fault is one line with the JSON
// path of the value: `materials.vase.exponent: wants a number >= 0, got "high"`.
#ifndef REFRAME_SCENE_JSON_JSON_DOCUMENT_H
#define REFRAME_SCENE_JSON_JSON_DOCUMENT_H

#include "reframe/error.h"

#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct RfJsonDocument
{
    char* path;    // of the file
    json_t* root;  // an object
    uint64_t hash; // of the file's bytes
} RfJsonDocument;

// Reads and parses a file. On failure the document is empty.
RfResult rf_open_json( const char* path, RfJsonDocument* document, RfError* error );
void rf_close_json( RfJsonDocument* document );

// A file that another one names: `name` itself where it is absolute, else
// beside `file`. To be freed; NULL where there is no memory.
char* rf_path_beside( const char* file, const char* name );

// A value and where it stands. What is pointed to must outlive it.
typedef struct RfField
{
    const char* file;
    RfError* error;
    const json_t* json; // NULL: it is not there
    bool notes;         // "$schema" and "about", a text for people, may stand in it
    char path[208];     // "keys[3].position"; "" is the whole document
} RfField;

RfField rf_root_field( const RfJsonDocument* document, RfError* error ); // may have notes
// A field that stands elsewhere: `path` is for the error lines.
RfField rf_make_field( const char* file, const char* path, const json_t* json, RfError* error );
RfField rf_field_member( const RfField* object, const char* key );
RfField rf_field_item( const RfField* array, size_t index );
static inline bool rf_has_member( const RfField* object, const char* key )
{
    return json_object_get( object->json, key ) != NULL;
}

// Writes the line, with file and path in front; RF_ERROR_SCENE.
RfResult rf_field_fail( const RfField* field, const char* format, ... ) __attribute__( ( format( printf, 2, 3 ) ) );
// "wants …, got …", or "is missing: wants …".
RfResult rf_field_wants( const RfField* field, const char* want );

// Fails unless the field is an object all of whose keys are in the list, which
// ends with NULL.
RfResult rf_field_keys( const RfField* object, const char* const* keys );
// Fails where the member is not there; `want` says what it should be.
RfResult rf_field_require( const RfField* object, const char* key, const char* want );

typedef struct RfRange
{
    double low, high;
    bool open; // `low` itself is out
} RfRange;

static inline RfRange rf_range( double low, double high ) { return ( RfRange ){ low, high, false }; }
static inline RfRange rf_at_least( double low ) { return ( RfRange ){ low, (double)INFINITY, false }; }
static inline RfRange rf_above( double low, double high ) { return ( RfRange ){ low, high, true }; }

// Values by type. One that is not there is left as the caller set it; one of
// another type or out of range is an error.
RfResult rf_field_number( const RfField* field, RfRange range, double* value );
RfResult rf_field_numbers( const RfField* field, RfRange range, int count, double* values );
RfResult rf_field_bool( const RfField* field, bool* value );
RfResult rf_field_text( const RfField* field, const char** text ); // never empty
// Index into `words`, which ends with NULL.
RfResult rf_field_choice( const RfField* field, const char* const* words, int* index );
// An array of at least `least` and at most `most` items.
RfResult rf_field_array( const RfField* field, const char* item, size_t least, size_t most );

#endif
