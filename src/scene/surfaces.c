// Whose surfaces are, by runs of triangles and by placements.
#include "scene/surfaces.h"

#include <stdlib.h>

bool rf_begin_node_run( RfScene* scene, int node )
{
    uint32_t count = scene->node_run_count, first = scene->triangles.count;
    if ( count > 0 && scene->node_runs[count - 1].node == 1 + node )
        return true;
    if ( count == 0 || scene->node_runs[count - 1].first != first ) // else the last one is empty
    {
        RfNodeRun* grown = realloc( scene->node_runs, ( (size_t)count + 1 ) * sizeof *grown );
        if ( grown == NULL )
            return false;
        scene->node_runs = grown;
        scene->node_run_count = count += 1;
    }
    scene->node_runs[count - 1] = ( RfNodeRun ){ first, 1 + node };
    return true;
}

int rf_node_of_triangle( const RfScene* scene, uint32_t triangle )
{
    if ( triangle >= scene->triangles.count )
        return rf_locate_placed_triangle( scene, triangle ).placement->node - 1;
    uint32_t low = 0, end = scene->node_run_count;
    while ( low < end )
    {
        uint32_t middle = low + ( end - low ) / 2;
        if ( scene->node_runs[middle].first <= triangle )
            low = middle + 1;
        else
            end = middle;
    }
    return low > 0 ? scene->node_runs[low - 1].node - 1 : -1;
}

const char* rf_object_name( const RfScene* scene, int node )
{
    if ( node < 0 )
        return "unnamed";
    return scene->nodes[node].object != NULL ? scene->nodes[node].object : scene->nodes[node].name;
}

const char* rf_asset_name( const RfScene* scene, int node )
{
    int top = node;
    for ( ; node >= 0; node = scene->nodes[node].parent )
    {
        if ( scene->nodes[node].asset != NULL )
            return scene->nodes[node].asset;
        top = node;
    }
    return rf_object_name( scene, top );
}

void rf_list_object_indices( const RfScene* scene, float* of_node )
{
    bool any = false;
    for ( int n = 0; n < scene->node_count; ++n )
        any = any || scene->nodes[n].pass_index != 0;
    of_node[0] = 0.0f;
    for ( int n = 0; n < scene->node_count; ++n )
        of_node[n + 1] = (float)( any ? scene->nodes[n].pass_index : 1 + n );
}

void rf_list_material_indices( const RfScene* scene, float* of_material )
{
    bool any = false;
    for ( uint32_t m = 0; m < scene->material_count; ++m )
        any = any || scene->materials[m].pass_index != 0;
    for ( uint32_t m = 0; m < scene->material_count; ++m )
        of_material[m] = (float)( any ? (int)scene->materials[m].pass_index : 1 + (int)m );
}

void rf_mark_objects( const RfScene* scene, bool* has_surfaces )
{
    for ( int n = 0; n <= scene->node_count; ++n )
        has_surfaces[n] = false;
    has_surfaces[0] = scene->triangles.count > 0 && ( scene->node_run_count == 0 || scene->node_runs[0].first > 0 );
    for ( uint32_t i = 0; i < scene->node_run_count; ++i )
        has_surfaces[scene->node_runs[i].node] |= scene->node_runs[i].first < scene->triangles.count;
    for ( int i = 0; i < scene->placement_count; ++i )
        has_surfaces[scene->placements[i].node] = true;
}
