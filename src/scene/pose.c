// Poses a scene: moving nodes in one pass, parents first, then what hangs on them.
#include "scene/pose.h"

#include "base/fault.h"
#include "base/file.h"
#include "scene/animation.h"
#include "scene/deformation.h"
#include "scene/movement.h"
#include "scene/pose_changes.h"
#include "scene/pose_images.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Where the volume of a unit cube is less than this part of the cube of its longest edge, a matrix is not inverted.
#define FLAT_RATIO 1e-9

// Where the parts of a pose are in its memory, in bytes.
typedef struct Layout
{
    size_t placements, meshes;
    size_t worlds, shown;             // of moving nodes
    size_t joints, weights, mirrored; // of one mover at a time
    size_t arrays;                    // of the meshes that deform
    size_t changes;                   // lamps and materials
    size_t images;                    // of textures
    int own_meshes;
    size_t total;
} Layout;

// A pose in the making.
typedef struct Posing
{
    const RfScene* scene;
    const RfMovement* movement;
    double time, shown_at;
    RfPosedScene* pose;
    RfPlacement* placements;
    RfMesh* meshes;
    int mesh_count;
    RfMat4* worlds;
    bool* shown;
    RfMat4* joints;
    double* weights;
    bool* mirrored;
    char* arrays; // of the next mesh
    RfError* error;
} Posing;

static size_t take( size_t* total, size_t count, size_t size )
{
    size_t at = *total;
    *total += ( count * size + 63 ) / 64 * 64;
    return at;
}

static const RfMesh* mesh_of( const RfScene* scene, int mover )
{
    return scene->meshes + scene->placements[scene->still_placement_count + mover].mesh;
}

// Whether the pose may need a mesh of its own for the mover.
static bool needs_mesh( const RfScene* scene, int mover )
{
    const RfMover* self = scene->movement->movers + mover;
    return self->flattens || self->settles || mesh_of( scene, mover )->deformation != NULL;
}

// Gives the arrays that deform to a mesh from `memory`, which may be NULL, and returns their bytes.
static size_t lay_out_mesh( const RfTriangles* from, char* memory, RfTriangles* to )
{
    size_t total = 0, vertices = from->vertex_count;
    size_t positions = take( &total, vertices, 3 * sizeof *to->positions ),
           normals = take( &total, vertices, 3 * sizeof *to->normals ),
           tangents = take( &total, from->tangents != NULL ? vertices : 0, 4 * sizeof *to->tangents ),
           indices = take( &total, from->count, 3 * sizeof *to->indices );
    if ( memory == NULL )
        return total;
    to->positions = (float*)(void*)( memory + positions );
    to->normals = (float*)(void*)( memory + normals );
    to->tangents = (float*)(void*)( memory + tangents );
    to->indices = (uint32_t*)(void*)( memory + indices );
    return total;
}

static size_t larger( size_t a, size_t b ) { return a > b ? a : b; }

static Layout lay_out( const RfScene* scene, bool images )
{
    Layout layout = { 0 };
    const RfMovement* movement = scene->movement;
    size_t vertices = 0, joints = 0, weights = 0, arrays = 0;
    for ( int i = 0; i < movement->mover_count; ++i )
    {
        const RfMover* mover = movement->movers + i;
        const RfTriangles* t = &mesh_of( scene, i )->triangles;
        if ( mover->skin >= 0 )
            joints = larger( joints, (size_t)movement->skins[mover->skin].joint_count );
        weights = larger( weights, (size_t)mover->target_count );
        if ( !needs_mesh( scene, i ) )
            continue;
        vertices = larger( vertices, t->vertex_count );
        arrays += lay_out_mesh( t, NULL, NULL );
        layout.own_meshes += 1;
    }
    layout.placements = take( &layout.total, (size_t)scene->placement_count, sizeof( RfPlacement ) );
    layout.meshes = take( &layout.total, (size_t)( scene->mesh_count + layout.own_meshes ), sizeof( RfMesh ) );
    layout.worlds = take( &layout.total, (size_t)movement->node_count, sizeof( RfMat4 ) );
    layout.shown = take( &layout.total, (size_t)movement->node_count, sizeof( bool ) );
    layout.joints = take( &layout.total, joints, sizeof( RfMat4 ) );
    layout.weights = take( &layout.total, weights, sizeof( double ) );
    layout.mirrored = take( &layout.total, vertices, sizeof( bool ) );
    layout.arrays = take( &layout.total, arrays, 1 );
    layout.changes = take( &layout.total, rf_changes_bytes( scene ), 1 );
    layout.images = take( &layout.total, images ? rf_images_bytes( scene ) : 0, 1 );
    return layout;
}

