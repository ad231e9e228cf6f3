// The scene at a moment: places and shapes, lamps and materials, and images.
#include "scene/pose.h"

#include "base/fault.h"
#include "base/file.h"
#include "base/try.h"
#include "scene/movement.h"
#include "scene/deformation.h"
#include "scene/texture.h"
#include "scene/textured.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Where the moving nodes are at a time, and whether they are shown.
typedef struct NodesAt
{
    double time;
    const RfMat4* worlds;
    const bool* shown;
} NodesAt;

// What reading one of them takes meanwhile.
static size_t image_scratch( const RfScene* scene )
{
    size_t most = 0;
    for ( int i = 0; scene->movement != NULL && i < scene->movement->sequence_count; ++i )
        most = scene->movement->sequences[i].scratch > most ? scene->movement->sequences[i].scratch : most;
    return most;
}

RfResult rf_pose_images( const RfScene* scene, double time, RfLayout* layout, RfScene* posed, RfError* error )
{
    const RfMovement* movement = scene->movement;
    if ( movement->sequence_count == 0 )
        return RF_OK;
    RF_PLACE( layout, posed->textures, scene->texture_count );
    if ( layout->memory != NULL )
        memcpy( posed->textures, scene->textures, (size_t)scene->texture_count * sizeof *posed->textures );
    for ( int i = 0; i < movement->sequence_count; ++i )
    {
        const RfImageSequence* s = movement->sequences + i;
        void* image = rf_take( layout, s->bytes, 1 );
        if ( layout->memory != NULL )
            RF_TRY( rf_place_sequence_image( s, rf_sequence_number( s, time ), image, posed->textures + s->texture, error ) );
    }
    return RF_OK;
}

// Extends a hash by which images they are.
static uint64_t hash_images( const RfScene* scene, double time, uint64_t hash )
{
    for ( int i = 0; i < scene->movement->sequence_count; ++i )
    {
        int number = rf_sequence_number( scene->movement->sequences + i, time );
        hash = rf_hash_bytes( hash, &number, sizeof number );
    }
    return hash;
}

// Lamps.

static RfResult fail_lamp( const RfScene* scene, const RfPunctual* lamp, double time, const char* what, RfError* error )
{
    return rf_fail( error, RF_ERROR_SCENE, "%s: light '%.80s' at %g s: %s", scene->path, lamp->name, time, what );
}

// At the origin of the node, pointing along −z.
static const char* place_lamp( const RfScene* scene, const RfMat4* world, RfPunctual* out )
{
    const double *m = world->m, *origin = scene->origin;
    double at[3];
    for ( int c = 0; c < 3; ++c )
    {
        at[c] = m[12 + c] - origin[c];
        // written so that NaN fails
        if ( !( fabs( at[c] ) <= RF_MAX_COORDINATE ) )
            return "it is too far from the origin: scale the scene down";
    }
    out->position = rf_vec3_of( at, 1.0 );
    if ( out->kind == RF_PUNCTUAL_POINT && !out->turned )
        return NULL;
    return rf_turn_lamp( m, out ) ? NULL : "it has no direction: remove zero scales from its node and from its parents";
}

// Returns what is wrong, or NULL. One that is hidden is where it was loaded.
static const char* pose_lamp( const RfScene* scene, const RfMovingLamp* lamp, const NodesAt* nodes, RfPunctual* out )
{
    const RfMovement* movement = scene->movement;
    RfLampValues now = lamp->values;
    const double* cone = now.cone;
    if ( lamp->node >= 0 && !nodes->shown[lamp->node] )
    {
        out->intensity = rf_vec3( 0.0f, 0.0f, 0.0f );
        return NULL;
    }
    for ( int v = 0; v < RF_CHANGED_LAMP_VALUES; ++v )
    {
        double all[4];
        if ( lamp->changes[v] < 0 )
            continue;
        rf_sample_change( movement->changes + lamp->changes[v], nodes->time, all );
        memcpy( rf_value_in( &now, (RfChangedValue)v ), all,
                (size_t)rf_changed_traits( (RfChangedValue)v )->components * sizeof *all );
    }
    out->intensity = rf_vec3_of( now.color, now.intensity );
    out->range = (float)fmin( now.range, HUGE_VAL );
    if ( !( out->range > 0.0f ) )
        return "its range is not more than 0";
    if ( out->kind == RF_PUNCTUAL_SPOT && !( cone[0] <= cone[1] && cone[1] > 0.0 ) )
        return "the inner angle of its cone is larger than the outer, which must be more than 0";
    if ( out->kind == RF_PUNCTUAL_SPOT )
        rf_set_cone( out, cone[0], cone[1] );
    return lamp->node >= 0 ? place_lamp( scene, nodes->worlds + lamp->node, out ) : NULL;
}

