// A scene as plain data: one soup of world-space triangles, materials, lights
// by triangle, and what is needed to place a camera at any time. It knows
// nothing of files, rays or estimators; loaders fill it, everybody else reads.
#ifndef REFRAME_SCENE_SCENE_H
#define REFRAME_SCENE_SCENE_H

#include "reframe/error.h"
#include "math/mat4.h"
#include "math/vec3.h"
#include "scene/texture.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum RfBsdfKind
{
    RF_BSDF_LAMBERT, // diffuse only: the same for every eye
    RF_BSDF_PHONG,   // Lambert + modified Phong lobe (Lafortune, Willems 1994)
    RF_BSDF_GGX,     // Lambert base under a Fresnel-weighted GGX coat, or metal
    RF_BSDF_COATED,  // the same under one more clear coat (KHR_materials_clearcoat)
    RF_BSDF_GLASS,   // perfect mirrors; glass, smooth or rough
    RF_BSDF_KIND_COUNT
} RfBsdfKind;

// Kinds from this one on are seen by the frame that found them only: what they
// scatter into one direction no density of another eye covers.
#define RF_BSDF_FIRST_UNEVALUABLE RF_BSDF_GLASS

// Textures and the like of a material (scene/textured.h).
typedef struct RfTextured RfTextured;

// Reflectances are linear RGB in [0, 1].
typedef struct RfMaterial
{
    char* name;
    RfBsdfKind kind;
    RfVec3 diffuse;        // Lambert reflectance (GGX: of the base, times 1 − metallic)
    RfVec3 specular;       // Phong: lobe reflectance; GGX: reflectance at normal incidence F0;
                           // GLASS: the same, of the part of it that is metal
    float f90;             // GGX: reflectance at grazing incidence; GLASS: how much of it is metal
    float coat_f0;         // GGX: dielectric Fresnel that takes light from the base
    float coat_f90;        //      (scalars: the largest channel), at normal and at grazing
    float exponent;        // Phong: n of cosⁿ, ≥ 0
    float alpha;           // GGX, COATED: roughness², in [RF_MIN_ALPHA, 1]; GLASS: 0 is smooth
    float clearcoat;       // COATED: how much of it there is, 0 to 1
    float clearcoat_alpha; // COATED: its roughness², in [RF_MIN_ALPHA, 1]
    RfVec3 tint;           // GLASS: what of the light that is not reflected passes through; 0 for mirrors
    float ior;             // GLASS: of the inside, outside 1; 0: a mirror, its Fresnel Schlick's from `specular` on
    bool thin;             // GLASS: a wall without an inside: nothing is bent or absorbed
    RfVec3 absorption;     // GLASS: of the inside, 1/m
    RfVec3 emission;       // radiance, W/(m² sr), on the front (on both sides if double_sided)
    bool double_sided;
    RfTextured* textured; // what varies over the surface: a hit asks rf_material_at; NULL: nothing
} RfMaterial;

#define RF_MIN_ALPHA 1e-3f

#define RF_NO_LIGHT 0xffffffffu

typedef struct RfTriangles
{
    uint32_t vertex_count;
    uint32_t count;
    float* positions;   // 3 × vertex_count, world space
    float* normals;     // 3 × vertex_count, unit length, world space; meshes without
                        // normals have copies of their vertices with the face's normal
    float* uvs;         // 2 × vertex_count, or NULL where no mesh has any
    float* uvs1;        // 2 × vertex_count, the second set, or NULL
    float* colors;      // 4 × vertex_count, linear, multiply the base colour, or NULL
    float* tangents;    // 4 × vertex_count: along u, and the bitangent's sign, 0 where
                        // there is none; or NULL
    uint32_t* indices;  // 3 × count, front face counter-clockwise
    uint32_t* material; // count
} RfTriangles;

// A node of the hierarchy; kept to place cameras at any time.
typedef struct RfNode
{
    char* name;
    int parent;      // −1: a root
    bool has_matrix; // else translation, rotation, scale
    RfMat4 matrix;
    double translation[3];
    double rotation[4]; // x y z w, unit
    double scale[3];
} RfNode;

