// Joins two scenes: their lists one after the other, with the numbers in them moved on.
#include "scene/merge.h"

#include "base/file.h"
#include "base/try.h"
#include "scene/deformation.h"
#include "scene/light_groups.h"
#include "scene/movement.h"
#include "scene/placement.h"
#include "scene/textured.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_TRIANGLES ( 1u << 28 ) // in world space, each with up to three vertices

// Appends vertices. Attributes that only one of the lists has are filled in. False if there is no memory.
static bool append_vertices( RfTriangles* to, const RfTriangles* from )
{
    size_t before = to->vertex_count, more = from->vertex_count;
    for ( int a = 0; a < RF_ATTRIBUTE_COUNT; ++a )
    {
        const size_t n = g_rf_attributes[a].components;
        const float* own = *rf_attribute( (RfTriangles*)from, a );
        float** all = rf_attribute( to, a );
        bool fresh = *all == NULL;
        if ( fresh && own == NULL )
            continue;
        if ( !rf_make_room( all, ( before + more ) * n, sizeof **all ) )
            return false;
        for ( size_t i = fresh ? 0 : n * before; i < n * ( before + more ); ++i )
            ( *all )[i] = i >= n * before && own != NULL ? own[i - n * before] : g_rf_attributes[a].fill;
    }
    to->vertex_count += from->vertex_count;
    return true;
}

bool rf_spread_vertices( RfTriangles* t )
{
    size_t corners = 3 * (size_t)t->count;
    for ( int a = 0; a < RF_ATTRIBUTE_COUNT; ++a )
    {
        const size_t n = g_rf_attributes[a].components;
        float** values = rf_attribute( t, a );
        if ( *values == NULL )
            continue;
        float* own = malloc( ( corners * n + 1 ) * sizeof *own );
        if ( own == NULL )
            return false;
        for ( size_t i = 0; i < corners; ++i )
            memcpy( own + n * i, *values + n * t->indices[i], n * sizeof *own );
        free( *values );
        *values = own;
    }
    for ( size_t i = 0; i < corners; ++i )
        t->indices[i] = (uint32_t)i;
    t->vertex_count = (uint32_t)corners;
    return true;
}

bool rf_append_triangles( RfTriangles* to, const RfTriangles* from, uint32_t first_material )
{
    size_t before = to->vertex_count, all = (size_t)to->count + from->count;
    if ( !rf_make_room( &to->indices, 3 * all, sizeof *to->indices ) ||
         !rf_make_room( &to->material, all, sizeof *to->material ) || !append_vertices( to, from ) )
        return false;
    for ( size_t i = 0; i < from->count; ++i )
    {
        const uint32_t* corners = from->indices + 3 * i;
        if ( corners[0] == corners[1] )
            continue;
        for ( size_t c = 0; c < 3; ++c )
            to->indices[3 * (size_t)to->count + c] = (uint32_t)before + corners[c];
        to->material[to->count++] = first_material + from->material[i];
    }
    return true;
}

// What a merge moves on, and by how much: the lengths of the lists before it.
typedef struct Merge
{
    RfScene *scene, *placed;
    uint32_t materials;
    int textures, meshes, nodes, channels, punctuals, moving_nodes, skins, movers, lamps, moving_materials, changes;
    RfError* error;
} Merge;

static RfResult no_memory( const Merge* m )
{
    return rf_fail( m->error, RF_ERROR_MEMORY, "%s: out of memory: close other programs", m->placed->path );
}

// Moves the items of a list to the end of another. They are then of that alone.
#define MOVE_ITEMS( to, to_count, from, from_count )                                                                             \
    do                                                                                                                           \
    {                                                                                                                            \
        if ( !rf_make_room( &( to ), (size_t)( ( to_count ) + ( from_count ) ), sizeof *( to ) ) )                               \
            return no_memory( m );                                                                                               \
        if ( ( from_count ) > 0 )                                                                                                \
            memcpy( ( to ) + ( to_count ), ( from ), (size_t)( from_count ) * sizeof *( to ) );                                  \
        ( to_count ) += ( from_count );                                                                                          \
        ( from_count ) = 0;                                                                                                      \
    } while ( 0 )

