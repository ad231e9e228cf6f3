// The kinds of a light, one after the other, and the table of them.
#include "light/kinds.h"

#include "base/random.h"
#include "light/extent.h"
#include "light/punctual.h"

#include <math.h>

#define PI 3.14159265358979324

// Distance of directional lights in the light tree, in radii of the scene. Their direction is off by at most its inverse, which
// the slack of rf_light_importance covers.
#define DISTANT 1e4

// Shared by several kinds.

static bool shines( RfVec3 v )
{
    float most = rf_max_component( v );
    return most > 0.0f && most < INFINITY;
}

// False if floats do not hold the throughput.
static bool set_throughput( RfEmission* e, double cosine )
{
    double scale = cosine / ( (double)e->pdf_light * (double)e->pdf_area * (double)e->pdf_solid_angle );
    e->throughput = rf_vec3( (float)( (double)e->radiance.x * scale ), (float)( (double)e->radiance.y * scale ),
                             (float)( (double)e->radiance.z * scale ) );
    return shines( e->throughput );
}

// The direction of this cosine to a unit axis.
static RfVec3 around( RfVec3 axis, double cosine, float turn )
{
    RfVec3 t, b;
    rf_basis( axis, &t, &b );
    double sine = sqrt( fmax( ( 1.0 - cosine ) * ( 1.0 + cosine ), 0.0 ) ), phi = 2.0 * PI * (double)turn;
    RfVec3 across = rf_add( rf_scale( t, (float)( sine * cos( phi ) ) ), rf_scale( b, (float)( sine * sin( phi ) ) ) );
    return rf_normalize( rf_madd( across, axis, (float)cosine ) );
}

static void set_axis( RfTreeLight* out, RfVec3 v )
{
    double x = (double)v.x, y = (double)v.y, z = (double)v.z, length = sqrt( x * x + y * y + z * z );
    out->axis[0] = x / length;
    out->axis[1] = y / length;
    out->axis[2] = z / length;
}

static void extend_box( RfTreeLight* out, const RfLights* lights, RfVec3 p )
{
    double p_ball[3] = { (double)p.x - (double)lights->center.x, (double)p.y - (double)lights->center.y,
                         (double)p.z - (double)lights->center.z };
    for ( int i = 0; i < 3; ++i )
    {
        p_ball[i] *= (double)lights->inverse_radius;
        out->low[i] = fmin( out->low[i], p_ball[i] );
        out->high[i] = fmax( out->high[i], p_ball[i] );
    }
}

static RfTreeLight empty( uint32_t number )
{
    return ( RfTreeLight ){ .low = { INFINITY, INFINITY, INFINITY },
                            .high = { -INFINITY, -INFINITY, -INFINITY },
                            .axis = { 0, 0, 1 },
                            .cos_spread = -1.0,
                            .light = number };
}

// Scales intensities: the tree measures distances in radii of the scene.
static double per_ball( const RfLights* lights ) { return (double)lights->inverse_radius * (double)lights->inverse_radius; }

// Emissive triangles.

static bool is_two_sided( const RfLight* light ) { return rf_calls_for( light->two_sided, RF_EFFECT_TWO_SIDED_EMISSION ); }

static double triangle_selection_power( const RfLights* lights, uint32_t number )
{
    const RfLight* light = lights->light + number;
    return (double)rf_luminance( light->radiance ) * (double)light->area * ( light->two_sided ? 2.0 : 1.0 );
}

RfTreeLight rf_bound_triangle( const RfLights* lights, const RfLight* light, uint32_t number )
{
    RfTreeLight out = empty( number );
    extend_box( &out, lights, light->p0 );
    extend_box( &out, lights, rf_add( light->p0, light->e1 ) );
    extend_box( &out, lights, rf_add( light->p0, light->e2 ) );
    set_axis( &out, light->normal );
    out.cos_spread = 1.0;
    out.two_sided = light->two_sided;
    out.intensity = (double)rf_luminance( light->radiance ) * (double)light->area * per_ball( lights );
    return out;
}

