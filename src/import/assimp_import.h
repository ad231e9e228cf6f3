// Reading by assimp into our model: for OBJ, FBX and Collada, and for whatever
// else assimp reads. Runs in a process with limits: assimp may crash, hang or
// eat all memory on broken files.
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
    RfSourceFormat format; // by the name's ending
    const struct aiScene* scene;
    RfModel* model; // filled
    RfLog* log;
    int* meshes;                 // per mesh of assimp: that of the model, or −1
    char ( *image_names )[1024]; // of the images taken so far, as the file names them
    int image_room;
} RfImport;

// The whole. Error lines do not name the file: the caller does.
RfResult rf_import_by_assimp( const char* path, RfModel* model, RfLog* log, RfError* error );

// Its parts. Each fails by RF_ERROR_MEMORY only.
RfResult rf_import_materials( RfImport* import, RfError* error );
RfResult rf_import_meshes( RfImport* import, RfError* error );
RfResult rf_import_nodes( RfImport* import, RfError* error );

// The image of a texture's name (a path, or "*0" for one inside the file), taken
// into the model once; −1, with a warning, where it is not to be had.
int rf_import_image( RfImport* import, const char* name );

// Cameras and lights, each on a node of its own under the node of its name.
void rf_import_cameras( RfImport* import );
void rf_import_lights( RfImport* import );

// A copy to be freed; NULL for an empty string.
char* rf_import_text( const struct aiString* text );

// One more node, index −1 where memory ran out.
int rf_import_add_node( RfImport* import, const struct aiString* name, int parent, const RfMat4* matrix );

#define RF_IMPORT_MEMORY "out of memory for what is in the file"

#endif
