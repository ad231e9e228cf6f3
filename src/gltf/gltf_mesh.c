// Meshes: the primitives of all instances are baked into the triangles of the scene, or once into a mesh that is placed.
#include "base/try.h"
#include "gltf/gltf_document.h"

#include "scene/camera.h"
#include "scene/placement.h"

#include <math.h>
#include <stdlib.h>

// Each primitive is read once and baked for every node that instances its mesh, so that the reader never holds more than one.
// Meshes whose copies would take much memory are kept once, in their own space, and placed. Not so what is easier to have in
// world space: what emits (lights are triangles there), what may be a flat mirror, what moves, and what a matrix distorts so much
// that Embree would be far off.

// Of Embree and of the tables, measured: of a triangle in world space, and of a placement.
#define TRIANGLE_BYTES 230.0
#define PLACEMENT_BYTES 900.0

// Meshes are placed where that saves so much in all, those that save at least so much each. Rays take longer where they pass
// boxes of instances that overlap.
#define LEAST_SAVED ( 64.0 * 1048576.0 )
#define LEAST_SAVED_EACH 1048576.0

// The most by which a matrix may make Embree's errors grow (rf_placement_spread), and stretch.
#define MOST_SPREAD 100.0
#define MOST_STRETCH 1e6

// In all, so that a small file cannot ask for any amount of memory.
#define MAX_PLACEMENTS ( 1u << 24 )

// Finds what stands still: the nodes of each use of a mesh, in the order of the scene.
static RfResult find_nodes( RfGltf* gltf )
{
    for ( int i = 0; i < gltf->order_count; ++i )
    {
        int index = gltf->order[i];
        RfGltfNode* node = gltf->nodes + index;
        RfField json = rf_gltf_item_field( gltf, RF_GLTF_NODES, index );
        node->here = node->use;
        rf_gltf_notice_extensions( gltf, &json, "node", gltf->scene->nodes[index].name );
        if ( node->here >= 0 )
            RF_TRY( rf_gltf_set_apart( gltf, index ) );
    }
    for ( int i = gltf->order_count - 1; i >= 0; --i )
    {
        RfGltfNode* node = gltf->nodes + gltf->order[i];
        if ( node->here < 0 )
            continue;
        node->next = gltf->uses[node->here].first;
        gltf->uses[node->here].first = gltf->order[i];
    }
    return RF_OK;
}

// World matrices from the root down. Nodes whose keys are equal are placed at the first.
static void find_worlds( const RfGltf* gltf, RfMat4* worlds )
{
    const RfScene* scene = gltf->scene;
    for ( int i = 0; i < gltf->order_count; ++i )
    {
        int node = gltf->order[i], parent = scene->nodes[node].parent;
        if ( rf_gltf_moves( gltf, node ) )
        {
            if ( gltf->nodes[node].here >= 0 )
                rf_node_world_matrix( scene, node, rf_gltf_rest_time( gltf, node ), worlds + node );
            continue;
        }
        // a static node has no animated ancestor
        RfMat4 local;
        rf_node_local_matrix( scene, node, 0.0, &local );
        worlds[node] = parent >= 0 ? rf_mat4_mul( worlds + parent, &local ) : local;
    }
}

// A node keeps the mesh in world space if it moves or has a skin.
static bool is_still( const RfGltf* gltf, int node )
{
    return ( gltf->freeze || !rf_gltf_varies( gltf, node ) ) && gltf->nodes[node].skin < 0;
}

// Frobenius norm: at least as much as edges become longer.
static double stretch_of( const RfMat4* matrix )
{
    double squares = 0.0;
    for ( int k = 0; k < 12; ++k )
        squares += k % 4 < 3 ? matrix->m[k] * matrix->m[k] : 0.0;
    return sqrt( squares );
}

// Whether Embree can be left to invert the matrix. Written so that NaN fails.
static bool is_fit( const RfMat4* matrix )
{
    double stretch = stretch_of( matrix );
    return rf_placement_spread( matrix ) <= MOST_SPREAD && stretch >= 1.0 / MOST_STRETCH && stretch <= MOST_STRETCH;
}

// One of the places of a mesh.
typedef struct Place
{
    int node;
    RfMat4 matrix;
    bool fit; // for a placement
} Place;

typedef RfResult Visit( RfGltf* gltf, const Place* place, void* user );