static RfResult pose_lamps( const RfScene* scene, const NodesAt* nodes, RfScene* posed, RfError* error )
{
    const RfMovement* movement = scene->movement;
    if ( movement->lamp_count == 0 )
        return RF_OK;
    memcpy( posed->punctuals, scene->punctuals, (size_t)scene->punctual_count * sizeof *posed->punctuals );
    for ( int i = 0; i < movement->lamp_count; ++i )
    {
        const RfMovingLamp* lamp = movement->lamps + i;
        RfPunctual* out = posed->punctuals + lamp->punctual;
        const char* wrong = pose_lamp( scene, lamp, nodes, out );
        if ( wrong != NULL )
            return fail_lamp( scene, out, nodes->time, wrong, error );
    }
    return RF_OK;
}

static uint64_t hash_lamp( const RfScene* scene, const RfMovingLamp* lamp, const NodesAt* nodes, uint64_t hash )
{
    RfPunctual posed = scene->punctuals[lamp->punctual];
    pose_lamp( scene, lamp, nodes, &posed );
    hash = rf_hash_bytes( hash, &posed.intensity, sizeof posed.intensity );
    if ( !( rf_max_component( posed.intensity ) > 0.0f ) )
        return hash;
    float rest[12] = { posed.position.x,  posed.position.y,  posed.position.z, posed.direction.x,
                       posed.direction.y, posed.direction.z, posed.cos_inner,  posed.cos_outer,
                       posed.range,       posed.across.x,    posed.across.y,   posed.across.z };
    return rf_hash_bytes( hash, rest, sizeof rest );
}

// Materials.

static void sample_materials_change( const RfChange* change, double time, RfMovingMaterial* to )
{
    double v[4];
    const RfChangedTraits* traits = rf_changed_traits( change->value );
    void* values = traits->owner == RF_OF_TEXTURE ? (void*)to->transform[change->slot] : (void*)&to->values;
    rf_sample_change( change, time, v );
    memcpy( rf_value_in( values, change->value ), v, (size_t)traits->components * sizeof *v );
}

static void pose_material( const RfScene* scene, const RfMovingMaterial* self, double time, RfTextured* textured,
                           RfMaterial* out )
{
    RfMovingMaterial now = *self;
    const RfChange* changes = scene->movement->changes + self->first_change;
    for ( int i = 0; i < self->change_count; ++i )
        sample_materials_change( changes + i, time, &now );
    // a loaded one is the most that there is, and 0 where emission is left out
    if ( rf_max_component( out->emission ) > 0.0f )
        out->emission = rf_emission_of( &now.values );
    if ( !out->changes || out->textured == NULL )
        return;
    *textured = *out->textured;
    out->textured = textured;
    if ( textured->model == RF_TEXTURED_DIFFUSE ) // which has a base of its own
        memcpy( now.values.lobes.base, textured->factors.base, 3 * sizeof *now.values.lobes.base );
    textured->factors = now.values.lobes;
    for ( int i = 0; i < self->change_count; ++i )
    {
        if ( rf_changed_traits( changes[i].value )->owner == RF_OF_TEXTURE )
            rf_set_uv_transform( now.transform[changes[i].slot], textured->refs[changes[i].slot].transform );
    }
    RfVec3 emission = out->emission;
    rf_derive_material( out );
    if ( !( rf_max_component( scene->materials[self->material].emission ) > 0.0f ) )
        out->emission = emission;
}

static void pose_materials( const RfScene* scene, double time, RfTextured* textured, RfScene* posed )
{
    const RfMovement* movement = scene->movement;
    if ( movement->material_count == 0 )
        return;
    memcpy( posed->materials, scene->materials, scene->material_count * sizeof *posed->materials );
    for ( int i = 0; i < movement->material_count; ++i )
    {
        const RfMovingMaterial* self = movement->materials + i;
        pose_material( scene, self, time, textured + i, posed->materials + self->material );
    }
}

// The sky.

