#include "trace/far_triangle.h"

#include "base/fault.h"

#include <stdlib.h>

// Embree takes the edges, their cross product N, and N·(p0 − o): at most 8 roundings of 2⁻²⁴ each.
#define EMBREE_ERROR 5e-7f

// Times the ray offset at the median distance: only what reaches some 30 times as far pays for the check.
#define FAR_RATIO 64.0f

#define SAMPLES 1024

// Scenes of 2^-20 to 2^20 m, some micrometres to 1000 km, need no scale.
#define LEAST_EXPONENT 20

static int compare( const void* a, const void* b )
{
    float x = *(const float*)a, y = *(const float*)b;
    return ( x > y ) - ( x < y );
}

float rf_median_reach( const RfTriangles* t )
{
    float largest[SAMPLES];
    size_t corners = 3 * (size_t)t->count, step = corners / SAMPLES + 1, count = 0;
    for ( size_t i = 0; i < corners; i += step )
    {
        const float* p = t->positions + 3 * (size_t)t->indices[i];
        largest[count++] = rf_largest_coordinate( rf_vec3( p[0], p[1], p[2] ) );
    }
    qsort( largest, count, sizeof *largest, compare );
    return count > 0 ? largest[count / 2] : 0.0f;
}

float rf_far_error( float reach ) { return FAR_RATIO * rf_ray_offset( reach ); }

float rf_embree_scale( float reach )
{
    int exponent;
    frexpf( reach, &exponent );
    bool ordinary = reach == 0.0f || ( exponent > -LEAST_EXPONENT && exponent < LEAST_EXPONENT );
    return ordinary || RF_FAULT( embree_scale ) ? 1.0f : ldexpf( 1.0f, -exponent );
}

// How far off its plane Embree may find a triangle that it starts `way` from vertex 0: the products in
// N·way, without their signs, over the length of N.
static float embree_error( RfVec3 e1, RfVec3 e2, RfVec3 way )
{
    double twice;
    rf_unit_cross( e1, e2, &twice );
    double x = fabs( (double)e1.y * (double)e2.z ) + fabs( (double)e1.z * (double)e2.y );
    double y = fabs( (double)e1.z * (double)e2.x ) + fabs( (double)e1.x * (double)e2.z );
    double z = fabs( (double)e1.x * (double)e2.y ) + fabs( (double)e1.y * (double)e2.x );
    double sum = x * fabs( (double)way.x ) + y * fabs( (double)way.y ) + z * fabs( (double)way.z );
    return twice > 0.0 ? EMBREE_ERROR * (float)( sum / twice ) : 0.0f;
}

static RfVec3 corner( const RfTriangles* t, uint32_t triangle, int i )
{
    const float* p = t->positions + 3 * (size_t)t->indices[3 * (size_t)triangle + (size_t)i];
    return rf_vec3( p[0], p[1], p[2] );
}

bool rf_is_far_triangle( const RfTriangles* t, uint32_t triangle, float far_error )
{
    RfVec3 p0 = corner( t, triangle, 0 );
    RfVec3 e1 = rf_sub( corner( t, triangle, 1 ), p0 ), e2 = rf_sub( corner( t, triangle, 2 ), p0 );
    RfVec3 extent = { rf_maxf( fabsf( e1.x ), fabsf( e2.x ) ), rf_maxf( fabsf( e1.y ), fabsf( e2.y ) ),
                      rf_maxf( fabsf( e1.z ), fabsf( e2.z ) ) };
    // slivers have a large bound, but their area is small
    return rf_largest_coordinate( extent ) * 3.0f * EMBREE_ERROR > far_error && embree_error( e1, e2, extent ) > far_error;
}

bool rf_cross_plane( const RfTriangleRecord* t, RfVec3 o, RfVec3 d, double* distance )
{
    // products of two floats are exact in doubles
    double x1 = (double)t->e1.x, y1 = (double)t->e1.y, z1 = (double)t->e1.z;
    double x2 = (double)t->e2.x, y2 = (double)t->e2.y, z2 = (double)t->e2.z;
    double nx = y1 * z2 - z1 * y2, ny = z1 * x2 - x1 * z2, nz = x1 * y2 - y1 * x2;
    double along = nx * (double)d.x + ny * (double)d.y + nz * (double)d.z;
    double away =
        nx * ( (double)t->p0.x - (double)o.x ) + ny * ( (double)t->p0.y - (double)o.y ) + nz * ( (double)t->p0.z - (double)o.z );
    *distance = away / along;
    return along != 0.0;
}

RfHitPoint rf_hit_far_triangle( const RfTriangleRecord* t, RfVec3 o, RfVec3 d, RfHitPoint interpolated )
{
    double s;
    if ( RF_FAULT( far_triangles ) || !rf_cross_plane( t, o, d, &s ) || !( s > 0.0 ) )
        return interpolated;
    RfVec3 p = { (float)( (double)o.x + s * (double)d.x ), (float)( (double)o.y + s * (double)d.y ),
                 (float)( (double)o.z + s * (double)d.z ) };
    // segments end here from places about as far as where this ray started: the largest coordinate counts
    float offset = rf_ray_offset( rf_maxf( rf_largest_coordinate( p ), rf_largest_coordinate( o ) ) );
    if ( !t->far ) // rays that leave must get away from it by Embree's arithmetic
        offset += embree_error( t->e1, t->e2, rf_sub( t->p0, p ) );
    return offset < interpolated.offset ? ( RfHitPoint ){ p, offset } : interpolated;
}
