// Poses the scene for the frames of a group, and makes their tracers.
#include "render/worlds.h"

#include "base/built_in.h"
#include "light/changing.h"
#include "scene/movement.h"
#include "scene/pose.h"

#include <stdlib.h>

// Bytes of the process beside those of poses, as it grows with Embree 3.13 on AVX2 and AVX-512. By a mesh of 500,000 triangles
// that deforms, 103 for each, and once 154 while it is built; by 2,000 such meshes of 12 triangles, 5,200 for each; by
// 10,000 nodes in groups of 7, 350 for each and 145 of the swept geometry, and 650 after groups have come and gone.
#define BYTES_PER_TRIANGLE 120 // with 16 for the order of those that have a filter
#define BYTES_PER_BUILT_TRIANGLE 160
#define BYTES_PER_MESH 6000
#define BYTES_PER_MOVER 700
#define BYTES_PER_PLACEMENT 48 // of all, for the errors of their hits
#define BYTES_PER_WORLD 4096
// And for each step of a shutter: up to 56 of a triangle, 88 of a mesh of two, 194 of an instance.
#define BYTES_PER_TRIANGLE_STEP 64
#define BYTES_PER_MESH_STEP 100
#define BYTES_PER_MOVER_STEP 200

size_t rf_worlds_bytes( const RfScene* scene, int count, int steps )
{
    if ( count == 0 )
        return 0;
    RfPoseParts own = rf_pose_parts( scene );
    RfLayout images = { 0 };
    rf_pose_images( scene, 0.0, &images, NULL, NULL );
    size_t movers = (size_t)( scene->placement_count - scene->still_placement_count );
    size_t moments = (size_t)steps + 1;
    size_t world = moments * ( rf_pose_bytes( scene ) + sizeof( RfPosedScene ) ) + sizeof( RfMoments ) + BYTES_PER_WORLD +
                   BYTES_PER_TRIANGLE * (size_t)own.triangles + BYTES_PER_MESH * (size_t)own.meshes + BYTES_PER_MOVER * movers +
                   BYTES_PER_PLACEMENT * (size_t)scene->placement_count +
                   sizeof( RfMesh ) * (size_t)( scene->mesh_count + own.meshes );
    world += (size_t)steps * ( BYTES_PER_TRIANGLE_STEP * (size_t)own.triangles + BYTES_PER_MESH_STEP * (size_t)own.meshes +
                               BYTES_PER_MOVER_STEP * movers );
    world -= (size_t)steps * images.bytes; // which the middle moment alone has
    return (size_t)count * world + BYTES_PER_BUILT_TRIANGLE * (size_t)own.most_triangles + own.image_bytes +
           rf_group_lights_bytes( scene, count );
}

int rf_worlds_held( const RfScene* scene, int frames, int eyes, bool neighbours, bool ahead )
{
    int count = eyes + ( neighbours ? 2 : 0 ) + ( ahead ? eyes / 2 : 0 );
    return !rf_calls_for( scene->movement != NULL, RF_EFFECT_MOVING ) ? 0 : count < frames ? count : frames;
}

RfResult rf_create_worlds( const RfShot* shot, int count, bool neighbours, RfWorlds* worlds, RfError* error )
{
    *worlds = ( RfWorlds ){ .still = shot->tracer,
                            .eyes = shot->eyes,
                            .frames = shot->eye_count,
                            .neighbours = neighbours,
                            .lights_change = rf_tracer_lights( shot->tracer )->changing != NULL };
    if ( count == 0 )
        return RF_OK;
    worlds->worlds = calloc( (size_t)count, sizeof *worlds->worlds );
    worlds->tracers = calloc( (size_t)shot->eye_count, sizeof *worlds->tracers );
    if ( worlds->worlds == NULL || worlds->tracers == NULL )
    {
        rf_destroy_worlds( worlds );
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory posing %d frames", count );
    }
    for ( int i = 0; i < count; ++i )
        worlds->worlds[i].frame = -1;
    worlds->count = count;
    return RF_OK;
}