static RfTreeLight triangle_bound( const RfLights* lights, uint32_t number )
{
    return rf_bound_triangle( lights, lights->light + number, number );
}

static double triangle_power( const RfLights* lights, uint32_t number )
{
    const RfLight* light = lights->light + number;
    return PI * (double)rf_luminance( light->radiance ) * (double)light->area * ( is_two_sided( light ) ? 2.0 : 1.0 );
}

static bool triangle_sample_emitter( const RfLights* lights, const RfScene* scene, float side, const float u[2], RfEmission* e )
{
    const RfLight* light = lights->light + e->light;
    float root = sqrtf( u[0] ), b1 = 1.0f - root, b2 = u[1] * root;
    e->position = rf_add( light->p0, rf_add( rf_scale( light->e1, b1 ), rf_scale( light->e2, b2 ) ) );
    e->normal = light->normal;
    if ( is_two_sided( light ) )
    {
        e->normal = rf_scale( light->normal, side < 0.5f ? 1.0f : -1.0f );
        e->pdf_light *= 0.5f;
    }
    e->pdf_area = light->pdf_area;
    e->offset = light->offset;
    e->radiance = rf_light_radiance( scene, light, b1, b2 );
    return shines( e->radiance );
}

// The radiance of a point is the same in all directions.
static bool triangle_emit( const RfLights* lights, RfEmission* e )
{
    (void)lights;
    float cosine = rf_dot( e->normal, e->direction );
    e->pdf_solid_angle = cosine * RF_INV_PI;
    return cosine > 0.0f && set_throughput( e, (double)cosine );
}

static bool triangle_steer( const RfLights* lights, const float u[2], RfEmission* e )
{
    e->direction = around( e->normal, sqrt( 1.0 - (double)u[0] ), u[1] );
    return triangle_emit( lights, e );
}

// One side emits unless both do.
static void triangle_find_pdf( const RfLights* lights, RfEmission* e )
{
    const RfLight* light = lights->light + e->light;
    float cosine = rf_dot( light->normal, e->direction );
    if ( is_two_sided( light ) )
    {
        cosine = fabsf( cosine );
        e->pdf_light *= 0.5f;
    }
    e->pdf_area = light->pdf_area;
    e->pdf_solid_angle = rf_maxf( cosine, 0.0f ) * RF_INV_PI;
}

// Balls and intensity profiles, of point and spot lights.

// Times the intensity, it is that of the point of a ball which has been drawn, for any ball a part of its mean. 1 of a point.
static float facing( const RfPunctual* lamp, RfEmission* e )
{
    if ( lamp->radius > 0.0f )
        return 4.0f * rf_maxf( rf_dot( e->normal, e->direction ), 0.0f );
    e->normal = e->direction;
    return 1.0f;
}

static double mean_of( const RfPunctual* lamp ) { return lamp->profile == NULL ? 1.0 : lamp->profile->mean; }

static double most_of( const RfPunctual* lamp ) { return lamp->profile == NULL ? 1.0 : (double)lamp->profile->most; }

static float profile_pdf( const RfPunctual* lamp, RfVec3 direction )
{
    return rf_profile_pdf_solid_angle( lamp->profile, rf_into_lamp( lamp, direction ) );
}

static bool emit_by_profile( const RfPunctual* lamp, RfEmission* e )
{
    float part = rf_lamp_falloff( lamp, e->direction ) * facing( lamp, e );
    e->radiance = rf_scale( lamp->intensity, part );
    e->pdf_solid_angle = profile_pdf( lamp, e->direction );
    return e->pdf_solid_angle > 0.0f && part > 0.0f && set_throughput( e, 1.0 );
}

static bool steer_by_profile( const RfPunctual* lamp, const float u[2], RfEmission* e )
{
    e->direction = rf_normalize( rf_out_of_lamp( lamp, rf_sample_profile( lamp->profile, u ) ) );
    return emit_by_profile( lamp, e );
}