static RfResult visit_node( RfGltf* gltf, int node, const RfMat4* world, Visit* visit, void* user )
{
    RfGltfInstances instances;
    bool still = is_still( gltf, node );
    RfResult result = rf_gltf_open_instances( gltf, node, &instances );
    for ( uint32_t i = 0; result == RF_OK && i < instances.count; ++i )
    {
        RfMat4 local = { 0 };
        Place place = { .node = node };
        result = rf_gltf_instance_matrix( gltf, &instances, i, &local );
        if ( result != RF_OK )
            return result;
        place.matrix = rf_mat4_mul( world, &local ); // multiplying by the identity gives the same bits
        for ( int c = 0; c < 3; ++c )
            place.matrix.m[12 + c] -= gltf->scene->origin[c];
        place.fit = still && is_fit( &place.matrix );
        result = visit( gltf, &place, user );
    }
    return result;
}

// Visits all places of a mesh.
static RfResult visit_places( RfGltf* gltf, const RfMat4* worlds, int use, Visit* visit, void* user )
{
    for ( int node = gltf->uses[use].first; node >= 0; node = gltf->nodes[node].next )
        RF_TRY( visit_node( gltf, node, worlds + node, visit, user ) );
    return RF_OK;
}

// A primitive that is baked into the triangles of the scene.
typedef struct Bake
{
    RfGltfBaker* baker;
    const RfGltfPrimitive* primitive;
    const char* where;
    bool unfit_only; // it is in a mesh that is placed wherever it can be
} Bake;

static RfResult bake_at( RfGltf* gltf, const Place* place, void* user )
{
    const Bake* bake = user;
    gltf->scene->instance_count += 1;
    if ( place->fit && bake->unfit_only )
        return RF_OK;
    RfWhere where = rf_where( "%s of nodes[%d]", bake->where, place->node );
    if ( !rf_begin_node_run( gltf->scene, place->node ) )
        return rf_gltf_no_memory( gltf, "meshes" );
    return rf_gltf_bake( gltf, bake->baker, bake->primitive, &place->matrix, where.text );
}

static bool emits( const RfMaterial* m ) { return rf_max_component( m->emission ) > 0.0f; }

// As scene/mirrors.c has it; textures that are optional may be dropped later.
static bool may_be_mirror( const RfMaterial* m )
{
    return m->kind == RF_BSDF_GLASS && m->alpha == 0.0f && ( m->textured == NULL || m->textured->optional );
}

// Whether some triangle has the same normal at its corners.
static bool has_flat_triangle( const RfGltfPrimitive* p )
{
    for ( size_t i = 0; i < p->t.count; ++i )
    {
        const float *a = p->t.normals + 3 * (size_t)p->t.indices[3 * i], *b = p->t.normals + 3 * (size_t)p->t.indices[3 * i + 1],
                    *c = p->t.normals + 3 * (size_t)p->t.indices[3 * i + 2];
        float most = 0.0f;
        for ( int k = 0; k < 3; ++k )
            most = rf_maxf( most, rf_maxf( fabsf( b[k] - a[k] ), fabsf( c[k] - a[k] ) ) );
        if ( most < 1e-3f )
            return true;
    }
    return false;
}

static bool can_be_placed( const RfScene* scene, const RfGltfPrimitive* p )
{
    const RfMaterial* m = scene->materials + p->material;
    return !emits( m ) && !( may_be_mirror( m ) && has_flat_triangle( p ) );
}

// A mesh that is being placed, the scene's next.
typedef struct Placing
{
    RfMesh mesh;
    RfGltfBaker baker; // of the mesh
    int first;         // of its placements
    double stretch;    // the most of them
} Placing;

static RfResult add_placement( RfGltf* gltf, const Place* place, void* user )
{
    RfScene* scene = gltf->scene;
    Placing* placing = user;
    if ( !place->fit )
        return RF_OK;
    if ( !rf_gltf_grow( &scene->placements, scene->placement_count, sizeof *scene->placements ) )
        return rf_gltf_no_memory( gltf, "nodes" );
    placing->stretch = fmax( placing->stretch, stretch_of( &place->matrix ) );
    scene->placements[scene->placement_count++] = ( RfPlacement ){
        .mesh = scene->mesh_count, .matrix = place->matrix, .shown = true, .mover = -1, .node = 1 + place->node
    };
    return RF_OK;
}

static RfResult add_mesh( RfGltf* gltf, Placing* placing )
{
    RfScene* scene = gltf->scene;
    if ( !rf_gltf_grow( &scene->meshes, scene->mesh_count, sizeof *scene->meshes ) )
        return rf_gltf_no_memory( gltf, "meshes" );
    scene->meshes[scene->mesh_count++] = placing->mesh;
    placing->mesh = ( RfMesh ){ 0 };
    return RF_OK;
}