static RfResult move_materials( const Merge* m )
{
    RfScene *scene = m->scene, *placed = m->placed;
    MOVE_ITEMS( scene->textures, scene->texture_count, placed->textures, placed->texture_count );
    MOVE_ITEMS( scene->materials, scene->material_count, placed->materials, placed->material_count );
    for ( uint32_t i = m->materials; i < scene->material_count; ++i )
    {
        RfTextured* textured = scene->materials[i].textured;
        for ( int slot = 0; textured != NULL && slot < RF_TEXTURE_SLOT_COUNT; ++slot )
        {
            if ( textured->refs[slot].texture >= 0 )
                textured->refs[slot].texture += m->textures;
        }
    }
    return RF_OK;
}

static RfResult move_nodes( const Merge* m )
{
    RfScene *scene = m->scene, *placed = m->placed;
    MOVE_ITEMS( scene->nodes, scene->node_count, placed->nodes, placed->node_count );
    for ( int i = m->nodes; i < scene->node_count; ++i )
    {
        if ( scene->nodes[i].parent >= 0 )
            scene->nodes[i].parent += m->nodes;
    }
    // still sorted: the nodes come after those of the scene
    MOVE_ITEMS( scene->channels, scene->channel_count, placed->channels, placed->channel_count );
    for ( int i = m->channels; i < scene->channel_count; ++i )
        scene->channels[i].node += m->nodes;
    return RF_OK;
}

// Whose the triangles are that come after those of the scene.
static RfResult move_node_runs( const Merge* m )
{
    RfScene *scene = m->scene, *placed = m->placed;
    if ( placed->triangles.count > 0 && !rf_begin_node_run( scene, -1 ) )
        return no_memory( m );
    uint32_t before = scene->node_run_count;
    MOVE_ITEMS( scene->node_runs, scene->node_run_count, placed->node_runs, placed->node_run_count );
    for ( uint32_t i = before; i < scene->node_run_count; ++i )
    {
        scene->node_runs[i].first += scene->triangles.count;
        scene->node_runs[i].node += scene->node_runs[i].node > 0 ? m->nodes : 0;
    }
    return RF_OK;
}

static RfResult move_triangles( const Merge* m )
{
    RfTriangles *to = &m->scene->triangles, *from = &m->placed->triangles;
    if ( (uint64_t)to->count + from->count > MOST_TRIANGLES ||
         (uint64_t)to->vertex_count + from->vertex_count > 3 * (uint64_t)MOST_TRIANGLES )
        return rf_fail( m->error, RF_ERROR_UNSUPPORTED, "%s: more than %u triangles in all: split the scene", m->scene->path,
                        MOST_TRIANGLES );
    RF_TRY( move_node_runs( m ) );
    if ( from->count > 0 && !rf_append_triangles( to, from, m->materials ) )
        return no_memory( m );
    rf_destroy_triangles( from );
    return RF_OK;
}

static RfResult move_meshes( const Merge* m )
{
    RfScene *scene = m->scene, *placed = m->placed;
    MOVE_ITEMS( scene->meshes, scene->mesh_count, placed->meshes, placed->mesh_count );
    for ( int i = m->meshes; i < scene->mesh_count; ++i )
    {
        RfTriangles* t = &scene->meshes[i].triangles;
        for ( uint32_t k = 0; k < t->count; ++k )
            t->material[k] += m->materials;
    }
    return RF_OK;
}

// Those that stand still come first, of both.
static RfResult move_placements( const Merge* m )
{
    RfScene *scene = m->scene, *placed = m->placed;
    int still = placed->still_placement_count, moving = scene->placement_count - scene->still_placement_count;
    for ( int i = 0; i < placed->placement_count; ++i )
    {
        RfPlacement* p = placed->placements + i;
        p->mesh += m->meshes;
        p->mover = p->mover >= 0 ? p->mover + m->movers : -1;
        p->node += p->node > 0 ? m->nodes : 0;
    }
    MOVE_ITEMS( scene->placements, scene->placement_count, placed->placements, placed->placement_count );
    RfPlacement* after = scene->placements + scene->still_placement_count;
    memmove( after + still, after, (size_t)moving * sizeof *after );
    if ( still > 0 )
        memcpy( after, placed->placements, (size_t)still * sizeof *after );
    return RF_OK;
}

// Those of the sky, which is left behind, come first: the environment is read before all else that changes.
static int drop_sky( RfMovement* from )
{
    int dropped = 0;
    while ( dropped < from->change_count && rf_is_of_sky( from->changes[dropped].value ) )
        rf_destroy_channel( &from->changes[dropped++].channel );
    from->change_count -= dropped;
    if ( dropped > 0 )
        memmove( from->changes, from->changes + dropped, (size_t)from->change_count * sizeof *from->changes );
    return dropped;
}

