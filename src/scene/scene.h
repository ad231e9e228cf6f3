// A scene as plain data: world-space triangles, meshes and where they are placed, materials,
// lights, cameras, and the node hierarchy that moves the cameras. Loaders fill it; everything
// else only reads it. It does not depend on files, rays or estimators.
#ifndef REFRAME_SCENE_SCENE_H
#define REFRAME_SCENE_SCENE_H

#include "bsdf/models.h"
#include "reframe/scene.h"
#include "math/mat4.h"
#include "math/vec3.h"
#include "scene/profile.h"
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
    float* normals;     // 3 × vertex_count, unit length, world space; for meshes without
                        // normals, vertices are duplicated and carry the face normal
    float* uvs;         // 2 × vertex_count, or NULL if no mesh has any
    float* uvs1;        // 2 × vertex_count, the second set, or NULL
    float* colors;      // 4 × vertex_count, linear, multiply the base colour, or NULL
    float* tangents;    // 4 × vertex_count: direction of u and sign of the bitangent (0: no
                        // tangent); or NULL
    uint32_t* indices;  // 3 × count, front face counter-clockwise
    uint32_t* material; // count
} RfTriangles;

// The attributes of vertices, in the order of their members.
typedef enum RfAttribute
{
    RF_POSITION,
    RF_NORMAL,
    RF_UV,
    RF_UV1,
    RF_COLOR,
    RF_TANGENT,
    RF_ATTRIBUTE_COUNT
} RfAttribute;

typedef struct RfAttributeTraits
{
    size_t offset;
    size_t components;
    float fill; // of vertices without it, where others have it
} RfAttributeTraits;

extern const RfAttributeTraits g_rf_attributes[RF_ATTRIBUTE_COUNT];

static inline float** rf_attribute( RfTriangles* t, int attribute )
{
    return (float**)(void*)( (char*)t + g_rf_attributes[attribute].offset );
}

struct RfDeformation;

// A mesh in its own space, which placements put into the world.
typedef struct RfMesh
{
    RfTriangles triangles;
    RfVec3 bounds_min, bounds_max;
    uint32_t uses;                     // placements of it
    struct RfDeformation* deformation; // owned; NULL: it is rigid
} RfMesh;

// A mesh at one place of the world. Its triangles have the numbers `first` to `first` + the mesh's count.
typedef struct RfPlacement
{
    int mesh;
    uint32_t first;
    RfMat4 matrix; // affine, from the mesh's space into the world relative to the scene's origin; invertible where shown
    bool shown;    // false: it is not there
    int mover;     // of the scene's movement (scene/movement.h), in their order; −1: it stands still
    int node;      // 1 + the node that has the mesh (scene/placement.h); 0: none
} RfPlacement;

// From where on triangles in world space are of a node.
typedef struct RfNodeRun
{
    uint32_t first; // triangle; the run ends where the next begins
    int node;       // 1 + its number; 0: none
} RfNodeRun;

struct RfMovement;

// A node of the hierarchy, kept to evaluate cameras and what moves at any time.
typedef struct RfNode
{
    char* name;
    char* object;    // what its surfaces are called instead; NULL: as the node
    char* asset;     // what they and those below it belong to, rather than to the topmost node; NULL: not given
    int pass_index;  // a number for compositors; 0: none
    int parent;      // −1: a root
    bool hidden;     // with all below it, unless a channel shows it
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
    RF_WEIGHTS,    // of morph targets
    RF_VISIBILITY, // 1, or 0: hidden
    RF_VALUE,      // of what is not a node (scene/movement.h)
} RfAnimatedPath;

struct RfCurve;

// By which clock a channel goes: it begins with `first` at `start`, goes `speed` times as fast as the scene, and at `last` stays or
// begins again.
typedef struct RfClock
{
    double start;       // seconds of the scene
    double speed;       // seconds of the channel in one of the scene; 0: it goes by the scene's own, and the rest says nothing
    double first, last; // seconds of the channel
    bool loops;
} RfClock;

