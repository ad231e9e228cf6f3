// What moves, deforms, or is shown at times only: which nodes do, and how they become meshes, placements and movers.
#include "base/try.h"
#include "gltf/gltf_document.h"

#include "scene/merge.h"
#include "scene/placement.h"
#include "scene/pose.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_MOVERS ( 1 << 20 )

// Where the determinant is less than this part of the cube of the longest edge, a matrix may lose a dimension as it moves.
#define FLAT_RATIO 1e-6

#define BOUNDS_SAMPLES 16 // times at which the bounds are taken

// The channel of a node that animates `path`, or −1.
static int find_channel( const RfScene* scene, int node, RfAnimatedPath path )
{
    int count;
    const RfChannel* channels = rf_node_channels( scene, node, &count );
    for ( int i = 0; i < count; ++i )
    {
        if ( channels[i].path == path )
            return (int)( channels + i - scene->channels );
    }
    return -1;
}

RfGltfVisibility rf_gltf_visibility( const RfGltf* gltf, int node )
{
    const RfScene* scene = gltf->scene;
    RfGltfVisibility found = RF_GLTF_SHOWN;
    for ( ; node >= 0; node = scene->nodes[node].parent )
    {
        int index = find_channel( scene, node, RF_VISIBILITY );
        const RfChannel* channel = index >= 0 ? scene->channels + index : NULL;
        double shown = scene->nodes[node].hidden ? 0.0 : 1.0;
        if ( channel != NULL )
            rf_sample_channel( channel, rf_gltf_rest_time( gltf, node ), &shown );
        if ( channel != NULL && !gltf->freeze && rf_channel_varies( channel ) )
            found = RF_GLTF_SHOWN_AT_TIMES;
        else if ( shown == 0.0 )
            return RF_GLTF_HIDDEN;
    }
    return found;
}

// Whether the mesh of a node has another shape than without its morph targets.
static RfResult is_morphed( const RfGltf* gltf, int node, int mesh, bool* morphed )
{
    int count;
    *morphed = find_channel( gltf->scene, node, RF_WEIGHTS ) >= 0;
    RfResult result = rf_gltf_mesh_targets( gltf, mesh, &count );
    if ( result != RF_OK || *morphed || count == 0 )
        return result;
    double* weights;
    RF_TRY( rf_gltf_allocate( gltf, "meshes", &weights, (size_t)count, sizeof *weights ) );
    result = rf_gltf_read_rest_weights( gltf, node, mesh, count, weights );
    for ( int i = 0; result == RF_OK && i < count; ++i )
        *morphed = *morphed || weights[i] != 0.0;
    free( weights );
    return result;
}

// How many primitives of a mesh have a material that changes.
static uint32_t count_changing( const RfGltf* gltf, int mesh )
{
    uint32_t count = 0;
    if ( !rf_gltf_has_changing( gltf ) )
        return 0;
    RfField primitives = rf_gltf_primitives( gltf, mesh );
    for ( size_t i = 0; i < json_array_size( primitives.json ); ++i )
    {
        RfField primitive = rf_field_item( &primitives, i );
        count += rf_gltf_primitive_changes( gltf, &primitive );
    }
    return count;
}

RfResult rf_gltf_set_apart( RfGltf* gltf, int node )
{
    RfGltfNode* self = gltf->nodes + node;
    bool morphed;
    RfGltfVisibility visibility = rf_gltf_visibility( gltf, node );
    RfResult result = is_morphed( gltf, node, self->mesh, &morphed );
    if ( result == RF_OK && gltf->freeze && rf_gltf_changes( gltf, node ) )
        result = rf_gltf_note_moving( gltf, gltf->scene->nodes[node].name );
    bool still = visibility == RF_GLTF_SHOWN && self->skin < 0 && !morphed && ( gltf->freeze || !rf_gltf_varies( gltf, node ) );
    if ( !still )
        self->here = -1;
    if ( visibility != RF_GLTF_HIDDEN )
        self->apart = !still ? RF_GLTF_APART : count_changing( gltf, self->mesh ) > 0 ? RF_GLTF_PART_APART : RF_GLTF_NOT_APART;
    return result;
}