static RfResult move_changes( const Merge* m, RfMovement* to, RfMovement* from )
{
    int shift = m->changes - drop_sky( from );
    MOVE_ITEMS( to->changes, to->change_count, from->changes, from->change_count );
    for ( int i = m->changes; i < to->change_count; ++i )
    {
        RfChange* change = to->changes + i;
        change->of += rf_changed_traits( change->value )->owner == RF_OF_LAMP ? m->punctuals : (int)m->materials;
    }
    MOVE_ITEMS( to->lamps, to->lamp_count, from->lamps, from->lamp_count );
    for ( int i = m->lamps; i < to->lamp_count; ++i )
    {
        RfMovingLamp* lamp = to->lamps + i;
        lamp->punctual += m->punctuals;
        lamp->node = lamp->node >= 0 ? lamp->node + m->moving_nodes : -1;
        for ( int v = 0; v < RF_CHANGED_LAMP_VALUES; ++v )
            lamp->changes[v] = lamp->changes[v] >= 0 ? lamp->changes[v] + shift : -1;
    }
    MOVE_ITEMS( to->materials, to->material_count, from->materials, from->material_count );
    for ( int i = m->moving_materials; i < to->material_count; ++i )
    {
        to->materials[i].material += (int)m->materials;
        to->materials[i].first_change += shift;
    }
    return RF_OK;
}

static RfResult move_movement( const Merge* m )
{
    RfMovement* from = m->placed->movement;
    if ( from == NULL )
        return RF_OK;
    RfMovement* to = m->scene->movement;
    if ( to == NULL )
    {
        to = m->scene->movement = calloc( 1, sizeof *to );
        if ( to == NULL )
            return no_memory( m );
        to->start = from->start;
        to->end = from->end;
    }
    MOVE_ITEMS( to->nodes, to->node_count, from->nodes, from->node_count );
    for ( int i = m->moving_nodes; i < to->node_count; ++i )
    {
        RfMovingNode* node = to->nodes + i;
        node->node += m->nodes;
        node->parent = node->parent >= 0 ? node->parent + m->moving_nodes : -1;
        node->shows = node->shows >= 0 ? node->shows + m->channels : -1;
    }
    MOVE_ITEMS( to->skins, to->skin_count, from->skins, from->skin_count );
    for ( int i = m->skins; i < to->skin_count; ++i )
    {
        for ( int k = 0; k < to->skins[i].joint_count; ++k )
            to->skins[i].joints[k] += m->moving_nodes;
    }
    MOVE_ITEMS( to->movers, to->mover_count, from->movers, from->mover_count );
    for ( int i = m->movers; i < to->mover_count; ++i )
    {
        RfMover* mover = to->movers + i;
        mover->node += m->moving_nodes;
        mover->skin = mover->skin >= 0 ? mover->skin + m->skins : -1;
        mover->weights_moved = mover->weights_moved >= 0 ? mover->weights_moved + m->channels : -1;
    }
    int sequences = to->sequence_count;
    MOVE_ITEMS( to->sequences, to->sequence_count, from->sequences, from->sequence_count );
    for ( int i = sequences; i < to->sequence_count; ++i )
        to->sequences[i].texture += m->textures;
    to->start = from->start < to->start ? from->start : to->start;
    to->end = from->end > to->end ? from->end : to->end;
    return move_changes( m, to, from );
}

// "fox.glb: light 'Sun'".
static bool put_before( const char* name, char** text )
{
    size_t size = strlen( name ) + strlen( *text ) + 3;
    char* longer = malloc( size );
    if ( longer == NULL )
        return false;
    snprintf( longer, size, "%s: %s", name, *text );
    free( *text );
    *text = longer;
    return true;
}

static bool put_before_all( const char* name, char** texts, int count )
{
    bool named = true;
    for ( int i = 0; i < count; ++i )
        named = named && put_before( name, texts + i );
    return named;
}

