// Scenes of which parts are meshes that are placed, and the same with all in world space.
#ifndef REFRAME_TESTS_PLACED_SCENES_H
#define REFRAME_TESTS_PLACED_SCENES_H

#include "scene/scene.h"

typedef enum PlacedKind
{
    PLACED_TURNED,    // rotated and moved
    PLACED_SCALED,    // evenly, by some power
    PLACED_MIRRORED,  // with a negative determinant
    PLACED_STRETCHED, // along axes that are not those of the world
    PLACED_KIND_COUNT,
} PlacedKind;

// An affine matrix, other for each number.
RfMat4 placing_matrix( PlacedKind kind, int number );

// The inverse of an affine matrix.
RfMat4 inverse_matrix( const RfMat4* matrix );

// Takes the triangles that do not emit, flat mirrors aside unless `mirrors`, out of world space: into so many meshes, each in a
// space of its own and placed where it was.
void place_scene( RfScene* scene, PlacedKind kind, int meshes, bool mirrors );

// Takes all placements into world space, triangle by triangle under the same numbers.
void flatten_scene( RfScene* scene );

// Adds a mesh of all triangles that are in world space, which they leave; returns its number.
int take_mesh( RfScene* scene );

// Adds a placement. Call rf_finish_placements after the last.
void add_placement( RfScene* scene, int mesh, RfMat4 matrix );

#endif
