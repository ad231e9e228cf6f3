// A scene as plain data: one soup of world-space triangles, materials, lights
// by triangle, and what is needed to place a camera at any time. It knows
// nothing of files, rays or estimators; loaders fill it, everybody else reads.
#ifndef REFRAME_SCENE_SCENE_H
#define REFRAME_SCENE_SCENE_H

#include "bsdf/models.h"
#include "reframe/error.h"
#include "math/mat4.h"
#include "math/vec3.h"
#include "scene/texture.h"

#include <stdbool.h>
#include <stdint.h>

// Textures and the like of a material (scene/textured.h).
typedef struct RfTextured RfTextured;

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