// The vertices of a placement that may be too far out.
static RfResult check_coordinates( const RfGltf* gltf, const RfMesh* mesh, const RfPlacement* p, const char* where )
{
    double reach = fmax( (double)rf_largest_coordinate( mesh->bounds_min ), (double)rf_largest_coordinate( mesh->bounds_max ) );
    double shift = fmax( fabs( p->matrix.m[12] ), fmax( fabs( p->matrix.m[13] ), fabs( p->matrix.m[14] ) ) );
    uint32_t vertices = shift + 2.0 * stretch_of( &p->matrix ) * reach <= RF_MAX_COORDINATE ? 0 : mesh->triangles.vertex_count;
    for ( size_t v = 0; v < vertices; ++v )
    {
        const float* own = mesh->triangles.positions + 3 * v;
        float at = rf_largest_coordinate( rf_place_point( &p->matrix, rf_vec3( own[0], own[1], own[2] ) ) );
        if ( !( (double)at <= RF_MAX_COORDINATE ) )
            return rf_gltf_fail( gltf, RF_ERROR_SCENE, where, "a vertex is at %g, beyond %g: scale the scene down", (double)at,
                                 RF_MAX_COORDINATE );
    }
    return RF_OK;
}

// Adds the mesh to the scene, unless nothing of it can be placed.
static RfResult finish_mesh( RfGltf* gltf, RfGltfBaker* baker, Placing* placing, const char* where )
{
    RfScene* scene = gltf->scene;
    int places = scene->placement_count - placing->first;
    rf_gltf_finish_baker( &placing->baker );
    placing->mesh.bounds_min = placing->baker.bounds_min;
    placing->mesh.bounds_max = placing->baker.bounds_max;
    if ( baker->degenerate == 0 )
        baker->first_degenerate = placing->baker.first_degenerate;
    baker->degenerate += placing->baker.degenerate * (uint64_t)places;
    if ( places == 0 || placing->mesh.triangles.count == 0 )
    {
        scene->placement_count = placing->first;
        return RF_OK;
    }
    for ( int i = placing->first; i < scene->placement_count; ++i )
    {
        RF_TRY( check_coordinates( gltf, &placing->mesh, scene->placements + i, where ) );
    }
    return add_mesh( gltf, placing );
}

static RfResult load_primitive( RfGltf* gltf, RfGltfBaker* baker, Placing* placing, const RfMat4* worlds, int use,
                                const RfField* json )
{
    const char* where = json->path;
    static const RfMat4 own = { { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 } };
    RfGltfPrimitive primitive;
    if ( rf_gltf_primitive_changes( gltf, json ) ) // a mover
        return RF_OK;
    RfResult result = rf_gltf_read_primitive( gltf, json, false, &primitive );
    if ( result != RF_OK || primitive.t.count == 0 )
        return result;
    primitive.material = rf_gltf_tagged_material( gltf, use, primitive.material );
    Bake bake = { baker, &primitive, where, placing != NULL && can_be_placed( gltf->scene, &primitive ) };
    if ( bake.unfit_only )
        result = rf_gltf_bake( gltf, &placing->baker, &primitive, &own, where );
    if ( result == RF_OK )
        result = visit_places( gltf, worlds, use, bake_at, &bake );
    rf_gltf_free_primitive( &primitive );
    return result;
}

static RfResult load_primitives( RfGltf* gltf, RfGltfBaker* baker, Placing* placing, const RfMat4* worlds, int use )
{
    RfField primitives = rf_gltf_primitives( gltf, gltf->uses[use].mesh );
    RfResult result = rf_json_result( &primitives );
    for ( size_t i = 0; result == RF_OK && i < json_array_size( primitives.json ); ++i )
    {
        RfField primitive = rf_field_item( &primitives, i );
        result = load_primitive( gltf, baker, placing, worlds, use, &primitive );
    }
    return result;
}

static RfResult place_mesh( RfGltf* gltf, RfGltfBaker* baker, const RfMat4* worlds, int use )
{
    Placing placing = { .first = gltf->scene->placement_count };
    RfMesh* own = &placing.mesh;
    RfWhere where = rf_where( "meshes[%d]", gltf->uses[use].mesh );
    RfResult result = visit_places( gltf, worlds, use, add_placement, &placing );
    double scale = fmax( placing.stretch, 1.0 / MOST_STRETCH );
    placing.baker = ( RfGltfBaker ){ .triangles = &own->triangles, .least_double_area = RF_MIN_DOUBLE_AREA / ( scale * scale ) };
    if ( result == RF_OK )
        result = load_primitives( gltf, baker, &placing, worlds, use );
    if ( result == RF_OK )
        result = finish_mesh( gltf, baker, &placing, where.text );
    rf_gltf_finish_baker( &placing.baker );
    rf_destroy_triangles( &own->triangles );
    return result;
}