static void pose_sky( const RfScene* scene, double time, RfScene* posed )
{
    const RfMovement* movement = scene->movement;
    posed->environment.radiance = scene->environment.radiance;
    for ( int i = 0; scene->environment.changes && i < movement->change_count; ++i )
    {
        const RfChange* change = movement->changes + i;
        double v[4];
        if ( !rf_is_of_sky( change->value ) )
            continue;
        rf_sample_change( change, time, v );
        rf_change_sky( &posed->environment, change->value, v );
    }
}

// Poses what changes of `scene` into `posed`, in the layout; without memory it is only measured. Fails with RF_ERROR_SCENE.
static RfResult pose_changes( const RfScene* scene, const NodesAt* nodes, RfLayout* layout, RfScene* posed, RfError* error )
{
    const RfMovement* movement = scene->movement;
    RfTextured* textured = rf_take( layout, (size_t)movement->material_count, sizeof *textured );
    if ( movement->lamp_count > 0 )
        RF_PLACE( layout, posed->punctuals, scene->punctual_count );
    if ( movement->material_count > 0 )
        RF_PLACE( layout, posed->materials, scene->material_count );
    if ( layout->memory == NULL )
        return RF_OK;
    RF_TRY( pose_lamps( scene, nodes, posed, error ) );
    pose_materials( scene, nodes->time, textured, posed );
    pose_sky( scene, nodes->time, posed );
    return RF_OK;
}

// Extends a hash by all of it, without memory.
static uint64_t hash_changes( const RfScene* scene, const NodesAt* nodes, uint64_t hash )
{
    const RfMovement* movement = scene->movement;
    for ( int i = 0; i < movement->lamp_count; ++i )
        hash = hash_lamp( scene, movement->lamps + i, nodes, hash );
    for ( int i = 0; i < movement->change_count; ++i )
    {
        const RfChange* change = movement->changes + i;
        double v[4];
        if ( change->value <= RF_CHANGED_OUTER_CONE )
            continue;
        rf_sample_change( change, nodes->time, v );
        hash = rf_hash_bytes( hash, v, (size_t)rf_changed_traits( change->value )->components * sizeof *v );
    }
    return hash;
}

// Where the volume of a unit cube is less than this part of the cube of its longest edge, a matrix is not inverted.
#define FLAT_RATIO 1e-9

// A pose in the making.
typedef struct Posing
{
    const RfScene* scene;
    const RfMovement* movement;
    double time, shown_at;
    RfPosedScene* pose;
    RfPlacement* placements;
    RfMesh* meshes;
    int mesh_count; // so far
    RfMat4* worlds; // of moving nodes, as the next
    bool* shown;
    RfMat4* joints; // of one mover at a time, as the next
    double* weights;
    bool* mirrored;
    RfError* error;
} Posing;

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

// The arrays of a mesh that deform.
static void place_mesh( const RfTriangles* from, RfLayout* layout, RfTriangles* to )
{
    RF_PLACE( layout, to->positions, 3 * (size_t)from->vertex_count );
    RF_PLACE( layout, to->normals, 3 * (size_t)from->vertex_count );
    RF_PLACE( layout, to->tangents, from->tangents != NULL ? 4 * (size_t)from->vertex_count : 0 );
    RF_PLACE( layout, to->indices, 3 * (size_t)from->count );
}

static size_t larger( size_t a, size_t b ) { return a > b ? a : b; }

// What is found on the way, none of the meshes.
static Posing place_moment( const RfScene* scene, double time, RfLayout* layout, RfError* error )
{
    const RfMovement* movement = scene->movement;
    Posing p = { .scene = scene, .movement = movement, .time = time, .shown_at = time, .error = error };
    size_t joints = 0, weights = 0;
    for ( int i = 0; i < movement->mover_count; ++i )
    {
        const RfMover* mover = movement->movers + i;
        if ( mover->skin >= 0 )
            joints = larger( joints, (size_t)movement->skins[mover->skin].joint_count );
        weights = larger( weights, (size_t)mover->target_count );
    }
    RF_PLACE( layout, p.worlds, movement->node_count );
    RF_PLACE( layout, p.shown, movement->node_count );
    RF_PLACE( layout, p.joints, joints );
    RF_PLACE( layout, p.weights, weights );
    return p;
}

