#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>

static void free_triangles( RfTriangles* triangles )
{
    free( triangles->positions );
    free( triangles->normals );
    free( triangles->uvs );
    free( triangles->indices );
    free( triangles->material );
}

void rf_destroy_scene( RfScene* scene )
{
    if ( scene == NULL )
        return;
    free_triangles( &scene->triangles );
    for ( uint32_t i = 0; scene->materials != NULL && i < scene->material_count; ++i )
        free( scene->materials[i].name );
    for ( int i = 0; scene->nodes != NULL && i < scene->node_count; ++i )
        free( scene->nodes[i].name );
    for ( int i = 0; scene->channels != NULL && i < scene->channel_count; ++i )
    {
        free( scene->channels[i].times );
        free( scene->channels[i].values );
    }
    for ( int i = 0; scene->cameras != NULL && i < scene->camera_count; ++i )
        free( scene->cameras[i].name );
    free( scene->materials );
    free( scene->nodes );
    free( scene->channels );
    free( scene->cameras );
    free( scene->path );
    memset( scene, 0, sizeof *scene );
}

static float largest_coordinate( RfVec3 v )
{
    return rf_max_component( rf_vec3( fabsf( v.x ), fabsf( v.y ), fabsf( v.z ) ) );
}

float rf_ray_offset( const RfScene* scene )
{
    float largest = rf_maxf( largest_coordinate( scene->bounds_min ), largest_coordinate( scene->bounds_max ) );
    // A float has 24 bits. A point made from barycentrics is off its plane by at
    // most some 2e-7 of the largest coordinate; more room would let light into
    // corners and points past thin things.
    return rf_maxf( 1e-6f * largest, 1e-12f );
}
