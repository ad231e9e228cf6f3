// From the meshes of a glTF document to the triangles of the scene. Internal to the reader.
#ifndef REFRAME_SCENE_GLTF_GLTF_GEOMETRY_H
#define REFRAME_SCENE_GLTF_GLTF_GEOMETRY_H

#include "scene/gltf/gltf_document.h"

// The triangles of a primitive in object space, with only the vertices that they use
// (gltf_primitive.c, gltf_triangles.c).
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
    uint32_t material;
} RfGltfPrimitive;

// Reads a primitive.
RfResult rf_gltf_read_primitive( RfGltf* gltf, const json_t* primitive, const char* where, RfGltfPrimitive* out );

// Frees a primitive.
void rf_gltf_free_primitive( RfGltfPrimitive* primitive );

// Reads triples of vertex indices, from an index accessor or implicit, by mode.
RfResult rf_gltf_read_triangles( RfGltf* gltf, const json_t* primitive, const char* where, int mode, uint32_t vertex_count,
                                 uint32_t** indices, uint32_t* triangle_count );

// Replaces the normals of a primitive by its face normals (gltf_flat.c).
RfResult rf_gltf_make_flat( const RfGltf* gltf, const char* where, RfGltfPrimitive* primitive );

// Generates the tangents that a normal texture needs, for a primitive with normals and the
// texture's coordinates (gltf_tangents.c). Vertices shared by mirrored and unmirrored
// triangles are duplicated.
RfResult rf_gltf_make_tangents( const RfGltf* gltf, const char* where, const RfTextureRef* ref, RfGltfPrimitive* primitive );

// State of baking primitives into the scene (gltf_bake.c).
typedef struct RfGltfBaker
{
    uint32_t vertex_capacity, triangle_capacity;
    float* world; // world-space positions of the current primitive
    uint32_t world_capacity;
    uint32_t placed; // triangles so far, including dropped ones
    uint64_t degenerate;
    RfWhere first_degenerate;
} RfGltfBaker;

// Appends a primitive, transformed by a matrix, to the triangles of the scene.
RfResult rf_gltf_bake( RfGltf* gltf, RfGltfBaker* baker, const RfGltfPrimitive* primitive, const RfMat4* matrix,
                       const char* where );
void rf_gltf_finish_bake( RfGltf* gltf, RfGltfBaker* baker );

// Bakes texture coordinates, colours and tangents (gltf_attributes.c).
RfResult rf_gltf_reserve_attributes( const RfGltf* gltf, const RfGltfBaker* baker, const RfGltfPrimitive* primitive,
                                     const char* where );
void rf_gltf_copy_attributes( RfTriangles* t, uint32_t to, const RfGltfPrimitive* primitive, uint32_t from );

// `sign` is −1 for a mirroring matrix.
void rf_gltf_transform_tangent( RfTriangles* t, uint32_t to, const RfGltfPrimitive* primitive, uint32_t from,
                                const RfMat4* matrix, double sign );

// The instances of a node's mesh and their transforms within the node; a single one without
// the extension (gltf_instancing.c).
typedef struct RfGltfInstances
{
    uint32_t count;
    int translation, rotation, scale; // accessors, or −1
} RfGltfInstances;

// Reads the instances of a node.
RfResult rf_gltf_open_instances( RfGltf* gltf, int node, RfGltfInstances* instances );

// The transform of one instance within its node.
RfResult rf_gltf_instance_matrix( const RfGltf* gltf, const RfGltfInstances* instances, uint32_t element, RfMat4* matrix );

// Bakes the meshes of all nodes of the default scene (gltf_mesh.c).
RfResult rf_gltf_load_meshes( RfGltf* gltf );

#endif