// Its cone: as bright as the most up to the angle where it is half of that.
static void bound_profile( const RfPunctual* lamp, RfTreeLight* out )
{
    const RfProfile* profile = lamp->profile;
    double reach = acos( profile->cos_reach ), spread = fmax( acos( profile->cos_half ), reach - 0.5 * PI );
    set_axis( out, profile->up ? rf_scale( lamp->direction, -1.0f ) : lamp->direction );
    out->cos_spread = cos( spread );
    out->cos_emission = cos( reach - spread );
    out->intensity *= (double)profile->most;
}

// Point lights.

static double luminance_of( const RfPunctual* lamp ) { return (double)rf_luminance( lamp->intensity ); }

static double point_selection_power( const RfLights* lights, uint32_t light )
{
    const RfPunctual* lamp = rf_punctual_light( lights, light );
    return 4.0 * luminance_of( lamp ) * mean_of( lamp );
}

static RfTreeLight point_bound( const RfLights* lights, uint32_t light )
{
    const RfPunctual* lamp = rf_punctual_light( lights, light );
    RfTreeLight out = empty( light );
    out.intensity = luminance_of( lamp ) * per_ball( lights );
    RfVec3 r = rf_vec3( lamp->radius, lamp->radius, lamp->radius );
    extend_box( &out, lights, lamp->position );
    if ( lamp->radius > 0.0f )
    {
        extend_box( &out, lights, rf_sub( lamp->position, r ) );
        extend_box( &out, lights, rf_add( lamp->position, r ) );
    }
    if ( lamp->profile != NULL )
        bound_profile( lamp, &out );
    return out;
}

static double point_power( const RfLights* lights, uint32_t light )
{
    const RfPunctual* lamp = rf_punctual_light( lights, light );
    return 4.0 * PI * luminance_of( lamp ) * mean_of( lamp );
}

static bool point_sample_emitter( const RfLights* lights, const RfScene* scene, float side, const float u[2], RfEmission* e )
{
    (void)scene, (void)side;
    const RfPunctual* lamp = rf_punctual_light( lights, e->light );
    e->delta_position = true;
    e->position = lamp->position;
    e->pdf_area = 1.0f;
    e->range = lamp->range;
    if ( lamp->radius > 0.0f )
    {
        e->normal = around( rf_vec3( 0, 0, 1 ), 1.0 - 2.0 * (double)u[0], u[1] );
        e->position = rf_madd( lamp->position, e->normal, lamp->radius );
        e->soft = lamp->soft ? lamp : NULL;
    }
    return shines( lamp->intensity );
}

static void point_find_pdf( const RfLights* lights, RfEmission* e )
{
    const RfPunctual* lamp = rf_punctual_light( lights, e->light );
    e->pdf_solid_angle = lamp->profile == NULL ? 0.25f * RF_INV_PI : profile_pdf( lamp, e->direction );
}

static bool point_emit( const RfLights* lights, RfEmission* e )
{
    const RfPunctual* lamp = rf_punctual_light( lights, e->light );
    if ( lamp->profile != NULL )
        return emit_by_profile( lamp, e );
    float part = facing( lamp, e );
    e->radiance = rf_scale( lamp->intensity, part );
    e->pdf_solid_angle = 0.25f * RF_INV_PI;
    return part > 0.0f && set_throughput( e, 1.0 );
}

static bool point_steer( const RfLights* lights, const float u[2], RfEmission* e )
{
    const RfPunctual* lamp = rf_punctual_light( lights, e->light );
    if ( lamp->profile != NULL )
        return steer_by_profile( lamp, u, e );
    e->direction = around( rf_vec3( 0, 0, 1 ), 1.0 - 2.0 * (double)u[0], u[1] );
    return point_emit( lights, e );
}

// Spot lights: point lights with a cone.

// The integral of the falloff over the cosines to the axis: solid angle over 2π.
static double spot_integral( const RfPunctual* spot )
{
    double outer = (double)spot->cos_outer, blend = (double)rf_spot_blend( spot ), most = fmin( 1.0, ( 1.0 - outer ) / blend );
    return blend * most * most * most / 3.0 + fmax( 1.0 - outer - blend, 0.0 );
}