// They hold on to what Embree needs of their frames.
static void drop_swept( RfWorlds* worlds )
{
    for ( int i = 0; i < worlds->count; ++i )
    {
        if ( worlds->worlds[i].tracer != NULL )
            rf_set_swept( worlds->worlds[i].tracer, NULL );
    }
    rf_destroy_swept( worlds->swept );
    worlds->swept = NULL;
    worlds->swept_count = 0;
}

static void drop_lights( RfWorlds* worlds )
{
    for ( int i = 0; i < worlds->count && worlds->lights != NULL; ++i )
    {
        if ( worlds->worlds[i].tracer != NULL )
            rf_set_lights( worlds->worlds[i].tracer, NULL );
    }
    rf_destroy_group_lights( worlds->lights );
    worlds->lights = NULL;
    worlds->lit_count = 0;
}

static bool is_lit( const RfWorlds* worlds, int frame )
{
    return frame >= worlds->first_lit && frame < worlds->first_lit + worlds->lit_count;
}

static bool is_swept( const RfWorlds* worlds, int frame )
{
    return frame >= worlds->first_swept && frame < worlds->first_swept + worlds->swept_count;
}

static void close_world( RfWorlds* worlds, RfWorld* world )
{
    if ( is_swept( worlds, world->frame ) )
        drop_swept( worlds );
    if ( is_lit( worlds, world->frame ) )
        drop_lights( worlds );
    if ( world->frame >= 0 )
        worlds->tracers[world->frame] = NULL;
    rf_destroy_tracer( world->tracer );
    for ( int k = 0; k < world->moments; ++k )
        rf_destroy_pose( world->poses + k );
    free( world->poses );
    free( world->joined );
    free( world->emission );
    *world = ( RfWorld ){ .frame = -1 };
}

void rf_destroy_worlds( RfWorlds* worlds )
{
    drop_swept( worlds );
    drop_lights( worlds );
    for ( int i = 0; i < worlds->count; ++i )
        close_world( worlds, worlds->worlds + i );
    free( worlds->worlds );
    free( worlds->tracers );
    *worlds = ( RfWorlds ){ 0 };
}

// Makes room for one of the frames [first, end): a free place, or that of the earliest of the others, which is wanted last.
static RfWorld* free_world( RfWorlds* worlds, int first, int end )
{
    RfWorld* earliest = NULL;
    for ( int i = 0; i < worlds->count; ++i )
    {
        RfWorld* world = worlds->worlds + i;
        if ( world->frame == -1 )
            return world;
        bool wanted = world->frame >= first && world->frame < end;
        if ( !wanted && ( earliest == NULL || world->frame < earliest->frame ) )
            earliest = world;
    }
    close_world( worlds, earliest );
    return earliest;
}

// Poses the scene at the moments of an eye's shutter.
static RfResult pose_moments( const RfScene* scene, const RfEye* eye, RfWorld* world, RfError* error )
{
    int steps = (int)eye->blur_steps;
    world->poses = calloc( (size_t)steps + 1, sizeof *world->poses );
    world->joined = steps > 0 ? calloc( 1, sizeof *world->joined ) : NULL;
    if ( world->poses == NULL || ( steps > 0 && world->joined == NULL ) )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory posing %d moments", steps + 1 );
    world->moments = steps + 1;
    RfResult result = RF_OK;
    for ( int k = 0; k <= steps && result == RF_OK; ++k )
    {
        world->poses[k].in_shutter = steps > 0;
        world->poses[k].places_alone = k != rf_middle_moment( steps );
        world->poses[k].middle = eye->time;
        result = rf_pose_scene( scene, rf_moment_time( eye, k ), world->poses + k, error );
    }
    if ( result == RF_OK && steps > 0 )
        rf_join_moments( world->poses, steps, world->joined );
    return result;
}