// One animated property of one node: `count` keys of 3 doubles (rotations: 4, visibility: 1, weights: one for each
// morph target). A CUBICSPLINE key is in-tangent, value, out-tangent: three times as many doubles.
typedef struct RfChannel
{
    int node;
    RfAnimatedPath path;
    int components; // numbers of a value
    RfInterpolation interpolation;
    int count;
    double* times; // seconds, strictly increasing
    double* values;
    struct RfCurve* curve; // owned: smooth, through the same keys (scene/camera_path/curve.h); NULL: as interpolation says
    RfClock clock;
} RfChannel;

struct RfCameraTrack;
struct RfOptics;

// A shot of an edit: the camera that shows it, and when it begins.
typedef struct RfEditShot
{
    int camera;  // of the scene, none of which is an edit
    double from; // seconds, or with RfEdit.in_frames frames of the edit, from 0
} RfEditShot;

// Cameras of the scene that show one shot after the other, at the times of the scene.
typedef struct RfEdit
{
    int count;
    RfEditShot* shots; // owned, ascending
    bool in_frames;
} RfEdit;

typedef struct RfCamera
{
    char* name;                  // unique, never empty
    struct RfEdit* edit;         // owned: other cameras show its shots, from `start` to `end`; NULL: it shows all of them itself
    struct RfCameraTrack* track; // owned: a camera path (scene/camera_path/camera_track.h); NULL: the
                                 // camera moves with its node, as the fields below describe
    int node;                    // −1: the default camera of a scene without cameras
    int projection;              // RfProjectionKind
    double yfov;                 // perspective: vertical field of view, radians
    double ymag;                 // orthographic: half the height of the picture, m
    double aspect;               // of the picture that it is meant for, width over height; 0: it does not say
    struct RfChange* zoom;       // owned: yfov or ymag where that changes (scene/movement.h); NULL: it does not
    struct RfOptics* optics;     // owned: lens and shutter where there is no path; NULL: a pinhole
    bool animated;               // a channel animates its node or an ancestor, or its field of view
    double start;                // seconds: first key of those channels
    double end;                  // last key
    int cut_count;               // of a camera that moves with its node
    double* cuts;                // owned: seconds, ascending: its node jumps, and another shot begins
} RfCamera;

// Light from infinity, for every direction that hits no surface.
typedef struct RfEnvironment
{
    RfVec3 radiance;      // W/(m² sr): constant radiance, or a factor on the map; 0: no environment
    int width, height;    // of the map
    float* map;           // RGB, equirectangular, rows from +y (up) to −y; NULL: constant
    float rotation;       // of the map about +y, radians, counter-clockwise seen from above;
                          // at 0 the centre of the map is at −z, with +x to its right
    bool hidden;          // black to camera rays, but still illuminates the scene
    bool changes;         // its radiance or its rotation do: a pose has them as they are
    uint16_t light_group; // 1 + that in the scene's list; 0: none
} RfEnvironment;

typedef enum RfPunctualKind
{
    RF_PUNCTUAL_POINT,
    RF_PUNCTUAL_SPOT,
    RF_PUNCTUAL_DIRECTIONAL,
    RF_PUNCTUAL_PLANE, // a rectangle or an ellipse
} RfPunctualKind;

// A punctual light (KHR_lights_punctual), in world space. Of one that changes, the intensity of a loaded scene is the most that it
// has.
typedef struct RfPunctual
{
    char* name;
    RfPunctualKind kind;
    RfVec3 position;
    RfVec3 direction;           // unit, the way the light travels: the axis of a spot
    RfVec3 across;              // unit, perpendicular to it: the x axis of its node, where that is `turned`
    bool turned;                // its light depends on `across`, and of a point on `direction`; set before it is placed
    RfVec3 intensity;           // W/sr; directional lights: irradiance, W/m²; planes: along the axis, without a spread
    RfProfile* profile;         // by which it is multiplied in each direction, of one that is `turned`; NULL: none. Owned in part
    float cos_inner, cos_outer; // spot cone: full intensity inside inner, none outside outer
    float range;                // m, no light beyond it; infinity: unlimited
    float radius;               // m, of a point or a spot that is a ball (light/extent.h); 0: it has no size
    bool soft;                  // it is a disc that turns to what it lights instead
    float versine;        // of a directional light that is a disc in the sky: 1 − the cosine of its radius; 0: it has no size
    float half[2];        // of a plane, m: half its size along `across` and perpendicular to it
    bool ellipse;         // a plane, within that
    float tan_spread;     // of a plane: no light beyond this tangent to the axis; 0: to all of its side
    float spread_scale;   // keeps its flux
    bool changes;         // it moves, is dimmed or is switched, or else is another at some time: a pose has it as it is
    uint16_t light_group; // 1 + that in the scene's list; 0: none
} RfPunctual;

