// A tree over balls, for all that hold a point.
#include "kernel/light_paths.h"

#define LEAF 4

static float coordinate( RfVec3 v, int axis ) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static void bound( const RfLightPaths* paths, RfFootprintNode* node, uint32_t first, uint32_t count )
{
    node->low = rf_vec3( INFINITY, INFINITY, INFINITY );
    node->high = rf_vec3( -INFINITY, -INFINITY, -INFINITY );
    for ( uint32_t k = first; k < first + count; ++k )
    {
        const RfLightPath* path = paths->path + paths->order[k];
        RfVec3 p = path->p;
        float r = path->radius;
        node->low = rf_vec3( rf_minf( node->low.x, p.x - r ), rf_minf( node->low.y, p.y - r ), rf_minf( node->low.z, p.z - r ) );
        node->high =
            rf_vec3( rf_maxf( node->high.x, p.x + r ), rf_maxf( node->high.y, p.y + r ), rf_maxf( node->high.z, p.z + r ) );
    }
}

// Moves the smaller half of `count` paths by one coordinate to the front (quickselect; ties by number).
static void split( const RfLightPaths* paths, uint32_t* order, uint32_t count, uint32_t middle, int axis )
{
    uint32_t low = 0, high = count - 1;
    while ( low < high )
    {
        uint32_t pivot = order[low + ( high - low ) / 2], i = low, j = high;
        float at = coordinate( paths->path[pivot].p, axis );
        for ( ;; )
        {
            float x = coordinate( paths->path[order[i]].p, axis ), z = coordinate( paths->path[order[j]].p, axis );
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

static uint32_t build( RfLightPaths* paths, uint32_t first, uint32_t count )
{
    uint32_t number = paths->node_count++;
    RfFootprintNode* node = paths->node + number;
    bound( paths, node, first, count );
    *node = ( RfFootprintNode ){ .low = node->low, .high = node->high, .first = first, .count = count };
    if ( count <= LEAF )
        return number;
    RfVec3 size = rf_sub( node->high, node->low );
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    split( paths, paths->order + first, count, count / 2, axis );
    build( paths, first, count / 2 );
    node->second = build( paths, first + count / 2, count - count / 2 );
    return number;
}

void rf_build_footprints( RfLightPaths* paths )
{
    paths->node_count = 0;
    for ( uint32_t i = 0; i < paths->count; ++i )
        paths->order[i] = i;
    if ( paths->count > 0 )
        build( paths, 0, paths->count );
}

static bool holds( const RfFootprintNode* node, RfVec3 y )
{
    return y.x >= node->low.x && y.x <= node->high.x && y.y >= node->low.y && y.y <= node->high.y && y.z >= node->low.z &&
           y.z <= node->high.z;
}

void rf_find_footprints( const RfLightPaths* paths, RfVec3 y, RfFootprintFound* found, void* user )
{
    uint32_t stack[64];
    int top = 0;
    if ( paths->node_count > 0 )
        stack[top++] = 0;
    while ( top > 0 )
    {
        uint32_t number = stack[--top];
        const RfFootprintNode* node = paths->node + number;
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
            const RfLightPath* path = paths->path + paths->order[k];
            RfVec3 apart = rf_sub( y, path->p );
            if ( rf_dot( apart, apart ) <= path->radius * path->radius )
                found( user, paths->order[k] );
        }
    }
}