// What is set apart, in the making.
typedef struct Builder
{
    RfGltf* gltf;
    RfMovement* movement;
    bool* used; // by skin
} Builder;

static RfResult begin( Builder* b )
{
    RfGltf* gltf = b->gltf;
    b->movement = rf_open_movement( gltf->scene );
    b->used = calloc( (size_t)gltf->counts[RF_GLTF_SKINS_LIST] + 1, sizeof *b->used );
    if ( b->movement != NULL )
        b->movement->nodes = malloc( ( (size_t)gltf->scene->node_count + 1 ) * sizeof *b->movement->nodes );
    return b->used != NULL && b->movement != NULL && b->movement->nodes != NULL ? rf_gltf_load_skins( gltf, b->movement )
                                                                                : rf_gltf_no_memory( gltf, "nodes" );
}

// Adds a node and the ancestors that it lacks, from the top, and returns its place.
static int add_moving_node( Builder* b, int node )
{
    const RfScene* scene = b->gltf->scene;
    RfGltfNode* nodes = b->gltf->nodes;
    while ( nodes[node].moving < 0 )
    {
        int top = node;
        while ( scene->nodes[top].parent >= 0 && nodes[scene->nodes[top].parent].moving < 0 )
            top = scene->nodes[top].parent;
        int parent = scene->nodes[top].parent;
        nodes[top].moving = b->movement->node_count;
        b->movement->nodes[b->movement->node_count++] = ( RfMovingNode ){ .node = top,
                                                                          .parent = parent >= 0 ? nodes[parent].moving : -1,
                                                                          .shows = find_channel( scene, top, RF_VISIBILITY ) };
    }
    return nodes[node].moving;
}

// Joints become moving nodes, of the skins that are used.
static void use_skin( Builder* b, int skin )
{
    RfSkin* self = b->movement->skins + skin;
    for ( int i = 0; !b->used[skin] && i < self->joint_count; ++i )
        self->joints[i] = add_moving_node( b, self->joints[i] );
    b->used[skin] = true;
}

static bool does_skin_move( const Builder* b, int skin )
{
    const RfSkin* self = b->movement->skins + skin;
    for ( int i = 0; i < self->joint_count; ++i )
    {
        if ( rf_gltf_varies( b->gltf, b->movement->nodes[self->joints[i]].node ) )
            return true;
    }
    return false;
}

static RfResult add_mesh( Builder* b, const RfGltfShape* shape, int* index )
{
    RfScene* scene = b->gltf->scene;
    if ( !rf_gltf_grow( &scene->meshes, scene->mesh_count, sizeof *scene->meshes ) )
        return rf_gltf_no_memory( b->gltf, "meshes" );
    *index = scene->mesh_count++;
    memset( scene->meshes + *index, 0, sizeof *scene->meshes );
    return rf_gltf_read_shape( b->gltf, shape, scene->meshes + *index );
}

static RfResult find_mesh( Builder* b, const RfGltfShape* shape, int* index )
{
    int* known = b->gltf->uses[shape->use].shapes + ( shape->changing_only ? 3 : shape->skinned ? 2 : shape->deforms ? 1 : 0 );
    RfResult result = *known >= 0 ? RF_OK : add_mesh( b, shape, known );
    *index = *known;
    return result;
}

static bool is_flat( const RfMat4* m )
{
    double longest = 0.0;
    for ( int c = 0; c < 12; c += 4 )
        longest = fmax( longest, sqrt( m->m[c] * m->m[c] + m->m[c + 1] * m->m[c + 1] + m->m[c + 2] * m->m[c + 2] ) );
    return !( fabs( rf_mat4_det3( m ) ) > FLAT_RATIO * longest * longest * longest );
}

