// The two chunks of a .glb file: the JSON document, and the byte ranges of the
// binary buffer, one per buffer view and in their order. Internal to glb_write.c.
#ifndef REFRAME_CONVERT_GLB_DOCUMENT_H
#define REFRAME_CONVERT_GLB_DOCUMENT_H

#include "convert/model.h"

#include <jansson.h>

// A byte range inside the model, not a copy.
typedef struct RfGlbPart
{
    const void* bytes;
    uint64_t size;
} RfGlbPart;

typedef struct RfGlbDocument
{
    const RfModel* model;
    json_t* root;
    json_t *accessors, *views, *meshes; // borrowed from root
    RfGlbPart* parts;                   // one per buffer view, each aligned to 4 bytes
    int part_count;
    uint64_t size;    // of the buffer, padded
    int* lone_meshes; // per model mesh: the glTF mesh that holds only this one, or −1
    bool failed;      // out of memory
} RfGlbDocument;

// Rejects a model that glTF cannot represent; the message names the part.
RfResult rf_check_model( const RfModel* model, RfError* error );

// Builds both chunks; rf_destroy_glb_document frees them, also after a failure.
RfResult rf_make_glb_document( const RfModel* model, RfGlbDocument* document, RfError* error );

// Frees the document.
void rf_destroy_glb_document( RfGlbDocument* document );

// Pieces of JSON (glb_json.c). Sets a key of an object; a failed allocation sets `failed`.
void rf_glb_set( RfGlbDocument* document, json_t* object, const char* key, json_t* value );

// Appends to an array; a failed allocation sets `failed`.
void rf_glb_append( RfGlbDocument* document, json_t* array, json_t* value );

// An array of numbers; NULL if memory runs out.
json_t* rf_glb_reals( const float* values, int count );

// A string; bytes that are not valid UTF-8 become '?'.
json_t* rf_glb_name( const char* name );

// An entry of "materials".
json_t* rf_glb_material( RfGlbDocument* document, const RfModelMaterial* material );

// The names of the extensions that the model uses, as an array; NULL if none.
json_t* rf_glb_extensions( RfGlbDocument* document );

#endif
