// A model being converted from another format to glTF, as plain data: importers
// fill it, rf_write_glb writes it. The model owns all arrays. The writer rejects
// indices out of range.
#ifndef REFRAME_CONVERT_MODEL_H
#define REFRAME_CONVERT_MODEL_H

#include "image/atomic_file.h"
#include "math/mat4.h"
#include "reframe/convert.h"
#include "reframe/error.h"

#define RF_MODEL_INFLUENCES 8 // joints of a vertex

// The joints that a mesh hangs on; indices of nodes, each once.
typedef struct RfModelSkin
{
    int joint_count;
    int* joints;
    float* inverse_binds; // a matrix per joint, column-major
    uint16_t* influences; // RF_MODEL_INFLUENCES per vertex: indices into `joints`
    float* weights;       // as many, largest first, 1 in all
} RfModelSkin;

// A morph target: what is added at a weight of 1.
typedef struct RfModelMorph
{
    char* name;
    float* positions; // 3 per vertex
    float* normals;   // 3 per vertex, or NULL
} RfModelMorph;

// Triangles of one material.
typedef struct RfModelMesh
{
    char* name; // or NULL
    uint32_t vertex_count;
    float* positions; // 3 per vertex
    float* normals;   // 3 per vertex, unit length; or NULL
    float* uvs;       // 2 per vertex, v downwards as in glTF; or NULL
    float* colors;    // 4 per vertex, linear; or NULL
    uint32_t triangle_count;
    uint32_t* indices; // 3 per triangle, front face counter-clockwise
    int material;      // index of a material, or −1
    RfModelSkin* skin; // or NULL; a mesh with skin or morph targets is the only one of its nodes
    int morph_count;
    RfModelMorph* morphs;
} RfModelMesh;

// An image at scale · uv + offset; with a scale of zeros, at uv.
typedef struct RfModelTexture
{
    int image; // index of an image, or −1
    bool clamp;
    float scale[2], offset[2];
} RfModelTexture;

typedef struct RfModelMaterial
{
    char* name;
    float base_color[4];
    float metallic, roughness;
    float emission[3];  // radiance; above 1 written with KHR_materials_emissive_strength
    float specular;     // specularFactor of KHR_materials_specular; 1: not written
    float ior;          // 1.5: not written
    float transmission; // 0: not written
    float alpha_cutoff; // for RF_MODEL_MASK
    enum
    {
        RF_MODEL_OPAQUE,
        RF_MODEL_MASK,
        RF_MODEL_BLEND
    } alpha_mode;
    bool double_sided;
    RfModelTexture base_color_texture, normal_texture, emissive_texture;
} RfModelMaterial;

// An encoded PNG or JPEG file.
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
    double yfov;       // radians
    double xmag, ymag; // half the width and height of an orthographic one, in metres; else 0
    int node;
} RfModelCamera;

// A light of KHR_lights_punctual, at the origin of its node and pointing along −z.
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
    float inner_angle, outer_angle; // of a spot's cone, radians
    int node;
} RfModelLight;

// A node of the hierarchy with any number of meshes.
typedef struct RfModelNode
{
    char* name;
    int parent; // a lower index than its own, or −1
    RfMat4 matrix;
    int mesh_count;
    int* meshes;
    float* weights; // one per morph target of its mesh; or NULL: 0
} RfModelNode;

// What moves one value of a node, linearly between keys.
typedef struct RfModelTrack
{
    int node;
    enum
    {
        RF_MODEL_TRANSLATION,
        RF_MODEL_ROTATION,
        RF_MODEL_SCALE,
        RF_MODEL_WEIGHTS
    } path;
    int key_count;
    int width;     // values per key: 3, 4, or one per morph target
    float* times;  // seconds, ascending from 0
    float* values; // rotations as quaternions x y z w
} RfModelTrack;

typedef struct RfModelAnimation
{
    char* name;
    int track_count;
    RfModelTrack* tracks;
} RfModelAnimation;

typedef struct RfModel
{
    int mesh_count, material_count, image_count, camera_count, light_count, node_count, animation_count;
    RfModelMesh* meshes;
    RfModelMaterial* materials;
    RfModelImage* images;
    RfModelCamera* cameras;
    RfModelLight* lights;
    RfModelNode* nodes;
    RfModelAnimation* animations;
} RfModel;

// A white, rough dielectric without images.
RfModelMaterial rf_default_model_material( void );

// Frees all arrays and clears the struct.
void rf_destroy_model( RfModel* model );

// Takes a matrix apart, in its best approximation where it shears: translation, rotation (x y z w), scale.
void rf_split_matrix( const RfMat4* matrix, double translation[3], double rotation[4], double scale[3] );

// Adds a root node above all others that scales by `scale` and, with `z_up`, rotates a
// Z-up model to Y-up. Adds none for the identity. RF_ERROR_MEMORY leaves the model
// unchanged.
RfResult rf_apply_root_transform( RfModel* model, bool z_up, double scale, RfError* error );

// Rejects what glTF cannot hold; the message names the part.
RfResult rf_check_model( const RfModel* model, RfError* error );

// Counts the parts of a model.
RfModelCounts rf_count_model( const RfModel* model );

// Writes the file atomically. An existing file is replaced if `overwrite` is set, else
// the call fails with RF_ERROR_IO. A model that glTF cannot hold (indices out of range,
// coordinates that are not finite, more than 4 GiB) fails with RF_ERROR_FORMAT or
// RF_ERROR_UNSUPPORTED; the message names the part.
RfResult rf_write_glb( const char* path, const RfModel* model, bool overwrite, RfError* error );

// Appends the .glb to an open file, which the caller commits or discards.
RfResult rf_append_glb( RfAtomicFile* file, const RfModel* model, RfError* error );

// Reads PLY, ASCII or binary of either byte order, strictly: one mesh at one node, with the default material. Vertex properties: x y z,
// nx ny nz, s t (or u v, texture_u texture_v), red green blue alpha (uchar and ushort
// are sRGB, float and double linear). Faces: vertex_indices (or vertex_index), polygons
// are triangulated. Tristrips: the same list, -1 separates strips. Other properties and
// elements are skipped; nothing may follow the last element. Fails with RF_ERROR_FORMAT
// (giving the line or the byte), RF_ERROR_UNSUPPORTED, RF_ERROR_MEMORY or an error of
// reading the file, and leaves the model empty.
RfResult rf_read_ply( const char* path, RfModel* model, RfLog* log, RfError* error );

#endif
