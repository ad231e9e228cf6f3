// Imports files by assimp into our model: OBJ, FBX, Collada and whatever else assimp reads.
// Runs in a process with resource limits: on broken files assimp may crash, hang or run out of
// memory.
#ifndef REFRAME_IMPORT_ASSIMP_IMPORT_H
#define REFRAME_IMPORT_ASSIMP_IMPORT_H

#include "convert/model.h"
#include "convert/polygon.h"

#include <assimp/scene.h>

typedef enum RfSourceFormat
{
    RF_SOURCE_OBJ,
    RF_SOURCE_PLY,
    RF_SOURCE_COLLADA,
    RF_SOURCE_FBX,
    RF_SOURCE_OTHER,
} RfSourceFormat;

typedef enum RfFactKind
{
    RF_FACT_CAMERA, // of a node: RF_CAMERA_…
    RF_FACT_AREA,   // of a node: width and height of its area light
    RF_FACT_WEIGHT, // of a morph target; of Collada under the mesh, whether it is relative to that, and its own mesh
    RF_FACT_KEY,    // of an animation of a Collada weight: seconds, weight
    RF_FACT_BIND,   // of an FBX mesh and a bone: the inverse bind matrix, column-major
    RF_FACT_JOINT,  // a node that is one
    RF_FACT_HIDDEN, // a node that is, with those below it
    RF_FACT_FAR,    // of a mesh far from its origin: what is taken off; of FBX its corners without it, floats in `text`
    RF_FACT_NAME,   // `text` is what this name was in the file
    RF_FACT_MAP,    // of a material: scale, offset, whether it is clamped; slot: 0 base colour, 1 normal, 2 emission
} RfFactKind;

enum
{
    RF_CAMERA_ORTHOGRAPHIC, // 1 or 0
    RF_CAMERA_XMAG,         // half the size, in units of the file; the following: degrees; 0 where not given
    RF_CAMERA_YMAG,
    RF_CAMERA_XFOV,
    RF_CAMERA_YFOV,
    RF_CAMERA_ASPECT,
    RF_FACT_VALUES = 16,
};

// What a file says and assimp does not pass on.
typedef struct RfFact
{
    RfFactKind kind;
    int slot;
    char* name;
    char* text;
    double values[RF_FACT_VALUES];
} RfFact;

// The file as assimp gets to see it.
typedef struct RfSource
{
    const char* path;
    RfSourceFormat format; // by the file extension
    char* text;            // zero-terminated
    size_t size;
    double origin[3];   // taken off the positions
    double unit;        // metres in which the file counts, as far as assimp leaves that to us
    bool binds_at_rest; // Blender's Collada, whose bind shapes are relative to the armature: inverse bind matrices are left out
    RfFact* facts;
    int fact_count;
    RfLog* log;
    bool failed; // out of memory
} RfSource;

// A node with a mesh that has a skin or morph targets.
typedef struct RfPosed
{
    const struct aiNode* from;
    const struct aiMesh* mesh;
    int node;
} RfPosed;

typedef struct RfImport
{
    RfSource* source;
    const struct aiScene* scene;
    RfModel* model; // the result
    RfLog* log;
    int* meshes;                 // per assimp mesh: the index of the model mesh, or −1
    double ( *origins )[3];      // per model mesh: what was taken off its positions, metres
    char ( *image_names )[1024]; // of the images read so far, as in the file
    int image_room;
    RfCutter cutter;
    int hidden;              // nodes with meshes that are
    const char* hidden_name; // of one of them
    bool up_of_file;         // FBX: its axes are turned to y up, as it says
    bool turned_again;       // z is turned to y afterwards
    bool accepts_losses;     // of images; else import_by_assimp fails with all of them
    char lost[880];          // those that cannot be read, and why; as many as fit
    RfPosed* posed;
    int posed_count;
} RfImport;

// To 0 to 1; NaN to 0.
static inline float rf_clamp01( float value ) { return value > 0.0f ? value < 1.0f ? value : 1.0f : 0.0f; }

// Reads the file and what assimp would lose of it. rf_close_source frees all, also after a failure.
RfResult rf_open_source( const char* path, RfSource* source, RfLog* log, RfError* error );
void rf_close_source( RfSource* source );

// Finds in an FBX or Collada file, or in a material library, what is noted; FBX names become unique in `text`.
void rf_note_fbx( RfSource* source );
void rf_note_collada( RfSource* source );
void rf_note_mtl( RfSource* source, const char* text );

// Whether positions lie so far out, for their extent, that assimp's floats round them: the middle of their box, in whole units.
bool rf_is_far( const double low[3], const double high[3], double origin[3] );

RfFact* rf_add_fact( RfSource* source, RfFactKind kind, const char* name, size_t length );
const RfFact* rf_find_fact( const RfSource* source, RfFactKind kind, const char* name, int slot );

// A name as it is in the file.
const char* rf_name_in_file( const RfSource* source, const char* name );

// What assimp reads: the text of the source, and files beside it.
const struct aiScene* rf_read_source( RfSource* source, unsigned steps );

// Imports the materials. Fails only with RF_ERROR_MEMORY, like the following.
RfResult rf_import_materials( RfImport* import, RfError* error );

RfResult rf_import_meshes( RfImport* import, RfError* error );
RfResult rf_import_nodes( RfImport* import, RfError* error );
void rf_import_cameras( RfImport* import );
void rf_import_lights( RfImport* import );

// Skin and morph targets of a mesh, whose joints are numbers of bones until the nodes are there; false: out of memory.
bool rf_take_pose( RfImport* import, const struct aiMesh* from, RfModelMesh* mesh );
RfResult rf_import_skins( RfImport* import, RfError* error );
RfResult rf_import_animations( RfImport* import, RfError* error );

// Makes equal vertices one and drops those of no triangle; false: out of memory.
bool rf_join_vertices( RfModelMesh* mesh );

// Gives morph targets without normals those of their shapes, as Blender's FBX files need it; false: out of memory.
bool rf_turn_normals( RfModelMesh* mesh );

// Adds a node; −1: out of memory.
int rf_import_node( RfImport* import, const char* name, int parent, const RfMat4* matrix );
int rf_find_import_node( const RfImport* import, const char* name );
RfMat4 rf_import_matrix( const RfImport* import, const struct aiMatrix4x4* from );

// A copy that the caller frees; NULL for an empty string.
char* rf_import_text( const struct aiString* text );

// Nodes for assimp to read the meshes of Collada's morph targets.
#define RF_TARGET_NODE "reframe-target-"

#define RF_IMPORT_MEMORY "out of memory for what is in the file"

#endif
