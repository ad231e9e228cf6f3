// Projections, lenses and shutters of eyes.
#include "scene/projection.h"

#include "base/fault.h"
#include "scene/lens.h"
#include "scene/scene.h"

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

#define TRAITS( kind, ... ) [kind] = { __VA_ARGS__ },
#define NAME( kind, name, ... ) [kind] = name,
#define CASE( kind, ... )                                                                                                        \
    case kind: break;

static const RfProjectionTraits s_traits[] = { RF_PROJECTIONS( TRAITS ) };

const char* const g_rf_projection_names[] = { RF_PROJECTIONS( NAME ) NULL };

const RfProjectionTraits* rf_projection_traits( RfProjectionKind kind )
{
    switch ( kind ) // so that the compiler warns of a kind without a row
    {
        RF_PROJECTIONS( CASE )
    }
    return s_traits + kind;
}

float rf_eye_reach( const RfEye* eye )
{
    float reach = rf_largest_coordinate( eye->origin );
    if ( !rf_is_parallel( eye ) )
        return reach;
    return reach + ( (float)eye->width + fabsf( eye->axis_x ) ) / eye->focal_x +
           ( (float)eye->height + fabsf( eye->axis_y ) ) / eye->focal;
}

// Longitude grows to the right, latitude upwards; `forward` is in the middle.
static RfVec3 panoramic_direction( const RfEye* eye, float longitude, float latitude )
{
    float across = cosf( latitude );
    RfVec3 d = rf_scale( eye->forward, across * cosf( longitude ) );
    return rf_madd( rf_madd( d, eye->right, across * sinf( longitude ) ), eye->up, sinf( latitude ) );
}

void rf_eye_ray( const RfEye* eye, const float inverse[2], int column, int row, float u, float v, RfVec3* o, RfVec3* d )
{
    float x = ( (float)column + u - eye->axis_x ) * inverse[0], y = ( eye->axis_y - (float)row - v ) * inverse[1];
    *o = eye->origin;
    switch ( rf_projection_of( eye ) )
    {
        case RF_PERSPECTIVE: *d = rf_pinhole_ray( eye, inverse, column, row, u, v ); break;
        case RF_ORTHOGRAPHIC:
            *o = rf_madd( rf_madd( eye->origin, eye->right, x ), eye->up, y );
            *d = rf_normalize( rf_parallel_direction( eye ) );
            break;
        case RF_PANORAMIC: *d = panoramic_direction( eye, x, y ); break;
    }
}

// Pixels from where `forward` meets the film, +y up.
static void panoramic_position( const RfEye* eye, RfVec3 way, float at[2] )
{
    float x = rf_dot( way, eye->right ), z = rf_dot( way, eye->forward );
    at[0] = atan2f( x, z ) * eye->focal_x;
    at[1] = atan2f( rf_dot( way, eye->up ), sqrtf( x * x + z * z ) ) * eye->focal;
}

static void parallel_position( const RfEye* eye, RfVec3 way, float depth, float at[2] )
{
    at[0] = ( rf_dot( way, eye->right ) - depth * eye->shear_x ) * eye->focal_x;
    at[1] = ( rf_dot( way, eye->up ) - depth * eye->shear_y ) * eye->focal;
}

bool rf_eye_position( const RfEye* eye, RfVec3 point, bool infinite, float at[2] )
{
    RfVec3 way = infinite ? point : rf_sub( point, eye->origin );
    float depth = rf_dot( way, eye->forward );
    bool seen = false;
    at[0] = at[1] = 0.0f;
    switch ( rf_projection_of( eye ) )
    {
        case RF_PERSPECTIVE: return rf_pinhole_position( eye, way, at ) > 0.0f;
        case RF_ORTHOGRAPHIC:
            if ( !infinite )
                parallel_position( eye, way, depth, at );
            seen = depth > 0.0f && !infinite;
            break;
        case RF_PANORAMIC:
            panoramic_position( eye, way, at );
            seen = rf_dot( way, way ) > 0.0f;
            break;
    }
    at[0] += eye->axis_x - 0.5f * (float)eye->width;
    at[1] += 0.5f * (float)eye->height - eye->axis_y;
    return seen;
}

// J = f² |cosθx| over the cosine between rays and film: f² (−ng·d) for a direction of 1 m along `forward`.
static float parallel_density( const RfEye* eye, float facing ) { return eye->focal_x * eye->focal * facing; }

// J = f² cosθx / (d² cos φ), where a pixel at latitude φ has the solid angle cos φ / f².
static float panoramic_density( const RfEye* eye, RfVec3 way, float facing )
{
    float x = rf_dot( way, eye->right ), z = rf_dot( way, eye->forward ), d2 = rf_dot( way, way );
    return eye->focal_x * eye->focal * facing / rf_pinhole_divisor( d2 * sqrtf( x * x + z * z ), FLT_MIN );
}

// Rounding may lead beyond the seam and the poles; they belong to the film.
static void keep_on_panorama( const RfEye* eye, float* fx, float* fy )
{
    float width = (float)eye->width, height = (float)eye->height;
    *fx = *fx < 0.0f ? *fx + width : *fx >= width ? *fx - width : *fx;
    *fx = rf_clampf( *fx, 0.0f, width * ( 1.0f - 1e-7f ) );
    *fy = rf_clampf( *fy, 0.0f, height * ( 1.0f - 1e-7f ) );
}

// From where `forward` meets the film to film coordinates.
static void to_film( const RfEye* eye, const float at[2], float* fx, float* fy )
{
    *fx = eye->axis_x + at[0];
    *fy = eye->axis_y - at[1];
}

RfProjection rf_project_otherwise( const RfEye* eye, RfVec3 x, RfVec3 ng )
{
    RfVec3 way = rf_sub( x, eye->origin );
    float depth = rf_dot( way, eye->forward ), facing = 0.0f, density = 0.0f, fx = 0.0f, fy = 0.0f, at[2];
    bool before = true;
    switch ( rf_projection_of( eye ) )
    {
        case RF_PERSPECTIVE: return rf_project( eye, x, ng );
        case RF_ORTHOGRAPHIC:
            facing = -rf_dot( rf_parallel_direction( eye ), ng );
            density = parallel_density( eye, facing );
            parallel_position( eye, way, depth, at );
            to_film( eye, at, &fx, &fy );
            before = depth > 0.0f;
            break;
        case RF_PANORAMIC:
            facing = -rf_dot( way, ng );
            density = panoramic_density( eye, way, facing );
            panoramic_position( eye, way, at );
            to_film( eye, at, &fx, &fy );
            keep_on_panorama( eye, &fx, &fy );
            break;
    }
    density = density > RF_MIN_DENSITY ? density : RF_MIN_DENSITY;
    density = density < RF_MAX_DENSITY ? density : RF_MAX_DENSITY;
    bool seen = before && facing > 0.0f && fx >= 0.0f && fx < (float)eye->width && fy >= 0.0f && fy < (float)eye->height;
    int32_t column = (int32_t)( seen ? fx : 0.0f ), row = (int32_t)( seen ? fy : 0.0f );
    return ( RfProjection ){ column, row, density, fx - (float)column, fy - (float)row, seen };
}
