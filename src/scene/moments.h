// What moves while a shutter is open: it is posed at some moments, and between two of them its places and shapes go straight from
// one to the other, entry by entry of matrices and vertex by vertex.
#ifndef REFRAME_SCENE_MOMENTS_H
#define REFRAME_SCENE_MOMENTS_H

#include "reframe/camera.h"
#include "scene/placement.h"
#include "scene/pose.h"

// Evenly from when the shutter opens to when it closes.
typedef struct RfMoments
{
    int steps; // one less than moments
    const RfPlacement* placements[RF_MAX_BLUR_STEPS + 1];
    const RfMesh* meshes[RF_MAX_BLUR_STEPS + 1];
} RfMoments;

// The moment whose pose has all that is not places and shapes (RfPosedScene.middle): the middle one, or that after the middle.
static inline int rf_middle_moment( int steps ) { return ( steps + 1 ) / 2; }

// Seconds of the scene at one of an eye's moments; its time where nothing is blurred.
static inline double rf_moment_time( const RfEye* eye, int moment )
{
    return eye->blur_steps > 0 ? eye->opens + ( eye->closes - eye->opens ) * moment / (double)eye->blur_steps : eye->time;
}

// Joins poses of a shutter (RfPosedScene.in_shutter), steps + 1 of them, into one scene: that of the middle moment, with `moments`,
// which like the poses must outlive it. What is shown there is shown at all moments: where it is not, it stands as at the next
// moment towards the middle that shows it. Triangles that are without area at some moments only are there at all of them.
void rf_join_moments( RfPosedScene* poses, int steps, RfMoments* moments );

static inline int rf_moment_count( const RfScene* scene ) { return scene->moments != NULL ? scene->moments->steps + 1 : 1; }

static inline const RfPlacement* rf_placements_at( const RfScene* scene, int moment )
{
    return scene->moments != NULL ? scene->moments->placements[moment] : scene->placements;
}

static inline const RfMesh* rf_meshes_at( const RfScene* scene, int moment )
{
    return scene->moments != NULL ? scene->moments->meshes[moment] : scene->meshes;
}

// Whether a placement is to be looked up between moments.
static inline bool rf_is_between( const RfScene* scene, const RfPlacement* placement )
{
    return scene->moments != NULL && placement != NULL && placement - scene->placements >= scene->still_placement_count;
}

// A corner of a placement's triangle, which is located already, at one of the moments.
static inline RfVec3 rf_corner_at( const RfScene* scene, int moment, const RfTriangleAt* at, int corner )
{
    const RfPlacement* p = rf_placements_at( scene, moment ) + ( at->placement - scene->placements );
    const float* position = rf_meshes_at( scene, moment )[p->mesh].triangles.positions +
                            3 * (size_t)at->triangles->indices[3 * (size_t)at->index + (size_t)corner];
    return rf_place_point( &p->matrix, rf_vec3( position[0], position[1], position[2] ) );
}

// A triangle of a placement at scene->moment, as a mesh of its own.
typedef struct RfBetween
{
    RfTriangles triangles;
    RfPlacement placement;
    float positions[9], normals[9], tangents[12], uvs[6], uvs1[6], colors[12];
    uint32_t indices[3], material;
    // what floats are rounded by at the moments before and after: the largest magnitudes
    RfMat4 most;       // of the matrix
    RfVec3 own, world; // of the corners' coordinates
    bool turned;       // the mirrored triangle is seen from behind: deformation turns it over within the shutter
} RfBetween;

// The segment between two moments and the part of it are found in floats, as Embree does.
RfTriangleAt rf_triangle_between( const RfScene* scene, const RfTriangleAt* at, RfBetween* between );

#endif
