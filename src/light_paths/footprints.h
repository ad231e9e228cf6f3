// A bounding volume hierarchy over footprints: which of them hold a point?
#ifndef REFRAME_LIGHT_PATHS_FOOTPRINTS_H
#define REFRAME_LIGHT_PATHS_FOOTPRINTS_H

#include "math/vec3.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct RfFootprintBox
{
    RfVec3 p;    // its middle
    RfVec3 half; // of its sides, m
} RfFootprintBox;

static inline bool rf_box_holds( const RfFootprintBox* box, RfVec3 y )
{
    RfVec3 apart = rf_sub( y, box->p );
    return fabsf( apart.x ) <= box->half.x && fabsf( apart.y ) <= box->half.y && fabsf( apart.z ) <= box->half.z;
}

typedef struct RfFootprintNode
{
    RfVec3 low, high; // of all its footprints
    uint32_t first;   // leaf: of its footprints in `order`; else its first child, the second follows the first's subtree
    uint32_t second;  // 0: a leaf
    uint32_t count;
} RfFootprintNode;

typedef struct RfFootprintTree
{
    const char* boxes; // the first of `count` RfFootprintBox
    size_t stride;     // from one to the next, bytes
    uint32_t count;
    uint32_t node_count;
    uint32_t* order;       // as many as boxes
    RfFootprintNode* node; // as many as boxes
} RfFootprintTree;

// Builds the tree over its boxes.
void rf_build_footprints( RfFootprintTree* tree );

// Calls `found` with the number of each box that holds y.
typedef void RfFootprintFound( void* user, uint32_t number );
void rf_find_footprints( const RfFootprintTree* tree, RfVec3 y, RfFootprintFound* found, void* user );

#endif
