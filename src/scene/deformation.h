// Meshes that change their shape: morph targets, then a skin by linear blending, as in glTF 2.0.
#ifndef REFRAME_SCENE_DEFORMATION_H
#define REFRAME_SCENE_DEFORMATION_H

#include "scene/scene.h"

// Beyond this, products of lengths overflow floats.
#define RF_MAX_COORDINATE 1e15

// Twice the smallest triangle area that is kept, in m²: where rays and lights still have room among the floats.
#define RF_MIN_DOUBLE_AREA 1e-30

// The vertices that a morph target changes, and by how much where its weight is 1.
typedef struct RfMorphTarget
{
    uint32_t count;
    uint32_t* vertices; // ascending
    float* positions;   // 3 × count, or NULL: it leaves them as they are
    float* normals;     // 3 × count, or NULL
    float* tangents;    // directions alone, 3 × count, or NULL
} RfMorphTarget;

typedef struct RfDeformation
{
    int influences;   // joints of a vertex, at most 8; 0: no skin
    int joint_count;  // 1 + the highest number of a joint
    uint16_t* joints; // influences × vertex_count
    float* weights;   // influences × vertex_count; those of a vertex sum to 1
    int target_count;
    RfMorphTarget* targets;
    bool* flat; // of a vertex: it belongs to one triangle, whose normal it has; NULL: none
} RfDeformation;

// NULL is allowed.
void rf_destroy_deformation( RfDeformation* deformation );

// The normal of a triangle; false if twice its area is less than `least`, or 0.
bool rf_face_normal( const float* positions, const uint32_t corners[3], double least, float normal[3] );

// Makes a vector of unit length, times `scale`; 0 if it has no direction.
void rf_normalise( const double v[3], double scale, float out[3] );

// Widens bounds by a point, or makes them of it.
void rf_grow_bounds( RfVec3* low, RfVec3* high, bool first, RfVec3 at );

// What deforms a mesh: all are optional.
typedef struct RfDeformer
{
    const double* weights; // of its morph targets
    const RfMat4* joints;  // of its skin: from the mesh's space to where the result is
    const RfMat4* matrix;  // where there are no joints: the same for all vertices
    double least_area;     // twice that of a triangle that is kept
} RfDeformer;

typedef struct RfDeformed
{
    double beyond;  // a coordinate beyond RF_MAX_COORDINATE, or NaN; 0: there is none
    uint32_t whole; // triangles with an area
} RfDeformed;

// Deforms `mesh` into `out`, whose positions, normals, indices and, where the mesh has them, tangents are the caller's, of the
// sizes of the mesh's; all else is shared with the mesh. Normals and tangents follow, triangles are turned over where they
// are mirrored. A triangle without area gets three equal corners, so that triangles keep their numbers and no ray hits it.
// `mirrored` has room for one number per vertex.
RfDeformed rf_deform_mesh( const RfMesh* mesh, const RfDeformer* by, bool* mirrored, RfMesh* out );

#endif
