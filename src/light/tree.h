// A tree over all lights that have a place, to pick one in proportion to what
// it may send to a surface point, in time that grows with the logarithm of
// their number. Conty Estevez, Kulla, Importance Sampling of Many Lights with
// Adaptive Tree Splitting (HPG 2018): bounding ball, intensity and a cone of
// orientations per node, built by their surface area orientation heuristic.
// The binary splits are gathered into nodes of eight children, whose estimates
// are one vector's work.
#ifndef REFRAME_LIGHT_TREE_H
#define REFRAME_LIGHT_TREE_H

#include "reframe/error.h"
#include "math/vec3.h"

#include <stdbool.h>
#include <stdint.h>

#define RF_LIGHT_CHILDREN 8
#define RF_LIGHT_LEAF 0x80000000u // in a child: the rest is the light's number, not a node's

// A light as the tree sees it. Intensities are what it sends along its axis,
// per solid angle, in a unit that all of them and the sky share.
typedef struct RfTreeLight
{
    double low[3], high[3]; // bounding box
    double axis[3];         // unit; of two-sided lights either way is meant
    double cos_spread;      // orientations are at most so far off the axis: −1 for all directions
    double cos_emission;    // and send light no farther than this off an orientation, at most 90°
    double intensity;       // at least 0; 0: never picked
    uint32_t light;         // its number
    bool two_sided;
} RfTreeLight;

// Children as vectors. Balls are a little larger than their contents, as room
// for rounding. A place that is not taken has intensity 0.
typedef struct RfLightNode
{
    _Alignas( 32 ) uint32_t child[RF_LIGHT_CHILDREN];
    float center[3][RF_LIGHT_CHILDREN];
    float radius[RF_LIGHT_CHILDREN];
    float inverse_radius[RF_LIGHT_CHILDREN];
    float axis[3][RF_LIGHT_CHILDREN];
    float flip[RF_LIGHT_CHILDREN]; // −1: two-sided, else 1
    // Light reaches up to 90° + turn off the axis. Turned towards the axis by that
    // much, a direction sees the lights as it would a plane one that faces along it.
    float cos_turn[RF_LIGHT_CHILDREN];
    float sin_turn[RF_LIGHT_CHILDREN];
    float full[RF_LIGHT_CHILDREN];      // what is nearer to the axis than that sees one head on
    float intensity[RF_LIGHT_CHILDREN]; // seen head on
} RfLightNode;

typedef struct RfLightTree
{
    uint32_t node_count; // node 0 is the root; 0: there is no tree
    uint32_t node_room;
    RfLightNode* nodes;
    uint32_t* node_place; // of each node: its parent's number times RF_LIGHT_CHILDREN plus its place there
    uint32_t* place;      // the same of each light
} RfLightTree;

// Over `count` ≥ 1 lights, which it puts into another order; their numbers are
// below `numbers`. Fails with RF_ERROR_MEMORY only.
RfResult rf_build_light_tree( RfTreeLight* lights, uint32_t count, uint32_t numbers, RfLightTree* tree, RfError* error );
void rf_destroy_light_tree( RfLightTree* tree );

// What each child of a node may send to the point x with normal n, in the
// tree's unit: an estimate of the irradiance, above 0 unless nothing can arrive.
void rf_light_importance( const RfLightNode* node, RfVec3 x, RfVec3 n, float weight[RF_LIGHT_CHILDREN] );

#endif
