#include "measure/follow.h"

#include <math.h>
#include <stdlib.h>

#define FORGIVEN 1e-3 // tolerance, pixels

void rf_destroy_flicker_frame( RfFlickerFrame* frame )
{
    rf_destroy_image( &frame->signal );
    rf_destroy_image( &frame->variance );
    free( frame->motion );
    free( frame->depth );
    *frame = ( RfFlickerFrame ){ 0 };
}

static void cross( const double* a, const double* b, double out[3] )
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot( const double* a, const double* b ) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Expresses the other camera's depth by coordinates of this one. This camera gives (x z, y z,
// z) = C·P + c, and the other's depth is w·P + v. With q from Cᵀ q = w, that depth is q·((x z,
// y z, z) − c) + v.
static bool expect_depth( const double now[3][4], const double before[4], double expect[4] )
{
    double q[3], normal[3];
    cross( now[1], now[2], normal );
    double volume = dot( now[0], normal ), size = 1.0;
    for ( int i = 0; i < 3; ++i )
        size *= sqrt( dot( now[i], now[i] ) );
    if ( !( fabs( volume ) > 1e-9 * size ) || !isfinite( volume ) )
        return false;
    for ( int i = 0; i < 3; ++i )
    {
        cross( now[( i + 1 ) % 3], now[( i + 2 ) % 3], normal );
        q[i] = dot( before, normal ) / volume;
        expect[i] = q[i];
    }
    expect[3] = before[3] - q[0] * now[0][3] - q[1] * now[1][3] - q[2] * now[2][3];
    return isfinite( expect[0] + expect[1] + expect[2] + expect[3] );
}

RfFollow rf_follow( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate )
{
    RfFollow follow = { .now = now, .before = before, .compensate = compensate };
    if ( !now->has_camera || !before->has_camera || !expect_depth( now->camera, before->camera[2], follow.expect ) )
    {
        follow.expect[0] = follow.expect[1] = follow.expect[3] = 0.0;
        follow.expect[2] = 1.0;
    }
    return follow;
}

// Splits a coordinate inside the image into integer and fraction; false outside.
static bool split( double x, int size, int* first, double* rest )
{
    if ( !isgreaterequal( x, -FORGIVEN ) || !islessequal( x, size - 1 + FORGIVEN ) )
        return false;
    x = x < 0.0 ? 0.0 : x > size - 1 ? size - 1 : x;
    *first = (int)x;
    *rest = x - *first;
    return true;
}

bool rf_find_taps( int width, int height, double x, double y, RfTaps* taps )
{
    int column, row;
    double u, v;
    taps->count = 0;
    if ( !split( x, width, &column, &u ) || !split( y, height, &row, &v ) )
        return false;
    for ( int k = 0; k < 4; ++k )
    {
        double weight = ( k & 1 ? u : 1.0 - u ) * ( k & 2 ? v : 1.0 - v );
        if ( weight == 0.0 )
            continue;
        taps->pixel[taps->count] = (size_t)( row + ( k >> 1 ) ) * (size_t)width + (size_t)( column + ( k & 1 ) );
        taps->weight[taps->count++] = weight;
    }
    return true;
}

typedef enum Seen
{
    SEEN_SOMETHING,
    SEEN_NOTHING,
    SEEN_BOTH, // a depth edge between them, or undefined depth
} Seen;

static bool is_background( double z ) { return z >= RF_FOLLOW_NO_SURFACE || z <= 0.0; }

static Seen find_depth( const float* depth, const RfTaps* taps, double* z )
{
    int nothing = 0;
    *z = 0.0;
    for ( int k = 0; k < taps->count; ++k )
    {
        double value = (double)depth[taps->pixel[k]];
        if ( isnan( value ) )
            return SEEN_BOTH;
        nothing += is_background( value );
        *z += taps->weight[k] * value;
    }
    return nothing == 0 ? SEEN_SOMETHING : nothing == taps->count ? SEEN_NOTHING : SEEN_BOTH;
}

static bool is_same_surface( const RfFollow* follow, double x, double y, const RfTaps* here, const RfTaps* there )
{
    if ( follow->now->depth == NULL || follow->before->depth == NULL )
        return true;
    double z, found;
    Seen seen = find_depth( follow->now->depth, here, &z );
    if ( seen == SEEN_BOTH || find_depth( follow->before->depth, there, &found ) != seen )
        return false;
    if ( seen == SEEN_NOTHING )
        return true;
    const double* e = follow->expect;
    double expected = z * ( e[0] * x + e[1] * y + e[2] ) + e[3];
    return fabs( found - expected ) <= RF_FOLLOW_DEPTH_TOLERANCE * expected;
}

bool rf_follow_point( const RfFollow* follow, double* x, double* y, RfTaps* taps )
{
    const RfImage* now = &follow->now->signal;
    const RfImage* before = &follow->before->signal;
    RfTaps here;
    if ( !follow->compensate )
        return rf_find_taps( before->width, before->height, *x, *y, taps );
    if ( !rf_find_taps( now->width, now->height, *x, *y, &here ) )
        return false;
    double motion[2] = { 0.0, 0.0 };
    for ( int k = 0; k < here.count; ++k )
    {
        motion[0] += here.weight[k] * (double)follow->now->motion[2 * here.pixel[k]];
        motion[1] += here.weight[k] * (double)follow->now->motion[2 * here.pixel[k] + 1];
    }
    double x_before = *x + motion[0], y_before = *y - motion[1];
    if ( !rf_find_taps( before->width, before->height, x_before, y_before, taps ) )
        return false;
    if ( !is_same_surface( follow, *x, *y, &here, taps ) )
        return false;
    *x = x_before;
    *y = y_before;
    return true;
}