size_t rf_pose_bytes( const RfScene* scene ) { return scene->movement != NULL ? lay_out( scene, true ).total : 0; }

RfPoseParts rf_pose_parts( const RfScene* scene )
{
    RfPoseParts parts = { 0 };
    for ( int i = 0; scene->movement != NULL && i < scene->movement->mover_count; ++i )
    {
        uint32_t count = mesh_of( scene, i )->triangles.count;
        if ( !needs_mesh( scene, i ) )
            continue;
        parts.meshes += 1;
        parts.triangles += count;
        parts.most_triangles = count > parts.most_triangles ? count : parts.most_triangles;
    }
    parts.image_bytes = rf_image_scratch( scene );
    return parts;
}

static void find_nodes( const Posing* p )
{
    for ( int i = 0; i < p->movement->node_count; ++i )
    {
        const RfMovingNode* self = p->movement->nodes + i;
        RfMat4 local;
        double shows = p->scene->nodes[self->node].hidden ? 0.0 : 1.0;
        rf_node_local_matrix( p->scene, self->node, p->time, &local );
        if ( self->shows >= 0 )
            rf_sample_channel( p->scene->channels + self->shows, p->shown_at, &shows );
        p->worlds[i] = self->parent >= 0 ? rf_mat4_mul( p->worlds + self->parent, &local ) : local;
        p->shown[i] = shows != 0.0 && ( self->parent < 0 || p->shown[self->parent] );
    }
}

// `world` times `local`, relative to the origin of the scene.
static RfMat4 place( const Posing* p, int node, const RfMat4* local )
{
    RfMat4 matrix = rf_mat4_mul( p->worlds + node, local );
    for ( int c = 0; c < 3; ++c )
        matrix.m[12 + c] -= p->scene->origin[c];
    return matrix;
}

static void find_joints( const Posing* p, const RfSkin* skin )
{
    for ( int i = 0; i < skin->joint_count; ++i )
        p->joints[i] = place( p, skin->joints[i], skin->inverse_binds + i );
}

static void find_weights( const Posing* p, const RfMover* mover )
{
    if ( mover->weights_moved >= 0 )
        rf_sample_channel( p->scene->channels + mover->weights_moved, p->time, p->weights );
    else if ( mover->target_count > 0 )
        memcpy( p->weights, mover->weights, (size_t)mover->target_count * sizeof *p->weights );
}

// Finds joints and weights of a mover, and the matrix of one without a skin. Returns whether it is shown.
static bool follow( const Posing* p, const RfMover* mover, RfMat4* matrix, uint64_t* hash )
{
    bool shown = p->shown[mover->node];
    *matrix = rf_mat4_identity();
    *hash = rf_hash_bytes( *hash, &shown, sizeof shown );
    if ( !shown )
        return false;
    find_weights( p, mover );
    if ( mover->target_count > 0 )
        *hash = rf_hash_bytes( *hash, p->weights, (size_t)mover->target_count * sizeof *p->weights );
    if ( mover->skin >= 0 )
    {
        const RfSkin* skin = p->movement->skins + mover->skin;
        find_joints( p, skin );
        *hash = rf_hash_bytes( *hash, p->joints, (size_t)skin->joint_count * sizeof *p->joints );
        return true;
    }
    *matrix = place( p, mover->node, &mover->local );
    *hash = rf_hash_bytes( *hash, matrix, sizeof *matrix );
    return true;
}

typedef enum Extent
{
    GONE, // a point
    FLAT, // not to be inverted
    SOLID,
} Extent;

static double largest_scale( const RfMat4* matrix )
{
    double largest = 0.0;
    for ( int c = 0; c < 3; ++c )
    {
        const double* m = matrix->m + 4 * c;
        largest = fmax( largest, sqrt( m[0] * m[0] + m[1] * m[1] + m[2] * m[2] ) );
    }
    return largest;
}

static Extent extent_of( const RfMat4* matrix, const RfMesh* mesh, bool flattens )
{
    double scale = largest_scale( matrix ), volume = fabs( rf_mat4_det3( matrix ) );
    RfVec3 span = rf_sub( mesh->bounds_max, mesh->bounds_min );
    double size = scale * (double)rf_largest_coordinate( span );
    if ( scale == 0.0 || ( mesh->deformation == NULL && size * size < RF_MIN_DOUBLE_AREA ) )
        return GONE;
    if ( volume > FLAT_RATIO * scale * scale * scale || RF_FAULT( flat_matrix ) )
        return SOLID;
    return flattens ? FLAT : volume > 0.0 ? SOLID : GONE;
}