// The way it points in world space, from the columns of its node's matrix: along −z. False if that is of no length.
static inline bool rf_turn_lamp( const double m[16], RfPunctual* lamp )
{
    double length = sqrt( m[8] * m[8] + m[9] * m[9] + m[10] * m[10] );
    if ( !( length > 0.0 && length < HUGE_VAL ) )
        return false;
    double scale = -1.0 / length;
    lamp->direction = rf_vec3( (float)( m[8] * scale ), (float)( m[9] * scale ), (float)( m[10] * scale ) );
    if ( !lamp->turned )
        return true;
    RfVec3 y;
    double z[3] = { m[8] / length, m[9] / length, m[10] / length }, along = m[0] * z[0] + m[1] * z[1] + m[2] * z[2];
    double x[3] = { m[0] - along * z[0], m[1] - along * z[1], m[2] - along * z[2] };
    double most = sqrt( x[0] * x[0] + x[1] * x[1] + x[2] * x[2] );
    rf_basis( lamp->direction, &lamp->across, &y ); // where the scale is 0
    if ( most > 0.0 && most < HUGE_VAL )
        lamp->across = rf_vec3( (float)( x[0] / most ), (float)( x[1] / most ), (float)( x[2] / most ) );
    return true;
}

// The cone of a spot, radians.
static inline void rf_set_cone( RfPunctual* spot, double inner, double outer )
{
    spot->cos_inner = (float)cos( inner );
    spot->cos_outer = (float)fmax( cos( outer ), 0.0 );
}

#define RF_VIEW_NAME_SIZE 64

// A view transform as Blender's scenes and OpenColorIO name it. Names are compared without case.
typedef struct RfViewText
{
    char transform[RF_VIEW_NAME_SIZE]; // "Standard", "Filmic", "AgX", or one of a configuration; "": none is named
    char look[RF_VIEW_NAME_SIZE];      // "High Contrast", "AgX - Punchy" or "Punchy"; "" and "None": none
    double exposure;                   // stops
    double gamma;                      // of what is displayed; 0 stands for 1
} RfViewText;