// The falloff is taken for half on average between the cones.
static double spot_selection_power( const RfLights* lights, uint32_t light )
{
    const RfPunctual* spot = rf_punctual_light( lights, light );
    return 2.0 * ( 1.0 - 0.5 * (double)( spot->cos_inner + spot->cos_outer ) ) * luminance_of( spot ) * most_of( spot );
}

static RfTreeLight spot_bound( const RfLights* lights, uint32_t light )
{
    const RfPunctual* spot = rf_punctual_light( lights, light );
    RfTreeLight out = point_bound( lights, light ); // with the most of a profile
    set_axis( &out, spot->direction );
    out.cos_spread = (double)spot->cos_inner;
    out.cos_emission = cos( acos( (double)spot->cos_outer ) - acos( (double)spot->cos_inner ) );
    return out;
}

static double spot_power( const RfLights* lights, uint32_t light )
{
    const RfPunctual* spot = rf_punctual_light( lights, light );
    return fmin( 2.0 * PI * spot_integral( spot ) * most_of( spot ), 4.0 * PI * mean_of( spot ) ) * luminance_of( spot );
}

static bool spot_sample_emitter( const RfLights* lights, const RfScene* scene, float side, const float u[2], RfEmission* e )
{
    return point_sample_emitter( lights, scene, side, u, e );
}

static bool spot_emit( const RfLights* lights, RfEmission* e )
{
    const RfPunctual* spot = rf_punctual_light( lights, e->light );
    if ( spot->profile != NULL )
        return emit_by_profile( spot, e );
    float falloff = rf_spot_falloff( spot, rf_dot( spot->direction, e->direction ) ), part = falloff * facing( spot, e );
    e->radiance = rf_scale( spot->intensity, part );
    e->pdf_solid_angle = (float)( (double)falloff / ( 2.0 * PI * spot_integral( spot ) ) );
    return part > 0.0f && set_throughput( e, 1.0 );
}

// In proportion to the falloff, whose integral is a cubic and then a line.
static bool spot_steer( const RfLights* lights, const float u[2], RfEmission* e )
{
    const RfPunctual* spot = rf_punctual_light( lights, e->light );
    if ( spot->profile != NULL )
        return steer_by_profile( spot, u, e );
    double blend = (double)rf_spot_blend( spot ), at = (double)u[0] * spot_integral( spot ), flat = at - blend / 3.0;
    double cosine = (double)spot->cos_outer + ( flat < 0.0 ? blend * cbrt( 3.0 * at / blend ) : blend + flat );
    e->direction = around( spot->direction, fmin( cosine, 1.0 ), u[1] );
    return spot_emit( lights, e );
}

static void spot_find_pdf( const RfLights* lights, RfEmission* e )
{
    const RfPunctual* spot = rf_punctual_light( lights, e->light );
    if ( spot->profile != NULL )
        e->pdf_solid_angle = profile_pdf( spot, e->direction );
    else
        e->pdf_solid_angle = (float)( (double)rf_spot_falloff( spot, rf_dot( spot->direction, e->direction ) ) /
                                      ( 2.0 * PI * spot_integral( spot ) ) );
}

// Planes: rectangles and ellipses. Each of their points is a light of its own.

static double plane_selection_power( const RfLights* lights, uint32_t light )
{
    return luminance_of( rf_punctual_light( lights, light ) );
}

static RfTreeLight plane_bound( const RfLights* lights, uint32_t light )
{
    const RfPunctual* plane = rf_punctual_light( lights, light );
    RfTreeLight out = empty( light );
    RfVec3 x = rf_scale( plane->across, plane->half[0] ), y = rf_scale( rf_plane_up( plane ), plane->half[1] );
    for ( int k = 0; k < 4; ++k )
    {
        RfVec3 side = rf_madd( plane->position, x, k & 1 ? 1.0f : -1.0f );
        extend_box( &out, lights, rf_madd( side, y, k & 2 ? 1.0f : -1.0f ) );
    }
    set_axis( &out, plane->direction );
    out.cos_spread = 1.0;
    if ( plane->tan_spread > 0.0f )
        out.cos_emission = 1.0 / sqrt( 1.0 + (double)plane->tan_spread * (double)plane->tan_spread );
    out.intensity = luminance_of( plane ) * (double)rf_spread_falloff( plane, 1.0f ) * per_ball( lights );
    return out;
}

