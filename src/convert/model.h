// A model on its way from another format to glTF, as plain data: importers
// fill it, rf_write_glb writes it. All arrays are owned by the model; indices
// out of range are the importer's fault and refused by the writer.
#ifndef REFRAME_CONVERT_MODEL_H
#define REFRAME_CONVERT_MODEL_H

#include "reframe/error.h"
#include "math/mat4.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Triangles of one material.
typedef struct RfModelMesh
{
    char* name; // or NULL
    uint32_t vertex_count;
    float* positions; // 3 each
    float* normals;   // 3 each, unit; or NULL
    float* uvs;       // 2 each, v downwards as in glTF; or NULL
    float* colors;    // 4 each, linear; or NULL
    uint32_t triangle_count;
    uint32_t* indices; // 3 each, front counter-clockwise
    int material;      // or −1
} RfModelMesh;

typedef struct RfModelMaterial
{
    char* name;
    float base_color[4];
    float metallic, roughness;
    float emission[3];  // radiance; above 1 it goes into KHR_materials_emissive_strength
    float specular;     // KHR_materials_specular's factor; 1: not written
    float ior;          // 1.5: not written
    float transmission; // 0: not written
    float alpha_cutoff; // of MASK
    enum
    {
        RF_MODEL_OPAQUE,
        RF_MODEL_MASK,
        RF_MODEL_BLEND
    } alpha_mode;
    bool double_sided;
    int base_color_image; // index of an image, or −1
    int normal_image;
    int emissive_image;
} RfModelMaterial;

// The bytes of a PNG or JPEG as they are.
typedef struct RfModelImage
{
    char* name;
    const char* mime; // "image/png" or "image/jpeg"
    uint8_t* bytes;
    size_t size;
} RfModelImage;

typedef struct RfModelCamera
{
    char* name;
    double yfov; // radians
    int node;
} RfModelCamera;

// KHR_lights_punctual, at its node's origin along −z.
typedef struct RfModelLight
{
    char* name;
    enum
    {
        RF_MODEL_POINT,
        RF_MODEL_SPOT,
        RF_MODEL_DIRECTIONAL
    } kind;
    float color[3], intensity;
    float inner_angle, outer_angle; // radians, of spots
    int node;
} RfModelLight;

// A place in the hierarchy with any number of meshes.
typedef struct RfModelNode
{
    char* name;
    int parent; // lower than its own index, or −1
    RfMat4 matrix;
    int mesh_count;
    int* meshes;
} RfModelNode;

typedef struct RfModel
{
    int mesh_count, material_count, image_count, camera_count, light_count, node_count;
    RfModelMesh* meshes;
    RfModelMaterial* materials;
    RfModelImage* images;
    RfModelCamera* cameras;
    RfModelLight* lights;
    RfModelNode* nodes;
} RfModel;

// White, rough, no metal, no images.
RfModelMaterial rf_default_model_material( void );

// Frees all of it and clears the struct.
void rf_destroy_model( RfModel* model );

#endif
