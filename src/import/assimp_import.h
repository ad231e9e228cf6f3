// Imports files by assimp into our model: OBJ, FBX, Collada and whatever else assimp reads.
// Runs in a process with resource limits: on broken files assimp may crash, hang or run out of
// memory.
#ifndef REFRAME_IMPORT_ASSIMP_IMPORT_H
#define REFRAME_IMPORT_ASSIMP_IMPORT_H

#include "convert/model.h"

#include <assimp/scene.h>

typedef enum RfSourceFormat
{
    RF_SOURCE_OBJ,
    RF_SOURCE_PLY,
    RF_SOURCE_COLLADA,
    RF_SOURCE_FBX,
    RF_SOURCE_OTHER,
} RfSourceFormat;

typedef struct RfImport
{
    const char* path;
    RfSourceFormat format; // by the file extension
    const struct aiScene* scene;
    RfModel* model; // the result
    RfLog* log;
    int* meshes;                 // per assimp mesh: the index of the model mesh, or −1
    char ( *image_names )[1024]; // of the images read so far, as in the file
    int image_room;
    bool accepts_losses; // of images; else import_by_assimp fails with all of them
    char lost[880];      // those that cannot be read, and why; as many as fit
} RfImport;

// To 0 to 1; NaN to 0.
static inline float rf_clamp01( float value ) { return value > 0.0f ? value < 1.0f ? value : 1.0f : 0.0f; }

// Imports the materials. Fails only with RF_ERROR_MEMORY, like the following.
RfResult rf_import_materials( RfImport* import, RfError* error );

// A copy that the caller frees; NULL for an empty string.
char* rf_import_text( const struct aiString* text );

#define RF_IMPORT_MEMORY "out of memory for what is in the file"

#endif