static double plane_power( const RfLights* lights, uint32_t light )
{
    return PI * luminance_of( rf_punctual_light( lights, light ) );
}

static bool plane_sample_emitter( const RfLights* lights, const RfScene* scene, float side, const float u[2], RfEmission* e )
{
    (void)scene, (void)side;
    const RfPunctual* plane = rf_punctual_light( lights, e->light );
    float root = sqrtf( u[0] ), phi = 2.0f * RF_PI * u[1];
    float x = plane->ellipse ? root * cosf( phi ) : 2.0f * u[0] - 1.0f,
          y = plane->ellipse ? root * sinf( phi ) : 2.0f * u[1] - 1.0f;
    e->delta_position = true;
    e->position =
        rf_madd( rf_madd( plane->position, plane->across, x * plane->half[0] ), rf_plane_up( plane ), y * plane->half[1] );
    e->pdf_area = 1.0f;
    e->range = plane->range;
    return shines( plane->intensity );
}

static bool plane_emit( const RfLights* lights, RfEmission* e )
{
    const RfPunctual* plane = rf_punctual_light( lights, e->light );
    float cosine = rf_dot( plane->direction, e->direction ), part = cosine * rf_spread_falloff( plane, cosine );
    e->normal = e->direction;
    e->radiance = rf_scale( plane->intensity, part );
    e->pdf_solid_angle = cosine * RF_INV_PI;
    return part > 0.0f && set_throughput( e, 1.0 );
}

static bool plane_steer( const RfLights* lights, const float u[2], RfEmission* e )
{
    e->direction = around( rf_punctual_light( lights, e->light )->direction, sqrt( 1.0 - (double)u[0] ), u[1] );
    return plane_emit( lights, e );
}

static void plane_find_pdf( const RfLights* lights, RfEmission* e )
{
    e->pdf_solid_angle = rf_maxf( rf_dot( rf_punctual_light( lights, e->light )->direction, e->direction ), 0.0f ) * RF_INV_PI;
}

// Directional lights. Like those of the sky, their rays start on the disc that covers the scene's bounding ball.

static double disc_area( const RfLights* lights ) { return PI * (double)lights->radius * (double)lights->radius; }

// The disc lies a little before all that can be in the way.
static bool steer_on_disc( const RfLights* lights, const float u[2], RfEmission* e )
{
    RfVec3 t, b;
    rf_basis( e->direction, &t, &b );
    float r = lights->radius * sqrtf( u[0] ), phi = 2.0f * RF_PI * u[1];
    RfVec3 p = rf_madd( rf_madd( lights->center, t, r * cosf( phi ) ), b, r * sinf( phi ) );
    e->position = rf_madd( p, e->direction, -1.01f * lights->reach );
    e->pdf_area = (float)( 1.0 / disc_area( lights ) );
    return set_throughput( e, 1.0 );
}

static float disc_pdf( const RfLights* lights, RfVec3 position, RfVec3 direction )
{
    RfVec3 across = rf_cross( rf_sub( lights->center, position ), direction );
    return rf_dot( across, across ) <= lights->radius * lights->radius ? (float)( 1.0 / disc_area( lights ) ) : 0.0f;
}

static double directional_selection_power( const RfLights* lights, uint32_t light )
{
    return (double)lights->radius * (double)lights->radius * luminance_of( rf_punctual_light( lights, light ) );
}

