// Which surface a triangle number names: its placement and where that puts it, its node, and what objects are called.
#include "scene/placement.h"

#include "scene/deformation.h"

#include <stdlib.h>

bool rf_begin_node_run( RfScene* scene, int node )
{
    uint32_t count = scene->node_run_count, first = scene->triangles.count;
    if ( count > 0 && scene->node_runs[count - 1].node == 1 + node )
        return true;
    if ( count == 0 || scene->node_runs[count - 1].first != first ) // else the last one is empty
    {
        if ( !rf_make_room( &scene->node_runs, count, sizeof *scene->node_runs ) )
            return false;
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

RfTriangleAt rf_locate_placed_triangle( const RfScene* scene, uint32_t triangle )
{
    if ( scene->placement_count == 0 ) // a scene without triangles
        return ( RfTriangleAt ){ &scene->triangles, triangle, NULL };
    const RfPlacement* placements = scene->placements;
    const uint32_t* block = scene->placement_blocks + ( ( triangle - scene->triangles.count ) >> scene->placement_shift );
    uint32_t low = block[0], high = block[1];
    while ( low < high )
    {
        uint32_t middle = low + ( high - low + 1 ) / 2;
        if ( placements[middle].first <= triangle )
            low = middle;
        else
            high = middle - 1;
    }
    const RfPlacement* p = placements + low;
    return ( RfTriangleAt ){ &scene->meshes[p->mesh].triangles, triangle - p->first, p };
}

RfVec3 rf_place_direction( const RfMat4* matrix, RfVec3 d )
{
    double in[3] = { (double)d.x, (double)d.y, (double)d.z }, out[3];
    rf_mat4_apply( matrix, in, 0.0, out );
    double length = sqrt( out[0] * out[0] + out[1] * out[1] + out[2] * out[2] );
    if ( !( length > 0.0 && length <= DBL_MAX ) )
        return rf_vec3( 0, 0, 0 );
    return rf_vec3( (float)( out[0] / length ), (float)( out[1] / length ), (float)( out[2] / length ) );
}

RfVec3 rf_placed_corner( const RfScene* scene, uint32_t triangle, int corner )
{
    RfTriangleAt at = rf_locate_placed_triangle( scene, triangle );
    return rf_place_point( &at.placement->matrix, rf_corner( at.triangles, at.index, corner ) );
}

RfTriangleList rf_triangle_list( const RfScene* scene, int list )
{
    if ( list == 0 )
        return ( RfTriangleList ){ &scene->triangles, 1 };
    const RfMesh* mesh = scene->meshes + list - 1;
    return ( RfTriangleList ){ &mesh->triangles, mesh->uses };
}

void rf_mark_used_materials( const RfScene* scene, bool* used )
{
    for ( int k = 0; k < rf_triangle_list_count( scene ); ++k )
    {
        const RfTriangles* t = rf_triangle_list( scene, k ).triangles;
        for ( uint32_t i = 0; i < t->count; ++i )
            used[t->material[i]] = true;
    }
}

// Those of one list, whose numbers begin at `first`.
static uint32_t list_triangles( const RfScene* scene, const RfTriangles* t, uint32_t first, bool ( *is )( const RfMaterial* ),
                                uint32_t* numbers )
{
    uint32_t count = 0;
    bool found = false;
    for ( uint32_t i = 0; i < t->count; ++i )
    {
        if ( i == 0 || t->material[i] != t->material[i - 1] )
            found = is( scene->materials + t->material[i] );
        if ( !found )
            continue;
        if ( numbers != NULL )
            numbers[count] = first + i;
        count += 1;
    }
    return count;
}

uint32_t rf_list_triangles( const RfScene* scene, bool ( *is )( const RfMaterial* ), uint32_t* numbers )
{
    uint32_t count = list_triangles( scene, &scene->triangles, 0, is, numbers ), in_mesh = 0;
    int mesh = -1;
    for ( int i = 0; i < scene->placement_count; ++i )
    {
        const RfPlacement* p = scene->placements + i;
        const RfTriangles* t = &scene->meshes[p->mesh].triangles;
        if ( p->mesh != mesh ) // most meshes have none: they are looked at once
            in_mesh = list_triangles( scene, t, 0, is, NULL );
        mesh = p->mesh;
        if ( in_mesh == 0 || !p->shown )
            continue;
        if ( numbers != NULL )
            list_triangles( scene, t, p->first, is, numbers + count );
        count += in_mesh;
    }
    return count;
}

static bool is_inside( const RfScene* scene, RfVec3 p )
{
    return p.x >= scene->bounds_min.x && p.y >= scene->bounds_min.y && p.z >= scene->bounds_min.z && p.x <= scene->bounds_max.x &&
           p.y <= scene->bounds_max.y && p.z <= scene->bounds_max.z;
}

// By the corners of the mesh's box first: what is in the midst of others needs no look at its vertices.
static void grow_by_placement( RfScene* scene, const RfPlacement* placement )
{
    const RfMesh* mesh = scene->meshes + placement->mesh;
    const RfVec3 box[2] = { mesh->bounds_min, mesh->bounds_max };
    bool inside = true;
    for ( int k = 0; k < 8 && inside; ++k )
        inside = is_inside( scene,
                            rf_place_point( &placement->matrix, rf_vec3( box[k & 1].x, box[k >> 1 & 1].y, box[k >> 2 & 1].z ) ) );
    const float* p = mesh->triangles.positions;
    for ( uint32_t v = 0; v < mesh->triangles.vertex_count && !inside; ++v )
        rf_grow_bounds( &scene->bounds_min, &scene->bounds_max, false,
                        rf_place_point( &placement->matrix, rf_load_vec3( p, v ) ) );
}

static void bound_placements( RfScene* scene )
{
    if ( scene->triangles.count == 0 )
    {
        scene->bounds_min = rf_vec3( INFINITY, INFINITY, INFINITY );
        scene->bounds_max = rf_vec3( -INFINITY, -INFINITY, -INFINITY );
    }
    for ( int i = 0; i < scene->placement_count; ++i )
    {
        if ( scene->placements[i].shown )
            grow_by_placement( scene, scene->placements + i );
    }
    if ( scene->bounds_min.x > scene->bounds_max.x )
        scene->bounds_min = scene->bounds_max = rf_vec3( 0, 0, 0 );
}

// Blocks of so many triangles that most begin in the placement in which they end.
static RfResult index_placements( RfScene* scene, RfError* error )
{
    uint32_t all = rf_triangle_count( scene ) - scene->triangles.count, p = 0;
    scene->placement_shift = 0;
    while ( all >> scene->placement_shift > 4u * (uint32_t)scene->placement_count )
        scene->placement_shift += 1;
    uint32_t blocks = ( all >> scene->placement_shift ) + 1, last = (uint32_t)scene->placement_count - 1;
    free( scene->placement_blocks );
    scene->placement_blocks = malloc( ( (size_t)blocks + 1 ) * sizeof *scene->placement_blocks );
    if ( scene->placement_blocks == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for %d instances", scene->placement_count );
    for ( uint32_t b = 0; b < blocks; ++b )
    {
        uint64_t first = scene->triangles.count + ( (uint64_t)b << scene->placement_shift );
        while ( p < last && scene->placements[p + 1].first <= first )
            p += 1;
        scene->placement_blocks[b] = p;
    }
    scene->placement_blocks[blocks] = last;
    return RF_OK;
}

RfResult rf_number_placements( RfScene* scene, RfError* error )
{
    uint64_t count = scene->triangles.count;
    scene->still_placement_count = 0;
    for ( int m = 0; m < scene->mesh_count; ++m )
        scene->meshes[m].uses = 0;
    for ( int i = 0; i < scene->placement_count; ++i )
    {
        RfPlacement* p = scene->placements + i;
        p->first = (uint32_t)count;
        count += scene->meshes[p->mesh].triangles.count;
        scene->meshes[p->mesh].uses += 1;
        scene->still_placement_count += p->mover < 0;
        if ( count > RF_MOST_TRIANGLES )
            return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: nodes: more than %u triangles in all: split the scene",
                            scene->path != NULL ? scene->path : "scene", RF_MOST_TRIANGLES );
    }
    scene->triangle_count = (uint32_t)count;
    return scene->placement_count > 0 ? index_placements( scene, error ) : RF_OK;
}

RfResult rf_finish_placements( RfScene* scene, RfError* error )
{
    RfResult result = rf_number_placements( scene, error );
    if ( result == RF_OK && scene->placement_count > 0 )
        bound_placements( scene );
    return result;
}

double rf_placement_spread( const RfMat4* matrix )
{
    double det = fabs( rf_mat4_det3( matrix ) ), cofactor[3][3], most = 0.0;
    if ( !( det > 0.0 && det <= DBL_MAX ) )
        return INFINITY;
    for ( int c = 0; c < 3; ++c )
    {
        double unit[3] = { c == 0, c == 1, c == 2 };
        rf_mat4_apply_cofactor( matrix, unit, cofactor[c] ); // row c of the inverse, times det
    }
    for ( int r = 0; r < 3; ++r )
    {
        double sum = 0.0;
        for ( int c = 0; c < 3; ++c )
        {
            double row = 0.0;
            for ( int k = 0; k < 3; ++k )
                row += fabs( matrix->m[4 * k + r] ) * fabs( cofactor[k][c] );
            sum += row;
        }
        most = fmax( most, sum );
    }
    return most / det;
}