static RfResult fail_beyond( const Posing* p, const RfMover* mover, double at )
{
    int node = p->movement->nodes[mover->node].node;
    return rf_fail( p->error, RF_ERROR_SCENE, "%s: object '%.80s' at %g s: a vertex is at %g, beyond %g: scale the scene down",
                    p->scene->path, p->scene->nodes[node].name, p->time, at, RF_MAX_COORDINATE );
}

static RfResult check_bounds( const Posing* p, const RfMover* mover, const RfMesh* mesh, const RfMat4* matrix )
{
    const RfVec3 *low = &mesh->bounds_min, *high = &mesh->bounds_max;
    for ( int i = 0; i < 8; ++i )
    {
        double corner[3] = { (double)( ( i & 1 ) != 0 ? low->x : high->x ), (double)( ( i & 2 ) != 0 ? low->y : high->y ),
                             (double)( ( i & 4 ) != 0 ? low->z : high->z ) };
        double placed[3];
        rf_mat4_apply( matrix, corner, 1.0, placed );
        for ( int c = 0; c < 3; ++c )
        {
            // written so that NaN fails
            if ( !( fabs( placed[c] ) <= RF_MAX_COORDINATE ) )
                return fail_beyond( p, mover, placed[c] );
        }
    }
    return RF_OK;
}

// Deforms the mesh of a mover. With `flat` its matrix is applied as well.
static RfResult deform( Posing* p, const RfMover* mover, const RfMesh* mesh, RfMesh* own, bool flat, RfPlacement* placement )
{
    RfDeformer by = { .least_area = RF_MIN_DOUBLE_AREA };
    RfMat4 matrix = placement->matrix;
    by.weights = mover->target_count > 0 ? p->weights : NULL;
    if ( mover->skin >= 0 )
        by.joints = p->joints;
    else if ( flat )
        by.matrix = &matrix;
    else
        by.least_area /= largest_scale( &matrix ) * largest_scale( &matrix );
    RfDeformed deformed = rf_deform_mesh( mesh, &by, p->mirrored, own );
    if ( !( deformed.beyond == 0.0 ) )
        return fail_beyond( p, mover, deformed.beyond );
    placement->mesh = (int)( own - p->meshes );
    placement->shown = deformed.whole > 0;
    if ( by.joints != NULL || by.matrix != NULL )
        placement->matrix = rf_mat4_identity();
    return check_bounds( p, mover, own, &placement->matrix );
}

static RfResult pose_mover( Posing* p, int i )
{
    const RfMover* mover = p->movement->movers + i;
    const RfMesh* mesh = mesh_of( p->scene, i );
    RfPlacement* placement = p->placements + p->scene->still_placement_count + i;
    RfMesh* own = NULL;
    if ( needs_mesh( p->scene, i ) )
    {
        own = p->meshes + p->mesh_count++;
        p->arrays += lay_out_mesh( &mesh->triangles, p->arrays, &own->triangles );
    }
    placement->shown = follow( p, mover, &placement->matrix, &p->pose->hash );
    if ( !placement->shown )
        return RF_OK;
    bool skinned = mover->skin >= 0;
    Extent extent = skinned ? SOLID : extent_of( &placement->matrix, mesh, mover->flattens );
    placement->shown = extent != GONE;
    bool flat = extent == FLAT || mover->settles || ( p->pose->in_shutter && own != NULL );
    if ( extent == GONE || ( mesh->deformation == NULL && !flat ) )
        return check_bounds( p, mover, mesh, &placement->matrix );
    return deform( p, mover, mesh, own, flat, placement );
}

static Posing begin( const RfScene* scene, double time, const Layout* layout, char* memory, RfError* error )
{
    return ( Posing ){
        .scene = scene,
        .movement = scene->movement,
        .time = time,
        .shown_at = time,
        .placements = (RfPlacement*)(void*)( memory + layout->placements ),
        .meshes = (RfMesh*)(void*)( memory + layout->meshes ),
        .mesh_count = scene->mesh_count,
        .worlds = (RfMat4*)(void*)( memory + layout->worlds ),
        .shown = (bool*)( memory + layout->shown ),
        .joints = (RfMat4*)(void*)( memory + layout->joints ),
        .weights = (double*)(void*)( memory + layout->weights ),
        .mirrored = (bool*)( memory + layout->mirrored ),
        .arrays = memory + layout->arrays,
        .error = error,
    };
}