static RfTreeLight directional_bound( const RfLights* lights, uint32_t light )
{
    const RfPunctual* sun = rf_punctual_light( lights, light );
    RfTreeLight out = empty( light );
    set_axis( &out, sun->direction );
    for ( int i = 0; i < 3; ++i )
        out.low[i] = out.high[i] = -DISTANT * out.axis[i];
    if ( sun->versine > 0.0f )
    {
        double cosine = 1.0 - (double)sun->versine, sine = sqrt( fmax( 1.0 - cosine * cosine, 0.0 ) );
        for ( int i = 0; i < 3; ++i )
        {
            double reach = DISTANT * sine / fmax( cosine, 1e-3 ) * sqrt( fmax( 1.0 - out.axis[i] * out.axis[i], 0.0 ) );
            out.low[i] -= reach;
            out.high[i] += reach;
        }
    }
    out.intensity = luminance_of( sun ) * DISTANT * DISTANT;
    return out;
}

static double directional_power( const RfLights* lights, uint32_t light )
{
    return disc_area( lights ) * luminance_of( rf_punctual_light( lights, light ) );
}

static bool directional_sample_emitter( const RfLights* lights, const RfScene* scene, float side, const float u[2],
                                        RfEmission* e )
{
    (void)scene, (void)side;
    const RfPunctual* sun = rf_punctual_light( lights, e->light );
    e->infinite = true;
    e->delta_direction = true;
    e->pdf_solid_angle = 1.0f;
    e->direction = e->normal = sun->direction;
    e->radiance = sun->intensity;
    if ( sun->versine > 0.0f )
    {
        RfExtentSample s = rf_sample_sun( sun, u );
        e->direction = e->normal = rf_scale( s.wi, -1.0f );
        e->radiance = rf_scale( sun->intensity, s.weight );
    }
    return shines( e->radiance );
}

static bool directional_steer( const RfLights* lights, const float u[2], RfEmission* e ) { return steer_on_disc( lights, u, e ); }

#define directional_emit NULL

static void directional_find_pdf( const RfLights* lights, RfEmission* e )
{
    e->pdf_area = disc_pdf( lights, e->position, e->direction );
}

// The sky.

static double sky_selection_power( const RfLights* lights, uint32_t light )
{
    (void)light;
    double radius = (double)lights->radius;
    return 4.0 * PI * radius * radius * (double)lights->sky.mean_luminance;
}

#define sky_bound NULL

static double sky_power( const RfLights* lights, uint32_t light )
{
    (void)light;
    return 4.0 * PI * (double)lights->sky.mean_luminance * disc_area( lights );
}

// By two numbers: within a pixel of the map by a hash of them.
static bool sky_sample_emitter( const RfLights* lights, const RfScene* scene, float side, const float u[2], RfEmission* e )
{
    (void)scene, (void)side;
    const RfSky* sky = &lights->sky;
    uint32_t bits[2] = { (uint32_t)( (double)u[0] * 0x1p32 ), (uint32_t)( (double)u[1] * 0x1p32 ) };
    RfRandomKey key = { bits[0], bits[1] };
    float within[2] = { rf_random( key, 0 ), rf_random( key, 1 ) };
    RfSkySample s = rf_sample_sky( sky, bits, sky->environment->map != NULL ? within : u );
    e->infinite = true;
    e->direction = e->normal = rf_scale( s.wi, -1.0f );
    e->radiance = s.radiance;
    e->pdf_solid_angle = s.pdf_solid_angle;
    return shines( e->radiance );
}

static bool sky_steer( const RfLights* lights, const float u[2], RfEmission* e ) { return steer_on_disc( lights, u, e ); }

#define sky_emit NULL

static void sky_find_pdf( const RfLights* lights, RfEmission* e )
{
    e->pdf_solid_angle = rf_sky_pdf_solid_angle( &lights->sky, rf_scale( e->direction, -1.0f ) );
    e->pdf_area = disc_pdf( lights, e->position, e->direction );
}

#define ROW( NAME, name, needs_light_paths )                                                                                     \
    [RF_LIGHT_##NAME] = { name##_selection_power, name##_bound, name##_power,   name##_sample_emitter,                           \
                          name##_steer,           name##_emit,  name##_find_pdf },

const RfLightModel g_rf_light_models[] = { RF_LIGHT_KINDS( ROW ) };
