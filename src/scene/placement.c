// Finds the placement that a triangle belongs to.
#include "scene/placement.h"

RfTriangleAt rf_locate_placed_triangle( const RfScene* scene, uint32_t triangle )
{
    const RfPlacement* placements = scene->placements;
    int low = 0, high = scene->placement_count - 1;
    while ( low < high )
    {
        int middle = low + ( high - low + 1 ) / 2;
        if ( placements[middle].first <= triangle )
            low = middle;
        else
            high = middle - 1;
    }
    const RfPlacement* p = placements + low;
    return ( RfTriangleAt ){ &scene->meshes[p->mesh].triangles, triangle - p->first, p };
}
