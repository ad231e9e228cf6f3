// Which surface a triangle number names: a triangle in world space, or one of a mesh at the place of the world where
// a placement puts it.
#ifndef REFRAME_SCENE_PLACEMENT_H
#define REFRAME_SCENE_PLACEMENT_H

#include "scene/scene.h"

#include <float.h>
#include <stddef.h>
#include <stdint.h>

// The triangles as placed.
static inline uint32_t rf_triangle_count( const RfScene* scene )
{
    return scene->placement_count > 0 ? scene->triangle_count : scene->triangles.count;
}

typedef struct RfTriangleAt
{
    const RfTriangles* triangles;
    uint32_t index;               // in them
    const RfPlacement* placement; // NULL: they are in world space
} RfTriangleAt;

// A triangle of a placement.
RfTriangleAt rf_locate_placed_triangle( const RfScene* scene, uint32_t triangle );

static inline RfTriangleAt rf_locate_triangle( const RfScene* scene, uint32_t triangle )
{
    return triangle < scene->triangles.count ? ( RfTriangleAt ){ &scene->triangles, triangle, NULL }
                                             : rf_locate_placed_triangle( scene, triangle );
}

// A point of a mesh in the world: rounded once, as the readers do with what they put into world space themselves.
static inline RfVec3 rf_place_point( const RfMat4* matrix, RfVec3 p )
{
    double in[3] = { (double)p.x, (double)p.y, (double)p.z }, out[3];
    rf_mat4_apply( matrix, in, 1.0, out );
    return rf_vec3( (float)out[0], (float)out[1], (float)out[2] );
}

// A unit normal of a mesh in the world; `side` is −1 for a matrix that mirrors.
static inline RfVec3 rf_place_normal( const RfMat4* matrix, double side, RfVec3 n )
{
    double in[3] = { (double)n.x, (double)n.y, (double)n.z }, out[3];
    rf_mat4_apply_cofactor( matrix, in, out );
    double length = sqrt( out[0] * out[0] + out[1] * out[1] + out[2] * out[2] );
    if ( !( length > 0.0 && length <= DBL_MAX ) )
        return rf_vec3( 0, 0, 1 );
    side /= length;
    return rf_vec3( (float)( out[0] * side ), (float)( out[1] * side ), (float)( out[2] * side ) );
}

// A unit direction along a mesh's surface in the world; zero where the matrix collapses it.
RfVec3 rf_place_direction( const RfMat4* matrix, RfVec3 d );

// Corner 0, 1 or 2 of a triangle of a list, in its space.
static inline RfVec3 rf_corner( const RfTriangles* triangles, uint32_t triangle, int corner )
{
    const float* p = triangles->positions + 3 * (size_t)triangles->indices[3 * (size_t)triangle + (size_t)corner];
    return rf_vec3( p[0], p[1], p[2] );
}

// That of any triangle, in the world.
RfVec3 rf_placed_corner( const RfScene* scene, uint32_t triangle, int corner );

static inline RfVec3 rf_triangle_corner( const RfScene* scene, uint32_t triangle, int corner )
{
    return triangle < scene->triangles.count ? rf_corner( &scene->triangles, triangle, corner )
                                             : rf_placed_corner( scene, triangle, corner );
}

// Numbers the triangles of all placements, counts the uses of meshes and indexes the placements; called by readers whenever
// placements, meshes or the triangles in world space have become more. Fails where there are more than triangles may have.
#define RF_MOST_TRIANGLES 0xfffffffeu
RfResult rf_number_placements( RfScene* scene, RfError* error );

// The same, and has the bounds of the scene, which are those of the triangles in world space so far, hold what is placed.
RfResult rf_finish_placements( RfScene* scene, RfError* error );

// The number of a triangle's material.
static inline uint32_t rf_material_of( const RfScene* scene, uint32_t triangle )
{
    RfTriangleAt at = rf_locate_triangle( scene, triangle );
    return at.triangles->material[at.index];
}

// A list of triangles of the scene, in world space or of a mesh, with the number of times that it is there.
typedef struct RfTriangleList
{
    const RfTriangles* triangles;
    uint32_t uses;
} RfTriangleList;

// List 0 are the triangles in world space, list 1 + m those of mesh m. Uses that are not shown count as well.
static inline int rf_triangle_list_count( const RfScene* scene ) { return 1 + scene->mesh_count; }
RfTriangleList rf_triangle_list( const RfScene* scene, int list );

// Counts the triangles of materials for which `is` is true, and lists their numbers, ascending, where `numbers` is not NULL. What
// is not shown is left out.
uint32_t rf_list_triangles( const RfScene* scene, bool ( *is )( const RfMaterial* ), uint32_t* numbers );

// How much the errors of a matrix of floats and its inverse grow on the way into a mesh's space and back: the largest row sum of
// the magnitudes of both, multiplied. 1 to 3 for rotations; infinity for a matrix that has no inverse.
double rf_placement_spread( const RfMat4* matrix );

// The triangles that are appended to those in world space from now on are of a node; −1: of none. False: there is no memory.
bool rf_begin_node_run( RfScene* scene, int node );

// The node that a triangle is of; −1: none.
int rf_node_of_triangle( const RfScene* scene, uint32_t triangle );

// What the surfaces of a node are called: as the node, unless the file has another name for them. Node −1: "unnamed".
const char* rf_object_name( const RfScene* scene, int node );

// What it belongs to: the asset that the file gives the node or the nearest node above it, else the object of the topmost node.
const char* rf_asset_name( const RfScene* scene, int node );

// Numbers for compositors, by node (−1 is 0) and by material: those of the file, 0 for what has none; where no node or no material
// has one, 1 + the number of the node or material in the scene.
void rf_list_object_indices( const RfScene* scene, float* of_node );       // node_count + 1, from node −1 on
void rf_list_material_indices( const RfScene* scene, float* of_material ); // material_count

// The greatest of a file.
#define RF_MOST_PASS_INDEX 16777215

// Marks the nodes that surfaces are of: node_count + 1, from node −1 on.
void rf_mark_objects( const RfScene* scene, bool* has_surfaces );

// Marks the materials that some triangle has.
void rf_mark_used_materials( const RfScene* scene, bool* used );

#endif
