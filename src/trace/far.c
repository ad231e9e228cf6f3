// Triangles of great extent: which they are, and their hits in doubles.
#include "trace/far.h"

#include "base/fault.h"

float rf_embree_error( RfVec3 e1, RfVec3 e2, RfVec3 way )
{
    double twice;
    rf_unit_cross( e1, e2, &twice );
    double x = fabs( (double)e1.y * (double)e2.z ) + fabs( (double)e1.z * (double)e2.y );
    double y = fabs( (double)e1.z * (double)e2.x ) + fabs( (double)e1.x * (double)e2.z );
    double z = fabs( (double)e1.x * (double)e2.y ) + fabs( (double)e1.y * (double)e2.x );
    double sum = x * fabs( (double)way.x ) + y * fabs( (double)way.y ) + z * fabs( (double)way.z );
    return twice > 0.0 ? RF_EMBREE_ERROR * (float)( sum / twice ) : 0.0f;
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
    // instances are off by their matrix as well, which only the check in doubles knows
    if ( t->placed && !t->far )
        return interpolated;
    if ( RF_FAULT( far_triangles ) || !rf_cross_plane( t, o, d, &s ) || !( s > 0.0 ) )
        return interpolated;
    RfVec3 p = { (float)( (double)o.x + s * (double)d.x ), (float)( (double)o.y + s * (double)d.y ),
                 (float)( (double)o.z + s * (double)d.z ) };
    // segments end here from places about as far as where this ray started: the largest coordinate counts
    float offset = rf_ray_offset( rf_maxf( rf_largest_coordinate( p ), rf_largest_coordinate( o ) ) );
    if ( !t->far ) // rays that leave must get away from it by Embree's arithmetic
        offset += rf_embree_error( t->e1, t->e2, rf_sub( t->p0, p ) );
    return offset < interpolated.offset ? ( RfHitPoint ){ p, offset } : interpolated;
}
