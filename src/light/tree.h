// A tree over lights other than the sky. It selects one in proportion to an estimate
// of its contribution at a shading point, in logarithmic time. Conty Estevez,
// Kulla, Importance Sampling of Many Lights with Adaptive Tree Splitting (HPG
// 2018): bounding ball, intensity and orientation cone per node, built by their
// surface area orientation heuristic. The binary splits are collapsed into nodes
// of eight children, whose importances are computed with vector instructions.
#ifndef REFRAME_LIGHT_TREE_H
#define REFRAME_LIGHT_TREE_H

#include "reframe/error.h"
#include "math/vec3.h"

#include <stdbool.h>
#include <stdint.h>

#define RF_LIGHT_CHILDREN 8
#define RF_LIGHT_LEAF 0x80000000u // in a child: the rest is the light's number, not a node's

// A light as the tree sees it. Intensities are along the axis, per solid angle, in
// a unit common to all lights and the sky.
typedef struct RfTreeLight
{
    double low[3], high[3]; // bounding box
    double axis[3];         // unit; of two-sided lights its sign does not matter
    double cos_spread;      // of the largest angle of an orientation to the axis; −1: all directions
    double cos_emission;    // of the largest angle of emission to an orientation, at most 90°
    double intensity;       // at least 0; 0: never selected
    uint32_t light;         // its number
    bool two_sided;
} RfTreeLight;

// Children as vectors. Balls are a little larger than their contents, to allow for
// rounding. Unused slots have intensity 0.
typedef struct RfLightNode
{
    _Alignas( 32 ) uint32_t child[RF_LIGHT_CHILDREN];
    float center[3][RF_LIGHT_CHILDREN];
    float radius[RF_LIGHT_CHILDREN];
    float inverse_radius[RF_LIGHT_CHILDREN];
    float axis[3][RF_LIGHT_CHILDREN];
    float flip[RF_LIGHT_CHILDREN]; // −1: two-sided, else 1
    // Light reaches up to 90° + turn from the axis. A direction rotated by `turn`
    // towards the axis sees the node like a flat light that faces along the axis.
    float cos_turn[RF_LIGHT_CHILDREN];
    float sin_turn[RF_LIGHT_CHILDREN];
    float full[RF_LIGHT_CHILDREN];      // cosine to the axis above which some light may be seen head on
    float intensity[RF_LIGHT_CHILDREN]; // seen head on
} RfLightNode;

typedef struct RfLightTree
{
    uint32_t node_count; // node 0 is the root; 0: there is no tree
    uint32_t node_capacity;
    RfLightNode* nodes;
    uint32_t* parent_slot; // of each node: its parent's number times RF_LIGHT_CHILDREN plus its slot there
    uint32_t* leaf_slot;   // of each light; RF_NO_LIGHT: it is not in the tree
} RfLightTree;

// Builds the tree over `count` ≥ 1 lights, which it reorders; their numbers are
// below `numbers`. Fails with RF_ERROR_MEMORY only.
RfResult rf_build_light_tree( RfTreeLight* lights, uint32_t count, uint32_t numbers, RfLightTree* tree, RfError* error );
void rf_destroy_light_tree( RfLightTree* tree );

// Extends the bounds of a light to include those that it has at another time, with the greater of both intensities.
void rf_sweep_tree_light( RfTreeLight* light, const RfTreeLight* other );

// The importance of each child of a node for the point x with normal n: an estimate
// of its irradiance in the unit of the tree, above 0 unless nothing can arrive.
void rf_light_importance( const RfLightNode* node, RfVec3 x, RfVec3 n, float importance[RF_LIGHT_CHILDREN] );

#endif
