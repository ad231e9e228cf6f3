// Meshes: each primitive is read once and baked for every node that instances its mesh, so
// that the reader never holds more than one primitive.

#include "scene/gltf/gltf_geometry.h"

#include "scene/animation.h"
#include "scene/camera.h"

#include <stdlib.h>

// Nodes sorted by mesh: those of mesh m are nodes[starts[m]] up to nodes[starts[m+1]].
typedef struct Instances
{
    int* mesh_of; // by position in the order
    size_t* starts;
    int* nodes;
    RfMat4* worlds; // by node
} Instances;

static void free_instances( Instances* instances )
{
    free( instances->mesh_of );
    free( instances->starts );
    free( instances->nodes );
    free( instances->worlds );
}

static RfResult create_instances( const RfGltf* gltf, Instances* out )
{
    size_t nodes = (size_t)gltf->scene->node_count + 1, meshes = (size_t)gltf->counts[RF_GLTF_MESHES] + 2;
    out->mesh_of = malloc( nodes * sizeof *out->mesh_of );
    out->starts = calloc( meshes, sizeof *out->starts );
    out->nodes = malloc( nodes * sizeof *out->nodes );
    out->worlds = malloc( nodes * sizeof *out->worlds );
    if ( out->mesh_of == NULL || out->starts == NULL || out->nodes == NULL || out->worlds == NULL )
        return rf_gltf_no_memory( gltf, "nodes" );
    return RF_OK;
}

static RfResult read_mesh_of( RfGltf* gltf, int node, int* mesh )
{
    RfWhere where = rf_where( "nodes[%d]", node );
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_NODES, node );
    const char* name = gltf->scene->nodes[node].name;
    RfResult result = rf_gltf_get_index( gltf, json, where.text, "mesh", RF_GLTF_MESHES, mesh );
    if ( result != RF_OK )
        return result;
    rf_gltf_notice_extensions( gltf, json, "node", name );
    if ( *mesh < 0 )
        return RF_OK;
    if ( json_object_get( json, "skin" ) != NULL )
        rf_gltf_notice( gltf, RF_GLTF_SKINS, "skins are not supported: node '%.80s' keeps its rest pose", name );
    return rf_gltf_varies( gltf, node ) ? rf_gltf_note_moving( gltf, name ) : RF_OK;
}

// Counting sort of the nodes by mesh, stable in the order of the scene.
static RfResult sort_instances( RfGltf* gltf, Instances* out )
{
    for ( int i = 0; i < gltf->order_count; ++i )
    {
        RfResult result = read_mesh_of( gltf, gltf->order[i], out->mesh_of + i );
        if ( result != RF_OK )
            return result;
        if ( out->mesh_of[i] >= 0 )
            out->starts[out->mesh_of[i] + 2] += 1;
    }
    for ( int m = 0; m < gltf->counts[RF_GLTF_MESHES]; ++m )
        out->starts[m + 2] += out->starts[m + 1];
    for ( int i = 0; i < gltf->order_count; ++i )
    {
        if ( out->mesh_of[i] >= 0 )
            out->nodes[out->starts[out->mesh_of[i] + 1]++] = gltf->order[i];
    }
    return RF_OK;
}

// World matrices from the root down. Animated nodes are placed at their first key.
static void find_worlds( const RfGltf* gltf, const Instances* out )
{
    const RfScene* scene = gltf->scene;
    for ( int i = 0; i < gltf->order_count; ++i )
    {
        int node = gltf->order[i], parent = scene->nodes[node].parent;
        if ( rf_gltf_moves( gltf, node ) )
        {
            if ( out->mesh_of[i] >= 0 )
                rf_node_world_matrix( scene, node, gltf->spans[node].start, out->worlds + node );
            continue;
        }
        // a static node has no animated ancestor
        RfMat4 local;
        rf_node_local_matrix( scene, node, 0.0, &local );
        out->worlds[node] = parent >= 0 ? rf_mat4_mul( out->worlds + parent, &local ) : local;
    }
}

static RfResult place_at_node( RfGltf* gltf, RfGltfBaker* baker, const RfGltfPrimitive* primitive, int node, const RfMat4* world,
                               const char* where )
{
    RfGltfInstances instances;
    RfWhere self = rf_where( "%s of nodes[%d]", where, node );
    RfResult result = rf_gltf_open_instances( gltf, node, &instances );
    for ( uint32_t i = 0; result == RF_OK && i < instances.count; ++i )
    {
        RfMat4 local;
        result = rf_gltf_instance_matrix( gltf, &instances, i, &local );
        RfMat4 matrix = result == RF_OK ? rf_mat4_mul( world, &local ) : *world; // multiplying by the identity gives the same
                                                                                 // bits
        for ( int c = 0; c < 3; ++c )
            matrix.m[12 + c] -= gltf->scene->origin[c];
        if ( result == RF_OK )
            result = rf_gltf_bake( gltf, baker, primitive, &matrix, self.text );
    }
    return result;
}

static RfResult place_primitive( RfGltf* gltf, RfGltfBaker* baker, const Instances* instances, int mesh, const json_t* json,
                                 const char* where )
{
    RfGltfPrimitive primitive;
    RfResult result = rf_gltf_read_primitive( gltf, json, where, &primitive );
    if ( result != RF_OK )
        return result;
    size_t end = primitive.triangle_count > 0 ? instances->starts[mesh + 1] : 0;
    for ( size_t i = instances->starts[mesh]; result == RF_OK && i < end; ++i )
    {
        int node = instances->nodes[i];
        result = place_at_node( gltf, baker, &primitive, node, instances->worlds + node, where );
    }
    rf_gltf_free_primitive( &primitive );
    return result;
}

static RfResult place_mesh( RfGltf* gltf, RfGltfBaker* baker, const Instances* instances, int mesh )
{
    RfWhere where = rf_where( "meshes[%d]", mesh );
    const json_t* primitives = NULL;
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_MESHES, mesh );
    RfResult result = rf_gltf_require( gltf, json, where.text, "primitives" );
    if ( result == RF_OK )
        result = rf_gltf_get_array( gltf, json, where.text, "primitives", &primitives );
    for ( size_t i = 0; result == RF_OK && i < json_array_size( primitives ); ++i )
    {
        RfWhere self = rf_where( "meshes[%d].primitives[%zu]", mesh, i );
        const json_t* primitive = json_array_get( primitives, i );
        if ( json_is_object( primitive ) == 0 )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, self.text, "wants an object" );
        result = place_primitive( gltf, baker, instances, mesh, primitive, self.text );
    }
    return result;
}

RfResult rf_gltf_load_meshes( RfGltf* gltf )
{
    Instances instances = { 0 };
    RfGltfBaker baker = { 0 };
    RfResult result = create_instances( gltf, &instances );
    if ( result == RF_OK )
        result = sort_instances( gltf, &instances );
    if ( result == RF_OK )
        find_worlds( gltf, &instances );
    for ( int m = 0; result == RF_OK && m < gltf->counts[RF_GLTF_MESHES]; ++m )
    {
        if ( instances.starts[m] < instances.starts[m + 1] )
            result = place_mesh( gltf, &baker, &instances, m );
    }
    rf_gltf_finish_bake( gltf, &baker );
    free_instances( &instances );
    return result;
}
