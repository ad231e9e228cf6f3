// The flat mirrors of a scene: coplanar triangles that reflect like a mirror, of metal or
// glass. What a camera sees in one, its mirror image sees through the mirror's outline
// (src/reuse/estimators.md, section 10).
#ifndef REFRAME_SCENE_MIRRORS_H
#define REFRAME_SCENE_MIRRORS_H

#include "scene/eye.h"
#include "scene/scene.h"

#define RF_MAX_MIRRORS 250

typedef struct RfMirror
{
    RfVec3 n;            // unit normal of the front side
    float at;            // n·x of the plane, m
    RfMaterial material; // a copy
    uint32_t number;     // of the material
    double area;         // m²
} RfMirror;

typedef struct RfMirrors
{
    int count;
    RfMirror* mirror; // the largest first
    uint32_t triangle_count;
    uint32_t* triangle;   // the triangles of all mirrors
    uint8_t* of_triangle; // mirror of each of those
} RfMirrors;

// Finds the flat mirrors: smooth, of one colour, without textures or alpha, and not tiny beside the scene. Of more than
// RF_MAX_MIRRORS the largest. Fails with RF_ERROR_MEMORY only.
RfResult rf_find_mirrors( const RfScene* scene, RfMirrors* mirrors, RfError* error );
void rf_destroy_mirrors( RfMirrors* mirrors );

// Distance of x from the mirror's plane, m; negative behind it.
static inline float rf_mirror_distance( const RfMirror* mirror, RfVec3 x ) { return rf_dot( mirror->n, x ) - mirror->at; }

static inline RfVec3 rf_mirrored_direction( const RfMirror* mirror, RfVec3 d )
{
    return rf_madd( d, mirror->n, -2.0f * rf_dot( mirror->n, d ) );
}

// The mirror image of a camera. It looks through the mirror at what the camera sees in it, in the same pixels.
static inline RfEye rf_mirrored_eye( const RfEye* eye, const RfMirror* mirror )
{
    RfEye image = *eye;
    image.origin = rf_madd( eye->origin, mirror->n, -2.0f * rf_mirror_distance( mirror, eye->origin ) );
    image.forward = rf_mirrored_direction( mirror, eye->forward );
    image.right = rf_mirrored_direction( mirror, eye->right );
    image.up = rf_mirrored_direction( mirror, eye->up );
    return image;
}

// Where the mirrors and the glass of a scene are, in a few boxes: most rays pass all of them (path/chain_samples.h).
#define RF_MAX_CHAIN_BOUNDS 16

typedef struct RfChainBounds
{
    int count;
    RfVec3 low[RF_MAX_CHAIN_BOUNDS], high[RF_MAX_CHAIN_BOUNDS];
} RfChainBounds;

// Bounds the triangles of mirrors and of glass that is not thin, by boxes that are split where that leaves out space. Fails with
// RF_ERROR_MEMORY only.
RfResult rf_bound_chains( const RfScene* scene, RfChainBounds* bounds, RfError* error );

// Whether `count` rays o + t d, t > 0, of unit d, may meet one of the boxes: 1 or 0.
void rf_meet_chain_bounds( const RfChainBounds* bounds, int count, const float* const o[3], const float* const d[3],
                           float* meets );

#endif
