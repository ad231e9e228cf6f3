#include "light/tree_bounds.h"

#include <math.h>

#define PI 3.14159265358979324

RfLightBounds rf_no_lights( void )
{
    return ( RfLightBounds ){ .low = { INFINITY, INFINITY, INFINITY }, .high = { -INFINITY, -INFINITY, -INFINITY } };
}

static bool is_empty( const RfLightBounds* b ) { return b->low[0] > b->high[0]; }

static double dot( const double a[3], const double b[3] ) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static double angle_of( double cosine ) { return acos( cosine > 1.0 ? 1.0 : ( cosine < -1.0 ? -1.0 : cosine ) ); }

static void face_everywhere( RfLightBounds* a )
{
    a->cos_spread = -1.0;
    a->two_sided = false;
}

static void take_cone( RfLightBounds* a, const RfLightBounds* b )
{
    for ( int i = 0; i < 3; ++i )
        a->axis[i] = b->axis[i];
    a->cos_spread = b->cos_spread;
    a->two_sided = b->two_sided;
}

// Rotates the axis by `turn` towards the unit vector b; `angle` is between them.
static void turn_axis( double axis[3], const double b[3], double angle, double turn )
{
    if ( !( sin( angle ) > 0.0 ) )
        return;
    double sum = 0.0, from = sin( angle - turn ) / sin( angle ), to = sin( turn ) / sin( angle );
    for ( int i = 0; i < 3; ++i )
    {
        axis[i] = from * axis[i] + to * b[i];
        sum += axis[i] * axis[i];
    }
    for ( int i = 0; i < 3; ++i )
        axis[i] /= sqrt( sum );
}

// The union of two cones; those of two-sided lights are double cones.
static void unite_cones( RfLightBounds* a, const RfLightBounds* b )
{
    double cos_angle = dot( a->axis, b->axis );
    bool flip = a->two_sided && b->two_sided && cos_angle < 0.0;
    cos_angle = flip ? -cos_angle : cos_angle;
    if ( cos_angle >= 1.0 - 1e-14 && a->cos_spread == b->cos_spread && a->two_sided == b->two_sided )
        return;
    if ( b->cos_spread == 1.0 && cos_angle >= a->cos_spread && a->two_sided == b->two_sided )
        return; // a single direction inside the cone
    double other[3] = { flip ? -b->axis[0] : b->axis[0], flip ? -b->axis[1] : b->axis[1], flip ? -b->axis[2] : b->axis[2] };
    double angle = angle_of( cos_angle ), spread_a = angle_of( a->cos_spread ), spread_b = angle_of( b->cos_spread );
    double spread = 0.5 * ( spread_a + angle + spread_b );
    if ( a->two_sided != b->two_sided )
        face_everywhere( a ); // NOLINT(bugprone-branch-clone): as further down, but the order matters
    else if ( angle + spread_b <= spread_a )
        return;
    else if ( angle + spread_a <= spread_b )
        take_cone( a, b );
    else if ( spread >= PI || cos_angle < -1.0 + 1e-9 )
        face_everywhere( a );
    else
    {
        turn_axis( a->axis, other, angle, spread - spread_a );
        a->cos_spread = cos( spread );
    }
}

void rf_bound_both( RfLightBounds* a, const RfLightBounds* b )
{
    if ( is_empty( b ) )
        return;
    if ( is_empty( a ) )
    {
        *a = *b;
        return;
    }
    for ( int i = 0; i < 3; ++i )
    {
        a->low[i] = fmin( a->low[i], b->low[i] );
        a->high[i] = fmax( a->high[i], b->high[i] );
    }
    a->intensity += b->intensity;
    a->cos_emission = fmin( a->cos_emission, b->cos_emission );
    unite_cones( a, b );
}

// The solid angle that the cone lights, weighted by the cosine beyond the spread.
static double measure_of_directions( const RfLightBounds* b )
{
    double spread = angle_of( b->cos_spread ), reach = fmin( spread + angle_of( b->cos_emission ), PI );
    double s = sin( spread ), c = b->cos_spread;
    double one = 2.0 * PI * ( 1.0 - c ) + 0.5 * PI * ( 2.0 * reach * s - cos( spread - 2.0 * reach ) - 2.0 * spread * s + c );
    return b->two_sided ? fmin( 2.0 * one, 4.0 * PI ) : one;
}

double rf_bounds_cost( const RfLightBounds* b )
{
    if ( is_empty( b ) )
        return 0.0;
    double diagonal2 = 0.0;
    for ( int i = 0; i < 3; ++i )
        diagonal2 += ( b->high[i] - b->low[i] ) * ( b->high[i] - b->low[i] );
    return b->intensity * measure_of_directions( b ) * diagonal2;
}
