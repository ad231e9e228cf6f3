// Where a scene that lies far from the origin is moved to, so that floats can tell its details apart. At
// 100 km they are 8 mm apart.
#include "scene/gltf/gltf_document.h"

#include "scene/camera.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SAMPLES 1024 // corners of triangles, evenly spread over the list

// As far out as this, in distances of the median corner from the middle.
#define FAR_OUT 16.0

static int compare( const void* a, const void* b )
{
    double x = *(const double*)a, y = *(const double*)b;
    return ( x > y ) - ( x < y );
}

static double median( double* values, size_t count )
{
    qsort( values, count, sizeof *values, compare );
    return values[count / 2];
}

static size_t sample_corners( const RfTriangles* t, double corners[3][SAMPLES] )
{
    size_t all = 3 * (size_t)t->count, step = all / SAMPLES + 1, count = 0;
    for ( size_t i = 0; i < all; i += step, ++count )
    {
        for ( size_t c = 0; c < 3; ++c )
            corners[c][count] = (double)t->positions[3 * (size_t)t->indices[i] + c];
    }
    return count;
}

// Whether the camera that is rendered by default starts nearer to the middle than to where the origin is.
static bool eye_agrees( const RfScene* scene, const double middle[3] )
{
    int index;
    if ( rf_find_camera( scene, NULL, &index, NULL ) != RF_OK || scene->cameras[index].node < 0 )
        return true;
    RfMat4 world;
    rf_node_world_matrix( scene, scene->cameras[index].node, scene->cameras[index].start, &world );
    double before = 0.0, after = 0.0;
    for ( int c = 0; c < 3; ++c )
    {
        before = fmax( before, fabs( world.m[12 + c] ) );
        after = fmax( after, fabs( world.m[12 + c] - middle[c] ) );
    }
    return after < before;
}

bool rf_gltf_find_origin( const RfScene* scene, double origin[3] )
{
    double corners[3][SAMPLES], sorted[SAMPLES], middle[3], distance[SAMPLES], out = 0.0;
    size_t count = sample_corners( &scene->triangles, corners );
    if ( count == 0 )
        return false;
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( sorted, corners[c], count * sizeof *sorted );
        middle[c] = median( sorted, count );
        out = fmax( out, fabs( middle[c] ) );
    }
    for ( size_t i = 0; i < count; ++i )
        distance[i] = fmax( fabs( corners[0][i] - middle[0] ),
                            fmax( fabs( corners[1][i] - middle[1] ), fabs( corners[2][i] - middle[2] ) ) );
    double size = median( distance, count );
    if ( !( size > 0.0 && out > FAR_OUT * size && eye_agrees( scene, middle ) ) )
        return false;
    // to a multiple of a power of two, so that round numbers stay round
    double unit = exp2( ceil( log2( 8.0 * size ) ) );
    for ( int c = 0; c < 3; ++c )
        origin[c] = unit * round( middle[c] / unit );
    return true;
}
