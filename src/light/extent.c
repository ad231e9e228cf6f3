// Samples what is seen of lamps with size.
#include "light/extent.h"

#include "light/punctual.h"

#include <math.h>

#define PI 3.14159265358979324

// Smaller rectangles, sr, are sampled by area, since the excess of their angles has no digits left.
#define SMALL 1e-7

// Of a cone about a unit axis, uniform by solid angle; sets the versine to the axis, 1 − cos.
static RfVec3 sample_cone( RfVec3 axis, double versine, const float u[2], double* drawn )
{
    RfVec3 t, b;
    rf_basis( axis, &t, &b );
    *drawn = (double)u[0] * versine;
    double sine = sqrt( fmax( *drawn * ( 2.0 - *drawn ), 0.0 ) ), phi = 2.0 * PI * (double)u[1];
    RfVec3 across = rf_add( rf_scale( t, (float)( sine * cos( phi ) ) ), rf_scale( b, (float)( sine * sin( phi ) ) ) );
    return rf_normalize( rf_madd( across, axis, (float)( 1.0 - *drawn ) ) );
}

RfExtentSample rf_sample_ball( const RfPunctual* lamp, RfVec3 from, const float u[2] )
{
    RfVec3 to = rf_sub( lamp->position, from );
    double d2 = (double)rf_dot( to, to ), r2 = (double)lamp->radius * (double)lamp->radius, d = sqrt( d2 );
    if ( !( d2 > 0.0 ) )
        return ( RfExtentSample ){ .weight = 0.0f };
    bool inside = !lamp->soft && d2 <= r2;
    double sine2 = inside ? 1.0 : lamp->soft ? r2 / ( d2 + r2 ) : r2 / d2, drawn;
    double versine = inside ? 2.0 : sine2 / ( 1.0 + sqrt( fmax( 1.0 - sine2, 0.0 ) ) );
    RfExtentSample s = { .wi = sample_cone( rf_scale( to, (float)( 1.0 / d ) ), versine, u, &drawn ) };
    // the solid angle 2π versine, times the radiance 1 / ( π r² )
    s.weight = (float)( 2.0 * versine / r2 );
    double cosine = 1.0 - drawn, half = sqrt( fmax( r2 - d2 * drawn * ( 2.0 - drawn ), 0.0 ) );
    s.distance = (float)( lamp->soft ? d / cosine : inside ? d * cosine + half : d * cosine - half );
    return s;
}

RfExtentSample rf_sample_sun( const RfPunctual* lamp, const float u[2] )
{
    double versine = (double)lamp->versine, drawn;
    // the solid angle 2π versine, times the radiance 1 / ( π sin² )
    return ( RfExtentSample ){ .wi = sample_cone( rf_scale( lamp->direction, -1.0f ), versine, u, &drawn ),
                               .weight = (float)( 2.0 / ( 2.0 - versine ) ) };
}

// A rectangle seen from the origin, at the height z above 0.
typedef struct Rectangle
{
    double x0, x1, y0, y1, z;
} Rectangle;

static double clamp( double x, double low, double high ) { return fmin( fmax( x, low ), high ); }

// By area: returns the inverse of the density per solid angle.
static double sample_area( const Rectangle* r, const float u[2], double at[2] )
{
    at[0] = r->x0 + (double)u[0] * ( r->x1 - r->x0 );
    at[1] = r->y0 + (double)u[1] * ( r->y1 - r->y0 );
    double d2 = at[0] * at[0] + at[1] * at[1] + r->z * r->z;
    return ( r->x1 - r->x0 ) * ( r->y1 - r->y0 ) * r->z / ( d2 * sqrt( d2 ) );
}

// The cosine of an angle between the planes through the eye and two neighbouring sides; `a` and `b`: how far these are off.
static double corner( double a, double b, double z ) { return a * b / sqrt( ( a * a + z * z ) * ( b * b + z * z ) ); }

// By solid angle, which it returns.
static double sample_spherical( const Rectangle* r, const float u[2], double at[2] )
{
    double z2 = r->z * r->z, b0 = -r->y0 / sqrt( r->y0 * r->y0 + z2 ), b1 = r->y1 / sqrt( r->y1 * r->y1 + z2 );
    // the angles at (x1, y0), (x1, y1), (x0, y1), (x0, y0)
    double g0 = acos( clamp( corner( r->y0, r->x1, r->z ), -1.0, 1.0 ) ),
           g1 = acos( clamp( -corner( r->x1, r->y1, r->z ), -1.0, 1.0 ) );
    double g2 = acos( clamp( corner( r->y1, r->x0, r->z ), -1.0, 1.0 ) ),
           g3 = acos( clamp( -corner( r->x0, r->y0, r->z ), -1.0, 1.0 ) );
    double k = 2.0 * PI - g2 - g3, solid_angle = g0 + g1 - k;
    double au = (double)u[0] * solid_angle + k, sine = sin( au );
    double fu = ( cos( au ) * b0 - b1 ) / ( fabs( sine ) > 1e-300 ? sine : 1e-300 );
    double cu = clamp( copysign( 1.0 / sqrt( fmax( fu * fu + b0 * b0, 1e-300 ) ), fu ), -1.0, 1.0 );
    at[0] = clamp( cu * r->z / sqrt( fmax( 1.0 - cu * cu, 1e-300 ) ), r->x0, r->x1 );
    double d2 = at[0] * at[0] + z2, h0 = r->y0 / sqrt( d2 + r->y0 * r->y0 ), h1 = r->y1 / sqrt( d2 + r->y1 * r->y1 );
    double h = h0 + (double)u[1] * ( h1 - h0 );
    at[1] = clamp( h * sqrt( d2 / fmax( 1.0 - h * h, 1e-300 ) ), r->y0, r->y1 );
    return solid_angle;
}

RfExtentSample rf_sample_plane( const RfPunctual* lamp, RfVec3 from, const float u[2] )
{
    RfExtentSample none = { .weight = 0.0f };
    RfVec3 way = rf_sub( from, lamp->position ), up = rf_plane_up( lamp );
    double x = (double)rf_dot( way, lamp->across ), y = (double)rf_dot( way, up ), z = (double)rf_dot( way, lamp->direction );
    double reach = lamp->tan_spread > 0.0f ? z * (double)lamp->tan_spread : (double)INFINITY, at[2];
    double half_x = (double)lamp->half[0], half_y = (double)lamp->half[1];
    Rectangle r = { fmax( -half_x - x, -reach ), fmin( half_x - x, reach ), fmax( -half_y - y, -reach ),
                    fmin( half_y - y, reach ), z };
    if ( !( z > 0.0 && r.x0 < r.x1 && r.y0 < r.y1 ) )
        return none;
    double solid_angle = sample_spherical( &r, u, at );
    if ( solid_angle < SMALL )
        solid_angle = sample_area( &r, u, at );
    double ex = ( x + at[0] ) / half_x, ey = ( y + at[1] ) / half_y;
    if ( lamp->ellipse && ex * ex + ey * ey > 1.0 )
        return none;
    double distance = sqrt( at[0] * at[0] + at[1] * at[1] + z * z ), cosine = z / distance;
    RfVec3 to = rf_madd( rf_scale( lamp->across, (float)at[0] ), up, (float)at[1] );
    RfExtentSample s = { .wi = rf_normalize( rf_madd( to, lamp->direction, (float)-z ) ),
                         .distance = (float)( distance * ( 1.0 - 1e-5 ) ) };
    s.weight = (float)( solid_angle / rf_plane_area( lamp ) ) * rf_spread_falloff( lamp, (float)cosine );
    return s;
}