struct RfScene
{
    char* path;            // the file it was loaded from
    uint64_t content_hash; // of the bytes of the file and its buffers, for --resume
    double origin[3];      // all positions are relative to it, in floats; 0 unless the scene lies far out
                           // (gltf/gltf.c). Nodes, channels and camera tracks are not: eyes are
    // Triangle numbers name surfaces everywhere: those below triangles.count are these, the others those of placements
    // (scene/placement.h).
    RfTriangles triangles;
    uint32_t triangle_count; // all, as placed, where there are placements: rf_triangle_count
    int mesh_count;
    RfMesh* meshes;
    int placement_count;
    int still_placement_count;  // which come first
    RfPlacement* placements;    // by their first triangles, ascending; those that move are placed by rf_pose_scene
    uint32_t* placement_blocks; // the placement of every 2^placement_shift-th of their triangles, and the last one
    int placement_shift;
    uint32_t node_run_count;
    RfNodeRun* node_runs;        // whose the triangles in world space are, ascending; none: of no node
    struct RfMovement* movement; // owned: what moves, and how; NULL: nothing does
    const struct RfMoments*
        moments;  // of poses: where what moves is while the shutter is open (scene/moments.h); NULL: it is closed
    float moment; // within the shutter, 0 to 1: that of this scene
    int unrendered_count;
    RfUnrendered* unrendered;
    bool frozen;                     // something moves or changes in the file, and was read as in the first frame
    double change_start, change_end; // seconds: keys of what changes beside nodes, in the file; equal: nothing does
    RfVec3 bounds_min, bounds_max;   // of all triangles; both 0 if there are none
    uint32_t instance_count;         // mesh primitives instanced by nodes
    uint32_t material_count;
    RfMaterial* materials;
    int texture_count;
    RfTexture* textures;
    RfEnvironment environment;
    int punctual_count;
    RfPunctual* punctuals;
    int light_group_count;
    char** light_groups; // names by which the file tags lamps, materials and the environment, in the order in which it is read
    int node_count;
    RfNode* nodes;
    int channel_count;
    RfChannel* channels; // sorted by node, then path
    int camera_count;
    RfViewText view;             // how the file wants its pictures to be shown
    RfFps fps;                   // that the file asks for; 0/0: it does not say
    int film_width, film_height; // that the file asks for, pixels; 0: it does not say
    bool film_alpha;             // it asks for RGBA
    int max_depth;               // of paths, that it asks for; 0: it does not say
    int moving_count;            // objects that move
    char** moving;               // their names
    int variant_count;           // of materials, in the file
    char** variants;             // their names
    int loss_count;
    char** losses; // textures that are left out since they cannot be read
    int export_loss_count, export_warning_count;
    char **export_losses, **export_warnings; // of the program that wrote the file; printable
    RfCamera* cameras;
    RfFps key_fps;                             // at which its keys count frames; 0/0: none do
    int chosen_camera;                         // 1 + index of the camera that the scene file selects; 0: none
    uint64_t effects_forced, effects_left_out; // by rf_choose_effects: sets of RF_EFFECT_BITs
};

// Frees everything the loader allocated and clears the struct. Members may be NULL.
void rf_destroy_scene( RfScene* scene );

// Fails with RF_ERROR_UNSUPPORTED where something changes that cannot be rendered so.
RfResult rf_check_rendered( const RfScene* scene, RfError* error );

// Gives a list, whose address is given, room for so many items and one more. False: there is no memory, and it is as it was.
bool rf_make_room( void* list, size_t count, size_t size );

// Adds to what changes and cannot be rendered so; the same is listed once. False: there is no memory.
bool rf_note_unrendered( RfScene* scene, const char* what, const char* why );

// Frees the arrays and clears the struct.
void rf_destroy_triangles( RfTriangles* triangles );

// Frees the keys of a channel and clears the struct.
void rf_destroy_channel( RfChannel* channel );

// Frees the camera's name and track and clears the struct.
void rf_destroy_camera( RfCamera* camera );
void rf_destroy_punctual( RfPunctual* punctual );

// Parses frames per second: "24" to "1000000", "30000/1001", or a decimal of the rates n · 1000/1001 (rf_broadcast_fps).
bool rf_parse_fps( const char* text, RfFps* fps );

// The fraction that a decimal such as 23.976, 23.98, 29.97, 59.94 or 119.88 stands for: 24, 30 and multiples of them by 1000/1001,
// rounded to two digits or more. False: it is none.
bool rf_broadcast_fps( double decimal, RfFps* fps );

// The frames per second that the file asks for, else 24.
RfFps rf_scene_fps( const RfScene* scene );

// Ray offset, in scene units: how far to lift a hit point off its surface to
// avoid self-intersection, for coordinates up to `largest`. A point interpolated
// in floats (24 bits) misses its plane by at most about 2e-7 of the triangle's
// largest coordinate. A larger offset would leak light into corners and through
// thin geometry, and let cameras see around edges.
static inline float rf_ray_offset( float largest ) { return rf_maxf( 1e-6f * largest, 1e-30f ); }

static inline float rf_largest_coordinate( RfVec3 v ) { return rf_maxf( fabsf( v.x ), rf_maxf( fabsf( v.y ), fabsf( v.z ) ) ); }

#endif
