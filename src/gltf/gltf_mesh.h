// From the meshes of a glTF document to the triangles of the scene. Internal to the reader.
#ifndef REFRAME_GLTF_GLTF_MESH_H
#define REFRAME_GLTF_GLTF_MESH_H

#include "scene/deformation.h"
#include "gltf/gltf_document.h"
#include "scene/movement.h"

// The triangles of a primitive in object space, with only the vertices that they use
// (gltf_primitive.c).
typedef struct RfGltfPrimitive
{
    RfTriangles t;     // count 0: nothing to draw
    uint32_t* sources; // per vertex: its number in the accessors
    bool flat;         // the normals are those of the triangles, which share no vertices
    uint32_t material;
} RfGltfPrimitive;

// Reads a primitive; to survey it, the number of its triangles and its material alone.
RfResult rf_gltf_read_primitive( RfGltf* gltf, const RfField* primitive, bool survey, RfGltfPrimitive* out );

// Frees a primitive.
void rf_gltf_free_primitive( RfGltfPrimitive* primitive );

// Of all that is baked.
#define RF_GLTF_MAX_TRIANGLES ( 1u << 28 )

// Bakes primitives into a list of triangles (gltf_bake.c).
typedef struct RfGltfBaker
{
    RfTriangles* triangles;
    RfVec3 bounds_min, bounds_max; // of the triangles; both 0 if there are none
    double least_double_area;      // twice the smallest triangle area that is kept
    uint32_t vertex_capacity, triangle_capacity;
    bool deforms;    // triangles without area stay
    uint32_t placed; // triangles so far, including dropped ones
    uint64_t degenerate;
    RfWhere first_degenerate;
} RfGltfBaker;

// Appends a primitive, transformed by a matrix; NULL: in its own space.
RfResult rf_gltf_bake( RfGltf* gltf, RfGltfBaker* baker, const RfGltfPrimitive* primitive, const RfMat4* matrix,
                       const char* where );

// Frees spare memory of the triangles.
void rf_gltf_finish_baker( RfGltfBaker* baker );

// Says how many triangles were dropped, if any.
void rf_gltf_warn_of_degenerate( const RfGltf* gltf, const RfGltfBaker* baker );

// The instances of a node's mesh and their transforms within the node; a single one without
// the extension (gltf_node.c).
typedef struct RfGltfInstances
{
    uint32_t count;
    int translation, rotation, scale; // accessors, or −1
} RfGltfInstances;

// Reads the instances of a node.
RfResult rf_gltf_open_instances( RfGltf* gltf, int node, RfGltfInstances* out );

// The transform of one instance within its node.
RfResult rf_gltf_instance_matrix( const RfGltf* gltf, const RfGltfInstances* instances, uint32_t element, RfMat4* matrix );

// The number of morph targets of all primitives of a mesh (gltf_bake.c).
RfResult rf_gltf_mesh_targets( const RfGltf* gltf, int mesh, int* count );

// The weights of a node's mesh where nothing animates them.
RfResult rf_gltf_read_rest_weights( const RfGltf* gltf, int node, int mesh, int count, double* weights );

// Reads the skins, with nodes of the scene for joints (gltf_bake.c).
RfResult rf_gltf_load_skins( RfGltf* gltf, RfMovement* movement );

// A mesh in its own space, of all primitives, or of those with materials that change. `deforms`: with its morph targets and all triangles; `skinned`: with its
// joints as well; else without the triangles that have no area (gltf_bake.c).
typedef struct RfGltfShape
{
    int use; // of a mesh
    bool deforms, skinned, changing_only;
} RfGltfShape;

RfResult rf_gltf_read_shape( RfGltf* gltf, const RfGltfShape* shape, RfMesh* out );

// Takes the mesh of a node out of those that stand still, where it moves, deforms or is hidden. Where only
// some of its materials change, its primitives with these are to be left out (gltf_mover.c).
RfResult rf_gltf_set_apart( RfGltf* gltf, int node );

// Places what was set apart, after everything else.
RfResult rf_gltf_place_movers( RfGltf* gltf );

#endif