// Scales that stand still multiply, whatever turns between them.
static bool may_flatten( const RfGltf* gltf, int node, const RfMat4* local )
{
    const RfScene* scene = gltf->scene;
    if ( rf_gltf_has_varying( gltf, node, RF_SCALE, RF_SCALE ) )
        return true;
    RfMat4 world = *local;
    for ( ; node >= 0; node = scene->nodes[node].parent )
    {
        RfMat4 own;
        rf_node_local_matrix( scene, node, 0.0, &own );
        world = rf_mat4_mul( &own, &world );
    }
    return is_flat( &world );
}

static RfResult reserve_mover( Builder* b )
{
    RfScene* scene = b->gltf->scene;
    int count = b->movement->mover_count;
    if ( count >= MAX_MOVERS )
        return rf_gltf_fail( b->gltf, RF_ERROR_UNSUPPORTED, "nodes", "more than %d objects move: join some", MAX_MOVERS );
    bool room = rf_gltf_grow( &b->movement->movers, count, sizeof *b->movement->movers ) &&
                rf_gltf_grow( &scene->placements, scene->placement_count, sizeof *scene->placements );
    return room ? RF_OK : rf_gltf_no_memory( b->gltf, "nodes" );
}

// What the movers of one node have in common.
typedef struct Common
{
    int node, document_mesh, mesh;
    uint32_t primitives; // of the mesh
    bool part;           // those primitives alone whose materials change
    bool still;          // it deforms, but does not move
    RfMover mover;
} Common;

static RfResult read_weights( const Builder* b, const Common* common, RfMover* mover )
{
    if ( mover->target_count == 0 )
        return RF_OK;
    RF_TRY( rf_gltf_allocate( b->gltf, "nodes", &mover->weights, (size_t)mover->target_count, sizeof *mover->weights ) );
    return rf_gltf_read_rest_weights( b->gltf, common->node, common->document_mesh, mover->target_count, mover->weights );
}

static RfResult add_mover( Builder* b, const Common* common, const RfMat4* local )
{
    RfScene* scene = b->gltf->scene;
    RF_TRY( reserve_mover( b ) );
    int index = b->movement->mover_count++;
    RfMover* mover = b->movement->movers + index;
    *mover = common->mover;
    mover->local = *local;
    mover->settles = common->still;
    mover->flattens = mover->skin < 0 && may_flatten( b->gltf, common->node, local );
    scene->placements[scene->placement_count++] =
        ( RfPlacement ){ .mesh = common->mesh, .matrix = rf_mat4_identity(), .mover = index, .node = 1 + common->node };
    scene->instance_count += common->primitives;
    return read_weights( b, common, mover );
}

// A skin places its mesh, wherever the node is.
static RfResult add_instances( Builder* b, const Common* common )
{
    RfGltfInstances instances;
    RF_TRY( rf_gltf_open_instances( b->gltf, common->node, &instances ) );
    if ( common->mover.skin >= 0 && instances.translation + instances.rotation + instances.scale > -3 )
    {
        RfWhere where = rf_where( "nodes[%d]", common->node );
        return rf_gltf_fail( b->gltf, RF_ERROR_UNSUPPORTED, where.text,
                             "instances with a skin are not read: use one node for each" );
    }
    for ( uint32_t i = 0; i < instances.count; ++i )
    {
        RfMat4 local = { 0 };
        RF_TRY( rf_gltf_instance_matrix( b->gltf, &instances, i, &local ) );
        RF_TRY( add_mover( b, common, &local ) );
    }
    return RF_OK;
}

static RfResult check_joints( const Builder* b, const Common* common )
{
    const RfDeformation* deformation = b->gltf->scene->meshes[common->mesh].deformation;
    if ( common->mover.skin < 0 )
        return RF_OK;
    int joints = b->movement->skins[common->mover.skin].joint_count;
    if ( deformation->joint_count <= joints )
        return RF_OK;
    RfWhere where = rf_where( "nodes[%d]", common->node );
    return rf_gltf_fail( b->gltf, RF_ERROR_FORMAT, where.text, "its mesh follows joint %d, but its skin has %d joints",
                         deformation->joint_count - 1, joints );
}