static RfPosedScene* middle_of( const RfWorld* world ) { return world->poses + rf_middle_moment( world->moments - 1 ); }

static RfResult note_emission( const RfWorlds* worlds, RfWorld* world, RfError* error )
{
    if ( !worlds->lights_change )
        return RF_OK;
    const RfLights* still = rf_tracer_lights( worlds->still );
    world->emission = malloc( ( (size_t)still->changing->dim_count + 1 ) * sizeof *world->emission );
    if ( world->emission == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for lights that change" );
    rf_note_emission( still, &middle_of( world )->scene, world->emission );
    return RF_OK;
}

static RfResult open_world( RfWorlds* worlds, int frame, RfWorld* world, RfError* error )
{
    const RfEye* eye = worlds->eyes + frame;
    RfResult result = pose_moments( rf_tracer_scene( worlds->still ), eye, world, error );
    const RfPosedScene* pose = world->poses + rf_middle_moment( (int)eye->blur_steps );
    if ( result == RF_OK )
        result = note_emission( worlds, world, error );
    if ( result == RF_OK )
        result = rf_create_posed_tracer( worlds->still, &pose->scene, &world->tracer, error );
    if ( result == RF_OK )
    {
        world->frame = frame;
        worlds->tracers[frame] = world->tracer;
    }
    else
        close_world( worlds, world );
    return result;
}

static RfResult make_swept( RfWorlds* worlds, int first, int count, RfError* error )
{
    if ( worlds->first_swept == first && worlds->swept_count == count )
        return RF_OK;
    drop_swept( worlds );
    RfResult result = rf_create_swept( count, worlds->tracers + first, &worlds->swept, error );
    worlds->first_swept = first;
    worlds->swept_count = result == RF_OK ? count : 0;
    return result;
}

// A frame alone has none: it is the same whichever group has been rendered before.
static void set_swept( const RfWorlds* worlds, int first, int count )
{
    for ( int i = 0; i < worlds->count; ++i )
    {
        const RfWorld* world = worlds->worlds + i;
        if ( world->frame >= first && world->frame < first + count )
            rf_set_swept( world->tracer, count > 1 ? worlds->swept : NULL );
    }
}

static RfWorld* world_of( const RfWorlds* worlds, int frame )
{
    for ( int i = 0; i < worlds->count; ++i )
    {
        if ( worlds->worlds[i].frame == frame )
            return worlds->worlds + i;
    }
    return NULL;
}

// Gives the frames of a group the same lights to select from.
static RfResult light_worlds( RfWorlds* worlds, int first, int count, RfError* error )
{
    if ( !worlds->lights_change || ( worlds->first_lit == first && worlds->lit_count == count ) )
        return RF_OK;
    drop_lights( worlds );
    RfLitFrame* frame = malloc( (size_t)count * sizeof *frame );
    if ( frame == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the lights of a group of frames" );
    for ( int i = 0; i < count; ++i )
    {
        RfWorld* world = world_of( worlds, first + i );
        frame[i] = ( RfLitFrame ){ &middle_of( world )->scene, world->emission };
    }
    RfResult result = rf_create_group_lights( rf_tracer_lights( worlds->still ), rf_tracer_scene( worlds->still ), count, frame,
                                              &worlds->lights, error );
    free( frame );
    for ( int i = 0; i < count && result == RF_OK; ++i )
        rf_set_lights( world_of( worlds, first + i )->tracer, worlds->lights->lights + i );
    worlds->first_lit = first;
    worlds->lit_count = result == RF_OK ? count : 0;
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
        worlds->result = make_swept( worlds, first, count, &worlds->error );
    if ( worlds->result == RF_OK )
        worlds->result = light_worlds( worlds, first, count, &worlds->error );
    if ( worlds->result != RF_OK )
        return NULL;
    set_swept( worlds, first, count );
    return worlds->tracers + first;
}