static RfResult move_notes( const Merge* m, const char* name )
{
    RfScene *scene = m->scene, *placed = m->placed;
    bool named = put_before_all( name, placed->moving, placed->moving_count ) &&
                 put_before_all( name, placed->losses, placed->loss_count ) &&
                 put_before_all( name, placed->export_losses, placed->export_loss_count ) &&
                 put_before_all( name, placed->export_warnings, placed->export_warning_count );
    for ( int i = 0; i < placed->unrendered_count; ++i )
        named = named && put_before( name, &placed->unrendered[i].what );
    if ( !named )
        return no_memory( m );
    MOVE_ITEMS( scene->unrendered, scene->unrendered_count, placed->unrendered, placed->unrendered_count );
    MOVE_ITEMS( scene->moving, scene->moving_count, placed->moving, placed->moving_count );
    MOVE_ITEMS( scene->losses, scene->loss_count, placed->losses, placed->loss_count );
    MOVE_ITEMS( scene->export_losses, scene->export_loss_count, placed->export_losses, placed->export_loss_count );
    MOVE_ITEMS( scene->export_warnings, scene->export_warning_count, placed->export_warnings, placed->export_warning_count );
    MOVE_ITEMS( scene->punctuals, scene->punctual_count, placed->punctuals, placed->punctual_count );
    return RF_OK;
}

static void join_bounds( RfScene* scene, const RfScene* placed, bool first )
{
    rf_grow_bounds( &scene->bounds_min, &scene->bounds_max, first, placed->bounds_min );
    rf_grow_bounds( &scene->bounds_min, &scene->bounds_max, false, placed->bounds_max );
}

// Tags are numbered anew, by their names.
static bool move_tag( const Merge* m, uint16_t* tag )
{
    return *tag == 0 || rf_tag_light( m->scene, m->placed->light_groups[*tag - 1], tag );
}

static RfResult move_light_groups( const Merge* m )
{
    RfScene* scene = m->scene;
    bool moved = true;
    for ( int i = m->punctuals; i < scene->punctual_count; ++i )
        moved = moved && move_tag( m, &scene->punctuals[i].light_group );
    for ( uint32_t i = m->materials; i < scene->material_count; ++i )
        moved = moved && move_tag( m, &scene->materials[i].light_group );
    return moved ? RF_OK : no_memory( m );
}

static RfResult merge( const Merge* m, const char* name )
{
    RfScene *scene = m->scene, *placed = m->placed;
    if ( rf_triangle_count( placed ) > 0 )
        join_bounds( scene, placed, rf_triangle_count( scene ) == 0 );
    RfResult result = move_materials( m );
    if ( result == RF_OK )
        result = move_nodes( m );
    if ( result == RF_OK )
        result = move_triangles( m );
    if ( result == RF_OK )
        result = move_meshes( m );
    if ( result == RF_OK )
        result = move_placements( m );
    if ( result == RF_OK )
        result = move_movement( m );
    if ( result == RF_OK )
        result = move_notes( m, name );
    if ( result == RF_OK )
        result = move_light_groups( m );
    scene->frozen = scene->frozen || placed->frozen;
    if ( placed->change_end > placed->change_start )
    {
        bool first = !( scene->change_end > scene->change_start );
        scene->change_start = first ? placed->change_start : fmin( scene->change_start, placed->change_start );
        scene->change_end = first ? placed->change_end : fmax( scene->change_end, placed->change_end );
    }
    scene->instance_count += placed->instance_count;
    scene->content_hash = rf_hash_bytes( scene->content_hash, &placed->content_hash, sizeof placed->content_hash );
    return result == RF_OK ? rf_number_placements( scene, m->error ) : result;
}

RfResult rf_merge_scene( RfScene* scene, RfScene* placed, const char* name, RfError* error )
{
    const RfMovement* movement = scene->movement;
    Merge m = {
        .scene = scene,
        .placed = placed,
        .materials = scene->material_count,
        .textures = scene->texture_count,
        .meshes = scene->mesh_count,
        .nodes = scene->node_count,
        .channels = scene->channel_count,
        .punctuals = scene->punctual_count,
        .moving_nodes = movement != NULL ? movement->node_count : 0,
        .skins = movement != NULL ? movement->skin_count : 0,
        .movers = movement != NULL ? movement->mover_count : 0,
        .lamps = movement != NULL ? movement->lamp_count : 0,
        .moving_materials = movement != NULL ? movement->material_count : 0,
        .changes = movement != NULL ? movement->change_count : 0,
        .error = error,
    };
    RfResult result = merge( &m, name );
    rf_destroy_scene( placed );
    return result;
}