static bool weights_vary( const RfScene* scene, const RfMover* mover )
{
    return mover->weights_moved >= 0 && rf_channel_varies( scene->channels + mover->weights_moved );
}

// Reads what the movers of a node have in common.
static RfResult describe( Builder* b, Common* common )
{
    RfGltf* gltf = b->gltf;
    RfScene* scene = gltf->scene;
    const RfGltfNode* node = gltf->nodes + common->node;
    RfMover* mover = &common->mover;
    bool morphed = false;
    common->document_mesh = node->mesh;
    mover->skin = node->skin;
    RfResult result = is_morphed( gltf, common->node, common->document_mesh, &morphed );
    if ( result != RF_OK )
        return result;
    const json_t* mesh = rf_gltf_item( gltf, RF_GLTF_MESHES, common->document_mesh );
    uint32_t changing = count_changing( gltf, common->document_mesh );
    common->primitives = common->part ? changing : (uint32_t)json_array_size( json_object_get( mesh, "primitives" ) );
    if ( mover->skin >= 0 )
        use_skin( b, mover->skin );
    mover->node = add_moving_node( b, common->node );
    mover->weights_moved = morphed ? find_channel( scene, common->node, RF_WEIGHTS ) : -1;
    if ( morphed )
        result = rf_gltf_mesh_targets( gltf, common->document_mesh, &mover->target_count );
    bool travels = mover->skin >= 0 ? does_skin_move( b, mover->skin ) : rf_gltf_varies( gltf, common->node );
    travels = travels || weights_vary( scene, mover ) || rf_gltf_visibility( gltf, common->node ) != RF_GLTF_SHOWN;
    common->still = ( !travels && changing == 0 ) || gltf->freeze;
    if ( result == RF_OK && travels )
        result = rf_gltf_note_moving( gltf, scene->nodes[common->node].name );
    RfGltfShape shape = { node->use, morphed || mover->skin >= 0, mover->skin >= 0, common->part };
    if ( result == RF_OK )
        result = find_mesh( b, &shape, &common->mesh );
    return result == RF_OK ? check_joints( b, common ) : result;
}

// `part`: of its primitives those alone whose materials change.
static RfResult place_node( Builder* b, int node, bool part )
{
    RfScene* scene = b->gltf->scene;
    Common common = { .node = node, .part = part };
    RfResult result = describe( b, &common );
    if ( result != RF_OK || scene->meshes[common.mesh].triangles.count == 0 )
        return result;
    return add_instances( b, &common );
}

// Takes the movers of what stands still out, after appending it as it is posed to the triangles of the scene.
static RfResult settle( Builder* b, const RfPosedScene* pose )
{
    RfScene* scene = b->gltf->scene;
    RfMovement* movement = b->movement;
    int kept = 0, first = scene->still_placement_count;
    for ( int i = 0; i < movement->mover_count; ++i )
    {
        RfMover mover = movement->movers[i];
        const RfPlacement* posed = pose->scene.placements + first + i;
        if ( mover.settles )
        {
            if ( posed->shown && ( !rf_begin_node_run( scene, posed->node - 1 ) ||
                                   !rf_append_triangles( &scene->triangles, &pose->scene.meshes[posed->mesh].triangles, 0 ) ) )
                return rf_gltf_no_memory( b->gltf, "meshes" );
            free( mover.weights );
            movement->movers[i].weights = NULL;
            continue;
        }
        movement->movers[i].weights = NULL;
        movement->movers[kept] = mover;
        scene->placements[first + kept] = scene->placements[first + i];
        scene->placements[first + kept].mover = kept;
        kept += 1;
    }
    movement->mover_count = kept;
    scene->placement_count = first + kept;
    return RF_OK;
}

