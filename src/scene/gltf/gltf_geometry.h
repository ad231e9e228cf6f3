// From the meshes of a glTF document to the triangles of the scene. Internal to the reader.
#ifndef REFRAME_SCENE_GLTF_GLTF_GEOMETRY_H
#define REFRAME_SCENE_GLTF_GLTF_GEOMETRY_H

#include "scene/gltf/gltf_document.h"

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
    uint32_t material;
} RfGltfPrimitive;

// Reads a primitive.
RfResult rf_gltf_read_primitive( RfGltf* gltf, const json_t* primitive, const char* where, RfGltfPrimitive* out );

// Frees a primitive.
void rf_gltf_free_primitive( RfGltfPrimitive* primitive );

// Generates the tangents that a normal texture needs, for a primitive with normals and the
// texture's coordinates (gltf_tangents.c). Vertices shared by mirrored and unmirrored
// triangles are duplicated.
RfResult rf_gltf_make_tangents( const RfGltf* gltf, const char* where, const RfTextureRef* ref, RfGltfPrimitive* primitive );

// Bakes the meshes of all nodes of the default scene (gltf_mesh.c).
RfResult rf_gltf_load_meshes( RfGltf* gltf );

#endif