// What placing a mesh would save.
typedef struct Saving
{
    uint64_t places, triangles; // of one place
    double bytes;
} Saving;

static RfResult count_places( RfGltf* gltf, int use, uint64_t* places )
{
    RfResult result = RF_OK;
    *places = 0;
    for ( int node = gltf->uses[use].first; result == RF_OK && node >= 0; node = gltf->nodes[node].next )
    {
        RfGltfInstances here = { 0 };
        if ( is_still( gltf, node ) )
            result = rf_gltf_open_instances( gltf, node, &here );
        *places += here.count;
    }
    return result;
}

static RfResult find_saving( RfGltf* gltf, int use, Saving* saving )
{
    *saving = ( Saving ){ 0 };
    RfResult result = count_places( gltf, use, &saving->places );
    if ( result != RF_OK || saving->places < 2 )
        return result;
    RfField primitives = rf_gltf_primitives( gltf, gltf->uses[use].mesh );
    result = rf_json_result( &primitives );
    for ( size_t i = 0; result == RF_OK && i < json_array_size( primitives.json ); ++i )
    {
        RfField primitive = rf_field_item( &primitives, i );
        RfGltfPrimitive survey;
        result = rf_gltf_read_primitive( gltf, &primitive, true, &survey );
        const RfMaterial* material = gltf->scene->materials + survey.material;
        if ( result == RF_OK && survey.t.count > 0 && !emits( material ) && !material->changes )
            saving->triangles += survey.t.count;
    }
    double places = (double)saving->places;
    saving->bytes = ( places - 1.0 ) * (double)saving->triangles * TRIANGLE_BYTES - places * PLACEMENT_BYTES;
    return result;
}

static RfResult choose_placed( RfGltf* gltf )
{
    int count = gltf->use_count;
    uint64_t places = 0;
    double triangles = 0.0, bytes = 0.0;
    for ( int m = 0; m < count; ++m )
    {
        Saving saving;
        RF_TRY( find_saving( gltf, m, &saving ) );
        if ( saving.bytes < LEAST_SAVED_EACH || places + saving.places > MAX_PLACEMENTS )
            continue;
        gltf->uses[m].placed = true;
        bytes += saving.bytes;
        places += saving.places;
        triangles += (double)saving.places * (double)saving.triangles;
    }
    if ( triangles > (double)RF_MOST_TRIANGLES ) // rather than run out of memory first
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, "nodes", "place more than %u triangles: split the scene",
                             RF_MOST_TRIANGLES );
    for ( int m = 0; bytes < LEAST_SAVED && m < count; ++m )
        gltf->uses[m].placed = false;
    return RF_OK;
}

RfResult rf_gltf_load_meshes( RfGltf* gltf )
{
    RfScene* scene = gltf->scene;
    RfGltfBaker baker = { .triangles = &scene->triangles, .least_double_area = RF_MIN_DOUBLE_AREA };
    RfMat4* worlds = malloc( ( (size_t)scene->node_count + 1 ) * sizeof *worlds ); // by node
    RfResult result = worlds != NULL ? find_nodes( gltf ) : rf_gltf_no_memory( gltf, "nodes" );
    if ( result == RF_OK )
        find_worlds( gltf, worlds );
    if ( result == RF_OK )
        result = choose_placed( gltf );
    for ( int u = 0; result == RF_OK && u < gltf->use_count; ++u )
    {
        if ( gltf->uses[u].first >= 0 )
            result =
                gltf->uses[u].placed ? place_mesh( gltf, &baker, worlds, u ) : load_primitives( gltf, &baker, NULL, worlds, u );
    }
    rf_gltf_finish_baker( &baker );
    scene->bounds_min = baker.bounds_min;
    scene->bounds_max = baker.bounds_max;
    gltf->degenerate = baker.degenerate;
    gltf->first_degenerate = baker.first_degenerate;
    free( worlds );
    if ( result == RF_OK )
        result = rf_finish_placements( scene, gltf->error );
    return result == RF_OK ? rf_gltf_place_movers( gltf ) : result;
}