typedef enum RfInterpolation
{
    RF_STEP,
    RF_LINEAR,
    RF_CUBICSPLINE,
} RfInterpolation;

typedef enum RfAnimatedPath
{
    RF_TRANSLATION,
    RF_ROTATION,
    RF_SCALE,
} RfAnimatedPath;

// One animated property of one node. Values hold `count` keys of 3 (or 4)
// doubles; CUBICSPLINE keys are in-tangent, value, out-tangent (3 × as many).
typedef struct RfChannel
{
    int node;
    RfAnimatedPath path;
    RfInterpolation interpolation;
    int count;
    double* times; // seconds, strictly increasing
    double* values;
} RfChannel;

struct RfCameraTrack;

typedef struct RfCamera
{
    char* name;                  // unique, never empty
    struct RfCameraTrack* track; // a path of our own (scene/camera_track.h), owned, or NULL:
                                 // then the rest says how it moves with its node
    int node;                    // −1: the default camera made for a scene that has none
    double yfov;                 // radians, of the image's height
    bool animated;               // a channel moves its node or an ancestor
    double start;                // seconds: first and last key of those channels
    double end;
} RfCamera;

// Light from infinitely far away, for every direction that no surface hides.
typedef struct RfEnvironment
{
    RfVec3 radiance;   // W/(m² sr): all of it, or what a map is multiplied by; 0: none
    int width, height; // of the map
    float* map;        // rgb, row by row from straight up to straight down; NULL: constant
    float rotation;    // of the map about +y, radians, counter-clockwise seen from above;
                       // at 0 the map's middle lies towards −z, +x to the right of it
    bool hidden;       // from the camera, which then sees black; it lights all the same
} RfEnvironment;

typedef enum RfPunctualKind
{
    RF_PUNCTUAL_POINT,
    RF_PUNCTUAL_SPOT,
    RF_PUNCTUAL_DIRECTIONAL,
} RfPunctualKind;

// A light without size (KHR_lights_punctual), in world space.
typedef struct RfPunctual
{
    char* name;
    RfPunctualKind kind;
    RfVec3 position;
    RfVec3 direction;           // unit, of travel: the spot's axis
    RfVec3 intensity;           // W/sr; of directional lights irradiance, W/m²
    float cos_inner, cos_outer; // of the spot's cone: full inside, none outside
    float range;                // nothing arrives from farther away, m; infinity: no limit
} RfPunctual;

typedef struct RfScene
{
    char* path;            // the file it came from
    uint64_t content_hash; // of the file's bytes (and its buffers'), for --resume
    RfTriangles triangles;
    RfVec3 bounds_min, bounds_max; // of the triangles; both 0 where there are none
    uint32_t instance_count;       // mesh primitives placed by nodes
    uint32_t material_count;
    RfMaterial* materials;
    int texture_count;
    RfTexture* textures;
    RfEnvironment environment;
    int punctual_count;
    RfPunctual* punctuals;
    int node_count;
    RfNode* nodes;
    int channel_count;
    RfChannel* channels; // sorted by node, then path
    int camera_count;
    RfCamera* cameras;
    int chosen_camera; // 1 + the one that a scene file asks for; 0: none
} RfScene;

// Frees all that a loader filled in, and clears the struct. NULL-safe inside.
void rf_destroy_scene( RfScene* scene );
void rf_destroy_camera( RfCamera* camera );

// How far a point made in floats must be lifted off its surface to be clear of
// it: scene units, for coordinates up to `largest`. A float has 24 bits; a point
// made from barycentrics is off its plane by at most some 2e-7 of the largest
// coordinate of the triangle. More room would let light into corners and points
// past thin things, and eyes see around edges.
static inline float rf_ray_offset( float largest ) { return rf_maxf( 1e-6f * largest, 1e-30f ); }

static inline float rf_largest_coordinate( RfVec3 v ) { return rf_maxf( fabsf( v.x ), rf_maxf( fabsf( v.y ), fabsf( v.z ) ) ); }

#endif