static RfResult no_memory( const RfScene* scene, RfError* error )
{
    return rf_fail( error, RF_ERROR_MEMORY, "%s: the system has no memory left for what moves: close other programs",
                    scene->path );
}

RfResult rf_pose_scene( const RfScene* scene, double time, RfPosedScene* pose, RfError* error )
{
    pose->time = time;
    pose->scene = *scene;
    pose->hash = RF_HASH_START;
    if ( scene->movement == NULL )
        return RF_OK;
    Layout layout = lay_out( scene, !pose->places_alone );
    if ( pose->memory == NULL )
    {
        pose->memory = aligned_alloc( 64, layout.total );
        pose->owned = true;
    }
    if ( pose->memory == NULL )
        return no_memory( scene, error );
    Posing p = begin( scene, time, &layout, pose->memory, error );
    p.pose = pose;
    if ( pose->in_shutter && !pose->places_alone )
        p.shown_at = pose->middle;
    if ( scene->placement_count > 0 )
        memcpy( p.placements, scene->placements, (size_t)scene->placement_count * sizeof *p.placements );
    if ( scene->mesh_count > 0 )
        memcpy( p.meshes, scene->meshes, (size_t)scene->mesh_count * sizeof *p.meshes );
    memset( p.meshes + scene->mesh_count, 0, (size_t)layout.own_meshes * sizeof *p.meshes );
    if ( scene->placement_count > 0 )
        pose->scene.placements = p.placements;
    pose->scene.meshes = p.meshes;
    pose->scene.mesh_count = scene->mesh_count + layout.own_meshes;
    find_nodes( &p );
    RfResult result = RF_OK;
    for ( int i = 0; result == RF_OK && i < p.movement->mover_count; ++i )
        result = pose_mover( &p, i );
    if ( p.shown_at != time )
    {
        time = p.time = p.shown_at;
        find_nodes( &p ); // of lamps
    }
    RfNodesAt nodes = { time, p.worlds, p.shown };
    pose->hash = rf_hash_images( scene, time, rf_hash_changes( scene, &nodes, pose->hash ) );
    if ( result == RF_OK )
        result = rf_pose_changes( scene, &nodes, (char*)pose->memory + layout.changes, &pose->scene, error );
    if ( result == RF_OK && !pose->places_alone )
        result = rf_pose_images( scene, time, (char*)pose->memory + layout.images, &pose->scene, error );
    return result;
}

void rf_destroy_pose( RfPosedScene* pose )
{
    if ( pose->owned )
        free( pose->memory );
    memset( pose, 0, sizeof *pose );
}

// Of all, or of places and shapes alone.
static RfResult hash_moment( const RfScene* scene, double time, bool all, uint64_t* hash, RfError* error )
{
    *hash = RF_HASH_START;
    if ( scene->movement == NULL )
        return RF_OK;
    // what is found on the way alone, none of the meshes
    Layout layout = lay_out( scene, false );
    layout.total = layout.mirrored - layout.worlds;
    char* memory = layout.total > 0 ? aligned_alloc( 64, layout.total ) : NULL;
    if ( memory == NULL && layout.total > 0 )
        return no_memory( scene, error );
    Layout moved = { .shown = layout.shown - layout.worlds,
                     .joints = layout.joints - layout.worlds,
                     .weights = layout.weights - layout.worlds };
    Posing p = begin( scene, time, &moved, memory, error );
    find_nodes( &p );
    for ( int i = 0; i < p.movement->mover_count; ++i )
    {
        RfMat4 matrix;
        follow( &p, p.movement->movers + i, &matrix, hash );
    }
    RfNodesAt nodes = { time, p.worlds, p.shown };
    if ( all )
        *hash = rf_hash_images( scene, time, rf_hash_changes( scene, &nodes, *hash ) );
    free( memory );
    return RF_OK;
}

RfResult rf_moment_hash( const RfScene* scene, double time, uint64_t* hash, RfError* error )
{
    return hash_moment( scene, time, true, hash, error );
}

static bool differs( const RfScene* scene, double t0, double t1, bool all )
{
    uint64_t before, after;
    if ( scene->movement == NULL || t0 == t1 )
        return false;
    return hash_moment( scene, t0, all, &before, NULL ) != RF_OK || hash_moment( scene, t1, all, &after, NULL ) != RF_OK ||
           before != after;
}

bool rf_scene_moves( const RfScene* scene, double t0, double t1 ) { return differs( scene, t0, t1, true ); }

bool rf_surfaces_move( const RfScene* scene, double t0, double t1 ) { return differs( scene, t0, t1, false ); }