// All but what pose_changes and rf_pose_images take after it.
static Posing place_pose( const RfScene* scene, double time, RfLayout* layout, RfError* error )
{
    Posing p = place_moment( scene, time, layout, error );
    size_t vertices = 0;
    int own = (int)rf_pose_parts( scene ).meshes;
    RF_PLACE( layout, p.placements, scene->placement_count );
    RF_PLACE( layout, p.meshes, scene->mesh_count + own );
    if ( p.meshes != NULL )
        memset( p.meshes + scene->mesh_count, 0, (size_t)own * sizeof *p.meshes );
    p.mesh_count = scene->mesh_count;
    for ( int i = 0; i < p.movement->mover_count; ++i )
    {
        const RfTriangles* t = &mesh_of( scene, i )->triangles;
        if ( !needs_mesh( scene, i ) )
            continue;
        vertices = larger( vertices, t->vertex_count );
        place_mesh( t, layout, p.meshes != NULL ? &p.meshes[p.mesh_count].triangles : NULL );
        p.mesh_count += 1;
    }
    RF_PLACE( layout, p.mirrored, vertices );
    return p;
}

static size_t pose_bytes( const RfScene* scene, bool images )
{
    RfLayout layout = { 0 };
    place_pose( scene, 0.0, &layout, NULL );
    pose_changes( scene, NULL, &layout, NULL, NULL );
    if ( images )
        rf_pose_images( scene, 0.0, &layout, NULL, NULL );
    return layout.bytes;
}

size_t rf_pose_bytes( const RfScene* scene ) { return scene->movement != NULL ? pose_bytes( scene, true ) : 0; }

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
    parts.image_bytes = image_scratch( scene );
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
        own = p->meshes + p->mesh_count++;
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

static RfResult no_memory( const RfScene* scene, RfError* error )
{
    return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory posing what moves: close other programs", scene->path );
}

RfResult rf_pose_scene( const RfScene* scene, double time, RfPosedScene* pose, RfError* error )
{
    pose->time = time;
    pose->scene = *scene;
    pose->hash = RF_HASH_START;
    if ( scene->movement == NULL )
        return RF_OK;
    if ( pose->memory == NULL )
    {
        pose->memory = aligned_alloc( 64, pose_bytes( scene, !pose->places_alone ) );
        pose->owned = true;
    }
    if ( pose->memory == NULL )
        return no_memory( scene, error );
    RfLayout layout = { .memory = pose->memory };
    Posing p = place_pose( scene, time, &layout, error );
    p.pose = pose;
    if ( pose->in_shutter && !pose->places_alone )
        p.shown_at = pose->middle;
    if ( scene->placement_count > 0 )
        memcpy( p.placements, scene->placements, (size_t)scene->placement_count * sizeof *p.placements );
    if ( scene->mesh_count > 0 )
        memcpy( p.meshes, scene->meshes, (size_t)scene->mesh_count * sizeof *p.meshes );
    if ( scene->placement_count > 0 )
        pose->scene.placements = p.placements;
    pose->scene.meshes = p.meshes;
    pose->scene.mesh_count = p.mesh_count;
    p.mesh_count = scene->mesh_count;
    find_nodes( &p );
    RfResult result = RF_OK;
    for ( int i = 0; result == RF_OK && i < p.movement->mover_count; ++i )
        result = pose_mover( &p, i );
    if ( p.shown_at != time )
    {
        time = p.time = p.shown_at;
        find_nodes( &p ); // of lamps
    }
    NodesAt nodes = { time, p.worlds, p.shown };
    pose->hash = hash_images( scene, time, hash_changes( scene, &nodes, pose->hash ) );
    if ( result == RF_OK )
        result = pose_changes( scene, &nodes, &layout, &pose->scene, error );
    if ( result == RF_OK && !pose->places_alone )
        result = rf_pose_images( scene, time, &layout, &pose->scene, error );
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
    RfLayout layout = { 0 };
    place_moment( scene, time, &layout, error );
    char* memory = layout.bytes > 0 ? aligned_alloc( 64, layout.bytes ) : NULL;
    if ( memory == NULL && layout.bytes > 0 )
        return no_memory( scene, error );
    Posing p = place_moment( scene, time, &( RfLayout ){ .memory = memory }, error );
    find_nodes( &p );
    for ( int i = 0; i < p.movement->mover_count; ++i )
    {
        RfMat4 matrix;
        follow( &p, p.movement->movers + i, &matrix, hash );
    }
    NodesAt nodes = { time, p.worlds, p.shown };
    if ( all )
        *hash = hash_images( scene, time, hash_changes( scene, &nodes, *hash ) );
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
