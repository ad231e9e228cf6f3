// Maps points to pixels and pixels to rays: perspective, orthographic, panoramic.
#include "scene/projection.h"

#include "scene/scene.h"

#include <math.h>

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
