// A tree over footprints, which are balls.
#ifndef REFRAME_KERNEL_FOOTPRINTS_H
#define REFRAME_KERNEL_FOOTPRINTS_H

#include "math/vec3.h"

#include <stddef.h>
#include <stdint.h>

typedef struct RfBall
{
    RfVec3 p;
    float radius; // m
} RfBall;

typedef struct RfFootprintNode
{
    RfVec3 low, high; // of all its footprints
    uint32_t first;   // leaf: of its footprints in `order`; else its first child, the second follows the first's subtree
    uint32_t second;  // 0: a leaf
    uint32_t count;
} RfFootprintNode;

typedef struct RfFootprintTree
{
    const char* balls; // the first of `count` RfBall
    size_t stride;     // from one to the next, bytes
    uint32_t count;
    uint32_t node_count;
    uint32_t* order;       // as many as balls
    RfFootprintNode* node; // likewise
} RfFootprintTree;

// Builds the tree over its balls.
void rf_build_footprints( RfFootprintTree* tree );

// Calls `found` with the number of each ball that holds y.
typedef void RfFootprintFound( void* user, uint32_t number );
void rf_find_footprints( const RfFootprintTree* tree, RfVec3 y, RfFootprintFound* found, void* user );

#endif
