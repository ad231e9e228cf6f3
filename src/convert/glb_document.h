// The two halves of a .glb made from a model: the JSON, and the list of byte
// ranges that its buffer views refer to, in their order. For glb_write.c.
#ifndef REFRAME_CONVERT_GLB_DOCUMENT_H
#define REFRAME_CONVERT_GLB_DOCUMENT_H

#include "convert/model.h"

#include <jansson.h>

// Bytes of the model itself, not copies.
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
    RfGlbPart* parts;                   // one per buffer view; each starts at a multiple of 4
    int part_count;
    uint64_t size;    // of the buffer, padded
    int* lone_meshes; // per model mesh: the glTF mesh that is it alone, or −1
    bool failed;      // memory ran out on the way
} RfGlbDocument;

// Refuses what glTF cannot say, naming the part.
RfResult rf_check_model( const RfModel* model, RfError* error );

// Both halves; rf_destroy_glb_document frees them, also after a failure.
RfResult rf_make_glb_document( const RfModel* model, RfGlbDocument* document, RfError* error );
void rf_destroy_glb_document( RfGlbDocument* document );

// Helpers of the two sources: every failure to allocate ends up in `failed`.
void rf_glb_set( RfGlbDocument* document, json_t* object, const char* key, json_t* value );
void rf_glb_append( RfGlbDocument* document, json_t* array, json_t* value );
json_t* rf_glb_reals( const float* values, int count );
json_t* rf_glb_name( const char* name ); // any bytes: what is no UTF-8 becomes '?'

// "materials", and "textures" and "images" without their buffer views.
json_t* rf_glb_material( RfGlbDocument* document, const RfModelMaterial* material );

// The names of the extensions the model needs, in an array; NULL where none.
json_t* rf_glb_extensions( RfGlbDocument* document );

#endif
