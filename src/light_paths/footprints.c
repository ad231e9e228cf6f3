// A bounding volume hierarchy over the boxes, split at the median.
#include "light_paths/footprints.h"

#define LEAF 4

static float coordinate( RfVec3 v, int axis ) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static const RfFootprintBox* box_of( const RfFootprintTree* tree, uint32_t number )
{
    return (const RfFootprintBox*)(const void*)( tree->boxes + (size_t)number * tree->stride );
}

static void bound( const RfFootprintTree* tree, RfFootprintNode* node, uint32_t first, uint32_t count )
{
    node->low = rf_vec3( INFINITY, INFINITY, INFINITY );
    node->high = rf_vec3( -INFINITY, -INFINITY, -INFINITY );
    for ( uint32_t k = first; k < first + count; ++k )
    {
        const RfFootprintBox* box = box_of( tree, tree->order[k] );
        RfVec3 low = rf_sub( box->p, box->half ), high = rf_add( box->p, box->half );
        node->low = rf_vec3( rf_minf( node->low.x, low.x ), rf_minf( node->low.y, low.y ), rf_minf( node->low.z, low.z ) );
        node->high = rf_vec3( rf_maxf( node->high.x, high.x ), rf_maxf( node->high.y, high.y ), rf_maxf( node->high.z, high.z ) );
    }
}

// Moves the smaller half of `count` boxes by one coordinate to the front (quickselect; ties by number).
static void split( const RfFootprintTree* tree, uint32_t* order, uint32_t count, uint32_t middle, int axis )
{
    uint32_t low = 0, high = count - 1;
    while ( low < high )
    {
        uint32_t pivot = order[low + ( high - low ) / 2], i = low, j = high;
        float at = coordinate( box_of( tree, pivot )->p, axis );
        for ( ;; )
        {
            float x = coordinate( box_of( tree, order[i] )->p, axis ), z = coordinate( box_of( tree, order[j] )->p, axis );
            if ( x < at || ( x == at && order[i] < pivot ) )
                ++i;
            else if ( z > at || ( z == at && order[j] > pivot ) )
                --j;
            else if ( i >= j )
                break;
            else
            {
                uint32_t swap = order[i];
                order[i] = order[j];
                order[j] = swap;
            }
        }
        if ( middle == i )
            return;
        if ( middle < i )
            high = i - 1;
        else
            low = i + 1;
    }
}

static uint32_t build( RfFootprintTree* tree, uint32_t first, uint32_t count )
{
    uint32_t number = tree->node_count++;
    RfFootprintNode* node = tree->node + number;
    bound( tree, node, first, count );
    *node = ( RfFootprintNode ){ .low = node->low, .high = node->high, .first = first, .count = count };
    if ( count <= LEAF )
        return number;
    RfVec3 size = rf_sub( node->high, node->low );
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    split( tree, tree->order + first, count, count / 2, axis );
    build( tree, first, count / 2 );
    node->second = build( tree, first + count / 2, count - count / 2 );
    return number;
}

void rf_build_footprints( RfFootprintTree* tree )
{
    tree->node_count = 0;
    for ( uint32_t i = 0; i < tree->count; ++i )
        tree->order[i] = i;
    if ( tree->count > 0 )
        build( tree, 0, tree->count );
}

static bool holds( const RfFootprintNode* node, RfVec3 y )
{
    return y.x >= node->low.x && y.x <= node->high.x && y.y >= node->low.y && y.y <= node->high.y && y.z >= node->low.z &&
           y.z <= node->high.z;
}

void rf_find_footprints( const RfFootprintTree* tree, RfVec3 y, RfFootprintFound* found, void* user )
{
    uint32_t stack[64];
    int top = 0;
    if ( tree->node_count > 0 )
        stack[top++] = 0;
    while ( top > 0 )
    {
        uint32_t number = stack[--top];
        const RfFootprintNode* node = tree->node + number;
        if ( !holds( node, y ) )
            continue;
        if ( node->second != 0 )
        {
            stack[top++] = node->second;
            stack[top++] = number + 1;
            continue;
        }
        for ( uint32_t k = node->first; k < node->first + node->count; ++k )
        {
            if ( rf_box_holds( box_of( tree, tree->order[k] ), y ) )
                found( user, tree->order[k] );
        }
    }
}