static bool any_settles( const RfMovement* movement )
{
    for ( int i = 0; i < movement->mover_count; ++i )
    {
        if ( movement->movers[i].settles )
            return true;
    }
    return false;
}

static RfResult settle_still( Builder* b )
{
    RfPosedScene pose = { 0 };
    if ( !any_settles( b->movement ) )
        return RF_OK;
    double time = b->gltf->freeze ? b->gltf->frozen_at : b->movement->start;
    RfResult result = rf_pose_scene( b->gltf->scene, time, &pose, b->gltf->error );
    if ( result == RF_OK )
        result = settle( b, &pose );
    rf_destroy_pose( &pose );
    return result;
}

// Frees the meshes that are no longer placed.
static RfResult drop_meshes( const RfGltf* gltf )
{
    RfScene* scene = gltf->scene;
    int kept = 0, *renumbered = malloc( ( (size_t)scene->mesh_count + 1 ) * sizeof *renumbered );
    if ( renumbered == NULL )
        return rf_gltf_no_memory( gltf, "meshes" );
    memset( renumbered, 0xff, (size_t)scene->mesh_count * sizeof *renumbered );
    for ( int i = 0; i < scene->placement_count; ++i )
        renumbered[scene->placements[i].mesh] = 0;
    for ( int i = 0; i < scene->mesh_count; ++i )
    {
        if ( renumbered[i] < 0 )
        {
            rf_destroy_triangles( &scene->meshes[i].triangles );
            rf_destroy_deformation( scene->meshes[i].deformation );
            continue;
        }
        renumbered[i] = kept;
        scene->meshes[kept++] = scene->meshes[i];
    }
    for ( int i = 0; i < scene->placement_count; ++i )
        scene->placements[i].mesh = renumbered[scene->placements[i].mesh];
    scene->mesh_count = kept;
    free( renumbered );
    return RF_OK;
}

static void widen( RfMovement* movement, const RfChannel* channel )
{
    double start, end;
    rf_channel_span( channel, &start, &end );
    movement->start = fmin( movement->start, start );
    movement->end = fmax( movement->end, end );
}

static void find_span( const RfScene* scene, RfMovement* movement )
{
    movement->start = (double)INFINITY;
    movement->end = -(double)INFINITY;
    for ( int i = 0; i < movement->node_count; ++i )
    {
        int count;
        const RfChannel* channels = rf_node_channels( scene, movement->nodes[i].node, &count );
        for ( int c = 0; c < count; ++c )
        {
            if ( channels[c].path != RF_WEIGHTS )
                widen( movement, channels + c );
        }
    }
    for ( int i = 0; i < movement->mover_count; ++i )
    {
        if ( movement->movers[i].weights_moved >= 0 )
            widen( movement, scene->channels + movement->movers[i].weights_moved );
    }
    for ( int i = 0; i < movement->change_count; ++i )
        widen( movement, &movement->changes[i].channel );
    if ( movement->start > movement->end )
        movement->start = movement->end = 0.0;
}

static void grow_by_placement( RfScene* scene, bool* any, const RfPlacement* placement, const RfMesh* mesh )
{
    for ( int i = 0; placement->shown && i < 8; ++i )
    {
        const RfVec3 *low = &mesh->bounds_min, *high = &mesh->bounds_max;
        double corner[3] = { (double)( ( i & 1 ) != 0 ? low->x : high->x ), (double)( ( i & 2 ) != 0 ? low->y : high->y ),
                             (double)( ( i & 4 ) != 0 ? low->z : high->z ) };
        double at[3];
        rf_mat4_apply( &placement->matrix, corner, 1.0, at );
        rf_grow_bounds( &scene->bounds_min, &scene->bounds_max, !*any, rf_vec3( (float)at[0], (float)at[1], (float)at[2] ) );
        *any = true;
    }
}

