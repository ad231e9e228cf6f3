// Samples the aperture (a disc or a polygon, uniformly by area) and the camera's pose while the shutter is open.
#include "scene/lens.h"

#include "base/fault.h"

#include <math.h>

#define PI 3.14159265358979323846

static RfPose pose_of( const RfEye* eye )
{
    return ( RfPose ){ eye->origin, eye->forward, eye->up, eye->focal, eye->axis_x, eye->axis_y };
}

void rf_set_lens( RfEye* eye, double radius, double focus, int blades, double rotation )
{
    eye->lens_radius = (float)radius;
    eye->focus = (float)focus;
    eye->blades = blades;
    eye->blade_angle = (float)rotation;
}

static bool is_same_point( RfVec3 a, RfVec3 b )
{
    return !( a.x < b.x || a.x > b.x || a.y < b.y || a.y > b.y || a.z < b.z || a.z > b.z );
}

static bool is_same_pose( const RfPose* a, const RfPose* b )
{
    return is_same_point( a->origin, b->origin ) && is_same_point( a->forward, b->forward ) && is_same_point( a->up, b->up ) &&
           is_same_point( rf_vec3( a->focal, a->axis_x, a->axis_y ), rf_vec3( b->focal, b->axis_x, b->axis_y ) );
}

void rf_set_shutter( RfEye* eye, const RfEye* open, const RfEye* close )
{
    RfPose middle = pose_of( eye );
    eye->open = pose_of( open );
    eye->close = pose_of( close );
    eye->moves = !is_same_pose( &middle, &eye->open ) || !is_same_pose( &middle, &eye->close );
    if ( !eye->moves )
        eye->open = eye->close = ( RfPose ){ 0 };
}

bool rf_any_blurred( const RfEye* eyes, int count )
{
    bool any = false;
    for ( int i = 0; i < count; ++i )
        any = any || !rf_is_sharp( eyes + i );
    return any;
}

// A uniform point of a disc: equal areas on rings.
static void disc_point( double u, double v, float point[2] )
{
    double r = sqrt( u ), angle = 2.0 * PI * v;
    point[0] = (float)( r * cos( angle ) );
    point[1] = (float)( r * sin( angle ) );
}

// A uniform point of a regular polygon: of one of the triangles around its centre.
static void polygon_point( int blades, double turn, double u, double v, float point[2] )
{
    double scaled = v * blades, side = floor( scaled );
    side = side < blades - 1 ? side : blades - 1;
    double along = scaled - side, r = sqrt( u ), step = 2.0 * PI / blades;
    double a = turn + side * step, b = a + step;
    point[0] = (float)( r * ( ( 1.0 - along ) * cos( a ) + along * cos( b ) ) );
    point[1] = (float)( r * ( ( 1.0 - along ) * sin( a ) + along * sin( b ) ) );
}

void rf_lens_point( const RfEye* eye, float u, float v, float point[2] )
{
    if ( eye->blades >= 3 )
        polygon_point( eye->blades, (double)eye->blade_angle, (double)u, (double)v, point );
    else
        disc_point( (double)u, (double)v, point );
}

// Through the three poses at −1, 0 and 1.
static double through( float open, float middle, float close, double t )
{
    double o = (double)open, m = (double)middle, c = (double)close;
    return m + 0.5 * t * ( c - o + t * ( o + c - 2.0 * m ) );
}

static RfVec3 through3( RfVec3 open, RfVec3 middle, RfVec3 close, double t )
{
    return rf_vec3( (float)through( open.x, middle.x, close.x, t ), (float)through( open.y, middle.y, close.y, t ),
                    (float)through( open.z, middle.z, close.z, t ) );
}

static void move_eye( RfEye* eye, double t )
{
    const RfPose *o = &eye->open, *c = &eye->close;
    RfVec3 forward = through3( o->forward, eye->forward, c->forward, t ), up = through3( o->up, eye->up, c->up, t );
    double f[3] = { (double)forward.x, (double)forward.y, (double)forward.z };
    double u[3] = { (double)up.x, (double)up.y, (double)up.z }, r[3];
    rf_unit3( f );
    rf_cross3( f, u, r );
    rf_unit3( r );
    rf_cross3( r, f, u );
    float focal = (float)through( o->focal, eye->focal, c->focal, t );
    eye->focal_x *= focal / eye->focal;
    eye->focal = focal;
    eye->axis_x = (float)through( o->axis_x, eye->axis_x, c->axis_x, t );
    eye->axis_y = (float)through( o->axis_y, eye->axis_y, c->axis_y, t );
    eye->origin = through3( o->origin, eye->origin, c->origin, t );
    eye->forward = rf_vec3( (float)f[0], (float)f[1], (float)f[2] );
    eye->right = rf_vec3( (float)r[0], (float)r[1], (float)r[2] );
    eye->up = rf_vec3( (float)u[0], (float)u[1], (float)u[2] );
}

RfEye rf_sample_eye( const RfEye* eye, RfLensSample sample )
{
    RfEye out = *eye;
    if ( eye->moves )
        move_eye( &out, 2.0 * (double)sample.time - 1.0 );
    if ( eye->lens_radius > 0.0f )
    {
        float point[2];
        rf_lens_point( eye, sample.u, sample.v, point );
        float x = eye->lens_radius * point[0], y = eye->lens_radius * point[1];
        out.origin = rf_madd( rf_madd( out.origin, out.right, x ), out.up, y );
        switch ( (RfProjectionKind)eye->projection )
        {
            case RF_ORTHOGRAPHIC:
                out.shear_x = -x / eye->focus;
                out.shear_y = -y / eye->focus;
                break;
            case RF_PERSPECTIVE:
            {
                float focus = RF_FAULT( focus_order ) ? eye->focus * eye->focus / eye->focus : eye->focus;
                out.axis_x += out.focal_x * x / focus;
                out.axis_y -= out.focal * y / eye->focus;
                break;
            }
            case RF_PANORAMIC: break; // takes no lens
        }
    }
    out.lens_radius = 0.0f;
    out.moves = 0;
    return out;
}
