// From the meshes of a glTF document to the triangles of the scene. Internal to the reader.
#ifndef REFRAME_SCENE_GLTF_GLTF_GEOMETRY_H
#define REFRAME_SCENE_GLTF_GLTF_GEOMETRY_H

#include "scene/deformation.h"
#include "scene/gltf/gltf_document.h"
#include "scene/movement.h"

// The triangles of a primitive in object space, with only the vertices that they use
// (gltf_primitive.c).
typedef struct RfGltfPrimitive
{
    uint32_t vertex_count;
    uint32_t triangle_count; // 0: nothing to draw
    float* positions;
    float* normals; // NULL: flat shading
    float* uvs;     // or NULL, like the following
    float* uvs1;
    float* colors;   // 4 per vertex, in [0, 1]
    float* tangents; // 4 per vertex
    uint32_t* indices;
    uint32_t* sources; // per vertex: its number in the accessors
    bool flat;         // the normals are those of the triangles, which share no vertices
    uint32_t material;
} RfGltfPrimitive;

// Reads a primitive.
RfResult rf_gltf_read_primitive( RfGltf* gltf, const json_t* primitive, const char* where, RfGltfPrimitive* out );

// Gives each triangle vertices of its own with its normal, which is 0 where it has no area.
RfResult rf_gltf_make_flat( const RfGltf* gltf, const char* where, RfGltfPrimitive* primitive );

// Frees a primitive.
void rf_gltf_free_primitive( RfGltfPrimitive* primitive );

// Generates the tangents that a normal texture needs, for a primitive with normals and the
// texture's coordinates (gltf_tangents.c). Vertices shared by mirrored and unmirrored
// triangles are duplicated.
RfResult rf_gltf_make_tangents( const RfGltf* gltf, const char* where, const RfTextureRef* ref, RfGltfPrimitive* primitive );

// The instances of a node's mesh and their transforms within the node; a single one without
// the extension.
typedef struct RfGltfInstances
{
    uint32_t count;
    int translation, rotation, scale; // accessors, or −1
} RfGltfInstances;

// Reads the instances of a node (gltf_instancing.c).
RfResult rf_gltf_open_instances( RfGltf* gltf, int node, RfGltfInstances* out );

// The transform of one instance within its node.
RfResult rf_gltf_instance_matrix( const RfGltf* gltf, const RfGltfInstances* instances, uint32_t element, RfMat4* matrix );

// The number of morph targets of all primitives of a mesh (gltf_morph.c).
RfResult rf_gltf_mesh_targets( const RfGltf* gltf, int mesh, int* count );

// The weights of a node's mesh where nothing animates them.
RfResult rf_gltf_read_rest_weights( const RfGltf* gltf, int node, int mesh, int count, double* weights );

// Adds the targets of a primitive whose vertices begin at `base` of the mesh.
RfResult rf_gltf_read_targets( RfGltf* gltf, const json_t* json, const char* where, const RfGltfPrimitive* primitive,
                               uint32_t base, RfDeformation* deformation );

// Reads the skins, with nodes of the scene for joints (gltf_skin.c).
RfResult rf_gltf_load_skins( RfGltf* gltf, RfMovement* movement );

// Adds joints and weights of a primitive, likewise.
RfResult rf_gltf_read_influences( RfGltf* gltf, const json_t* json, const char* where, const RfGltfPrimitive* primitive,
                                  uint32_t base, RfDeformation* deformation );

// Up to eight joints for a vertex, rather than four?
bool rf_gltf_has_eight_joints( const json_t* primitive );

// A mesh in its own space, of all primitives. `deforms`: with its morph targets and all triangles; `skinned`: with its
// joints as well; else without the triangles that have no area (gltf_shape.c).
typedef struct RfGltfShape
{
    int mesh;
    bool deforms, skinned;
} RfGltfShape;

RfResult rf_gltf_read_shape( RfGltf* gltf, const RfGltfShape* shape, RfMesh* out );

// Takes the mesh of a node out of those that stand still, where it moves, deforms or is hidden: `mesh` becomes −1
// (gltf_mover.c).
RfResult rf_gltf_set_apart( RfGltf* gltf, int node, int* mesh );

// Places what was set apart, after everything else.
RfResult rf_gltf_place_movers( RfGltf* gltf );

// Bakes the meshes of all nodes of the default scene (gltf_mesh.c).
RfResult rf_gltf_load_meshes( RfGltf* gltf );

#endif
