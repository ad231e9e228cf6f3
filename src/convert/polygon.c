#include "convert/polygon.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

// Projection along the axis in which the mean normal is longest, onto two coordinates; `sign`
// makes counter-clockwise positive.
typedef struct Plane
{
    const float* positions;
    int u, v;
    double sign;
} Plane;

// Newell's method: the normal's components are twice the projected areas.
static Plane find_plane( const float* positions, const uint32_t* corners, uint32_t count )
{
    double n[3] = { 0 };
    for ( uint32_t i = 0; i < count; ++i )
    {
        const float* a = positions + 3 * (size_t)corners[i];
        const float* b = positions + 3 * (size_t)corners[( i + 1 ) % count];
        for ( int k = 0; k < 3; ++k )
        {
            int u = ( k + 1 ) % 3, v = ( k + 2 ) % 3;
            n[k] += (double)a[u] * (double)b[v] - (double)a[v] * (double)b[u];
        }
    }
    int axis = fabs( n[0] ) > fabs( n[1] ) ? 0 : 1;
    axis = fabs( n[2] ) > fabs( n[axis] ) ? 2 : axis;
    return ( Plane ){ positions, ( axis + 1 ) % 3, ( axis + 2 ) % 3, n[axis] < 0.0 ? -1.0 : 1.0 };
}

// Twice the signed area of a triangle; negative if it has the opposite winding.
static double area( const Plane* plane, uint32_t a, uint32_t b, uint32_t c )
{
    const float *p = plane->positions + 3 * (size_t)a, *q = plane->positions + 3 * (size_t)b,
                *r = plane->positions + 3 * (size_t)c;
    double x1 = (double)q[plane->u] - (double)p[plane->u], y1 = (double)q[plane->v] - (double)p[plane->v];
    double x2 = (double)r[plane->u] - (double)p[plane->u], y2 = (double)r[plane->v] - (double)p[plane->v];
    return plane->sign * ( x1 * y2 - x2 * y1 );
}

static bool is_convex( const Plane* plane, const uint32_t* corners, uint32_t count )
{
    for ( uint32_t i = 0; i < count; ++i )
    {
        if ( area( plane, corners[i], corners[( i + 1 ) % count], corners[( i + 2 ) % count] ) < 0.0 )
            return false;
    }
    return true;
}

// True if corner i is convex and no other corner is inside its triangle.
static bool is_ear( const Plane* plane, const uint32_t* corners, uint32_t count, uint32_t i )
{
    uint32_t a = corners[( i + count - 1 ) % count], b = corners[i], c = corners[( i + 1 ) % count];
    if ( area( plane, a, b, c ) <= 0.0 )
        return false;
    for ( uint32_t k = 0; k < count; ++k )
    {
        uint32_t p = corners[k];
        if ( p == a || p == b || p == c )
            continue;
        if ( area( plane, a, b, p ) >= 0.0 && area( plane, b, c, p ) >= 0.0 && area( plane, c, a, p ) >= 0.0 )
            return false;
    }
    return true;
}

static uint32_t* put_triangle( uint32_t* triangles, uint32_t a, uint32_t b, uint32_t c )
{
    triangles[0] = a;
    triangles[1] = b;
    triangles[2] = c;
    return triangles + 3;
}

static void fan( const uint32_t* corners, uint32_t count, uint32_t* triangles )
{
    for ( uint32_t i = 1; i + 1 < count; ++i )
        triangles = put_triangle( triangles, corners[0], corners[i], corners[i + 1] );
}

// Finds the first ear; returns `count` if there is none or the steps ran out.
static uint32_t find_ear( const Plane* plane, const uint32_t* corners, uint32_t count, uint64_t* steps )
{
    for ( uint32_t i = 0; i < count; ++i )
    {
        if ( *steps < count )
        {
            *steps = 0;
            return count;
        }
        *steps -= count;
        if ( is_ear( plane, corners, count, i ) )
            return i;
    }
    return count;
}

RfCut rf_cut_polygon( const float* positions, uint32_t* corners, uint32_t count, uint32_t* triangles, uint64_t* steps )
{
    Plane plane = find_plane( positions, corners, count );
    if ( count == 3 || is_convex( &plane, corners, count ) )
    {
        fan( corners, count, triangles );
        return RF_CUT_WHOLE;
    }
    while ( count > 3 )
    {
        uint32_t i = find_ear( &plane, corners, count, steps );
        if ( i == count && *steps == 0 )
            return RF_CUT_GIVEN_UP;
        if ( i == count )
        {
            fan( corners, count, triangles );
            return RF_CUT_CROSSED;
        }
        triangles = put_triangle( triangles, corners[( i + count - 1 ) % count], corners[i], corners[( i + 1 ) % count] );
        for ( --count; i < count; ++i )
            corners[i] = corners[i + 1];
    }
    put_triangle( triangles, corners[0], corners[1], corners[2] );
    return RF_CUT_WHOLE;
}