// Around what moves as well, at times throughout: a measure of the scene's size, nothing that must hold it.
static RfResult widen_bounds( Builder* b, uint32_t first_triangle )
{
    RfScene* scene = b->gltf->scene;
    const RfTriangles* t = &scene->triangles;
    RfPosedScene pose = { 0 };
    RfResult result = RF_OK;
    bool any = first_triangle > 0 || scene->still_placement_count > 0;
    for ( size_t i = 3 * (size_t)first_triangle; i < 3 * (size_t)t->count; ++i )
    {
        const float* p = t->positions + 3 * (size_t)t->indices[i];
        rf_grow_bounds( &scene->bounds_min, &scene->bounds_max, !any, rf_vec3( p[0], p[1], p[2] ) );
        any = true;
    }
    for ( int k = 0; result == RF_OK && ( b->movement->mover_count > 0 || b->movement->lamp_count > 0 ) && k <= BOUNDS_SAMPLES;
          ++k )
    {
        double part = (double)k / BOUNDS_SAMPLES;
        double time = b->movement->start + part * ( b->movement->end - b->movement->start );
        result = rf_pose_scene( scene, time, &pose, b->gltf->error );
        for ( int i = scene->still_placement_count; result == RF_OK && i < scene->placement_count; ++i )
        {
            const RfPlacement* placement = pose.scene.placements + i;
            grow_by_placement( scene, &any, placement, pose.scene.meshes + placement->mesh );
            if ( k == 0 && placement->mesh < scene->mesh_count ) // as it starts
                scene->placements[i] = *placement;
        }
        for ( int i = 0; result == RF_OK && k == 0 && i < b->movement->lamp_count; ++i )
        {
            const RfPunctual* lamp = pose.scene.punctuals + b->movement->lamps[i].punctual;
            scene->punctuals[b->movement->lamps[i].punctual].position = lamp->position;
            scene->punctuals[b->movement->lamps[i].punctual].direction = lamp->direction;
            scene->punctuals[b->movement->lamps[i].punctual].across = lamp->across;
        }
    }
    rf_destroy_pose( &pose );
    return result;
}

static RfResult place_all( Builder* b )
{
    RfGltf* gltf = b->gltf;
    RfScene* scene = gltf->scene;
    RfResult result = begin( b );
    for ( RfGltfApart apart = RF_GLTF_APART; apart <= RF_GLTF_PART_APART; ++apart )
    {
        for ( int i = 0; result == RF_OK && i < gltf->order_count; ++i )
        {
            if ( gltf->nodes[gltf->order[i]].apart == apart )
                result = place_node( b, gltf->order[i], apart == RF_GLTF_PART_APART );
        }
    }
    for ( int i = 0; result == RF_OK && i < gltf->lamp_count; ++i )
    {
        RfMovingLamp* lamp = gltf->lamps + i;
        lamp->node = lamp->node >= 0 ? add_moving_node( b, lamp->node ) : -1;
    }
    if ( result == RF_OK )
        result = rf_gltf_move_changes( gltf, b->movement );
    if ( result != RF_OK )
        return result;
    find_span( scene, b->movement );
    uint32_t before = scene->triangles.count;
    RF_TRY( settle_still( b ) );
    RF_TRY( drop_meshes( gltf ) );
    RF_TRY( rf_number_placements( scene, gltf->error ) );
    RF_TRY( widen_bounds( b, before ) );
    rf_drop_empty_movement( scene );
    return RF_OK;
}

RfResult rf_gltf_place_movers( RfGltf* gltf )
{
    Builder builder = { .gltf = gltf };
    bool any = gltf->lamp_count + gltf->moving_material_count > 0;
    for ( int i = 0; i < gltf->order_count; ++i )
        any = any || gltf->nodes[gltf->order[i]].apart != RF_GLTF_NOT_APART;
    RfResult result = any ? place_all( &builder ) : RF_OK;
    free( builder.used );
    return result;
}
