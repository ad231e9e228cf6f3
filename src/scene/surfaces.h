// Whose surfaces are: the object (a node), its asset, and the material of a triangle, with the names and numbers by which
// compositors find them.
#ifndef REFRAME_SCENE_SURFACES_H
#define REFRAME_SCENE_SURFACES_H

#include "scene/placement.h"

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

#endif
