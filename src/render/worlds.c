// Poses the scene for the frames of a group, and makes their tracers.
#include "render/worlds.h"

#include "base/built_in.h"
#include "scene/movement.h"

#include <stdlib.h>

// Of Embree's BVH, per triangle.
#define BYTES_PER_TRIANGLE 160

static uint64_t count_moving( const RfScene* scene )
{
    uint64_t count = 0;
    for ( int i = scene->still_placement_count; i < scene->placement_count; ++i )
        count += scene->meshes[scene->placements[i].mesh].triangles.count;
    return count;
}

size_t rf_worlds_bytes( const RfScene* scene, int count )
{
    if ( scene->movement == NULL )
        return 0;
    return (size_t)count * ( rf_pose_bytes( scene ) + BYTES_PER_TRIANGLE * (size_t)count_moving( scene ) );
}

RfResult rf_create_worlds( const RfShot* shot, int eyes, bool neighbours, RfWorlds* worlds, RfError* error )
{
    int count = eyes + ( neighbours ? 2 : 0 );
    *worlds = ( RfWorlds ){ .still = shot->tracer, .eyes = shot->eyes, .frames = shot->eye_count, .neighbours = neighbours };
    if ( !rf_calls_for( rf_tracer_scene( shot->tracer )->movement != NULL, RF_EFFECT_MOVING ) )
        return RF_OK;
    worlds->worlds = calloc( (size_t)count, sizeof *worlds->worlds );
    worlds->tracers = calloc( (size_t)shot->eye_count, sizeof *worlds->tracers );
    if ( worlds->worlds == NULL || worlds->tracers == NULL )
    {
        rf_destroy_worlds( worlds );
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for what moves in %d frames", count );
    }
    for ( int i = 0; i < count; ++i )
        worlds->worlds[i].frame = -1;
    worlds->count = count;
    return RF_OK;
}

static void close_world( RfWorlds* worlds, RfWorld* world )
{
    if ( world->frame >= 0 )
        worlds->tracers[world->frame] = NULL;
    rf_destroy_tracer( world->tracer );
    rf_destroy_pose( &world->pose );
    *world = ( RfWorld ){ .frame = -1 };
}

// They hold on to what Embree needs of frames that are closed.
static void drop_ghosts( RfWorlds* worlds )
{
    for ( int i = 0; i < worlds->count; ++i )
    {
        if ( worlds->worlds[i].tracer != NULL )
            rf_set_ghosts( worlds->worlds[i].tracer, NULL );
    }
    rf_destroy_ghosts( worlds->ghosts );
    worlds->ghosts = NULL;
    worlds->ghost_count = 0;
}

void rf_destroy_worlds( RfWorlds* worlds )
{
    drop_ghosts( worlds );
    for ( int i = 0; i < worlds->count; ++i )
        close_world( worlds, worlds->worlds + i );
    free( worlds->worlds );
    free( worlds->tracers );
    *worlds = ( RfWorlds ){ 0 };
}

// Makes room for one of the frames [first, end): a free place, or that of another frame.
static RfWorld* free_world( RfWorlds* worlds, int first, int end )
{
    for ( int i = 0; i < worlds->count; ++i )
    {
        if ( worlds->worlds[i].frame == -1 )
            return worlds->worlds + i;
    }
    int k = 0;
    while ( worlds->worlds[k].frame >= first && worlds->worlds[k].frame < end )
        k += 1;
    close_world( worlds, worlds->worlds + k );
    return worlds->worlds + k;
}

static RfResult open_world( RfWorlds* worlds, int frame, RfWorld* world, RfError* error )
{
    RfResult result = rf_pose_scene( rf_tracer_scene( worlds->still ), worlds->eyes[frame].time, &world->pose, error );
    if ( result == RF_OK )
        result = rf_create_posed_tracer( worlds->still, &world->pose.scene, &world->tracer, error );
    if ( result == RF_OK )
    {
        world->frame = frame;
        worlds->tracers[frame] = world->tracer;
    }
    else
        close_world( worlds, world );
    return result;
}

static RfResult make_ghosts( RfWorlds* worlds, int first, int count, RfError* error )
{
    if ( worlds->first_ghost == first && worlds->ghost_count == count )
        return RF_OK;
    drop_ghosts( worlds );
    RfResult result = rf_create_ghosts( count, worlds->tracers + first, &worlds->ghosts, error );
    for ( int i = 0; i < worlds->count && result == RF_OK; ++i )
    {
        int frame = worlds->worlds[i].frame;
        if ( frame >= first && frame < first + count )
            rf_set_ghosts( worlds->worlds[i].tracer, worlds->ghosts );
    }
    worlds->first_ghost = first;
    worlds->ghost_count = result == RF_OK ? count : 0;
    return result;
}

const RfTracer* const* rf_open_worlds( RfWorlds* worlds, int first, int count )
{
    if ( worlds->count == 0 || worlds->result != RF_OK )
        return NULL;
    int low = first - worlds->neighbours, end = first + count + worlds->neighbours;
    low = low > 0 ? low : 0;
    end = end < worlds->frames ? end : worlds->frames;
    for ( int frame = low; frame < end && worlds->result == RF_OK; ++frame )
    {
        if ( worlds->tracers[frame] == NULL )
            worlds->result = open_world( worlds, frame, free_world( worlds, low, end ), &worlds->error );
    }
    if ( worlds->result == RF_OK && count > 1 )
        worlds->result = make_ghosts( worlds, first, count, &worlds->error );
    return worlds->result == RF_OK ? worlds->tracers + first : NULL;
}
