// The kinds of a light, one after the other, and the table of them; the places of light that leaves emitters, and its radiance
// towards others.
#include "light/emission.h"

#include "base/random.h"
#include "light/extent.h"

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

static bool triangle_sample_emitter( const RfLights* lights, const RfScene* scene, float side, const float u[2], RfEmission* e )
{
    const RfLight* light = lights->light + e->light;
    float root = sqrtf( u[0] ), b1 = 1.0f - root, b2 = u[1] * root;
    e->position = rf_add( light->p0, rf_add( rf_scale( light->e1, b1 ), rf_scale( light->e2, b2 ) ) );
    e->normal = light->normal;
    if ( rf_emits_from_both_sides( light ) )
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
    return rf_dot( e->normal, e->direction ) > 0.0f;
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

// False: nothing is emitted towards e->direction, where a falloff is `part`.
static bool emit_from( const RfPunctual* lamp, float part, RfEmission* e )
{
    e->radiance = rf_scale( lamp->intensity, part );
    return part > 0.0f && shines( e->radiance );
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

static bool point_emit( const RfLights* lights, RfEmission* e )
{
    const RfPunctual* lamp = rf_punctual_light( lights, e->light );
    return emit_from( lamp, rf_lamp_falloff( lamp, e->direction ) * facing( lamp, e ), e );
}

// Spot lights: point lights with a cone.

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

#define spot_sample_emitter point_sample_emitter
#define spot_emit point_emit

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
    for ( int k = -1; k <= 1; k += 2 ) // over all four corners, gcc 12 for ARM64 crashes
    {
        RfVec3 side = rf_madd( plane->position, x, (float)k );
        extend_box( &out, lights, rf_madd( side, y, 1.0f ) );
        extend_box( &out, lights, rf_madd( side, y, -1.0f ) );
    }
    set_axis( &out, plane->direction );
    out.cos_spread = 1.0;
    if ( plane->tan_spread > 0.0f )
        out.cos_emission = 1.0 / sqrt( 1.0 + (double)plane->tan_spread * (double)plane->tan_spread );
    out.intensity = luminance_of( plane ) * (double)rf_spread_falloff( plane, 1.0f ) * per_ball( lights );
    return out;
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
    float cosine = rf_dot( plane->direction, e->direction );
    e->normal = e->direction;
    return emit_from( plane, cosine * rf_spread_falloff( plane, cosine ), e );
}

// Directional lights.

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

#define directional_emit NULL

// The sky.

static double sky_selection_power( const RfLights* lights, uint32_t light )
{
    (void)light;
    double radius = (double)lights->radius;
    return 4.0 * PI * radius * radius * (double)lights->sky.mean_luminance;
}

#define sky_bound NULL

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

#define sky_emit NULL

#define ROW( NAME, name, needs_light_paths )                                                                                     \
    [RF_LIGHT_##NAME] = { name##_selection_power, name##_bound, name##_sample_emitter, name##_emit },

const RfLightModel g_rf_light_models[] = { RF_LIGHT_KINDS( ROW ) };

bool rf_sample_emitter( const RfLights* lights, const RfScene* scene, uint32_t light, float pdf_light, float side,
                        const float u[2], RfEmission* e )
{
    *e = ( RfEmission ){ .range = INFINITY, .light = light, .pdf_light = pdf_light };
    return rf_light_model( lights, light )->sample_emitter( lights, scene, side, u, e );
}

bool rf_emit_towards( const RfLights* lights, RfVec3 direction, RfEmission* e )
{
    e->direction = direction;
    return rf_light_model( lights, e->light )->emit( lights, e );
}

void rf_find_emission_pdf( const RfLights* lights, RfEmission* e )
{
    const RfLight* light = lights->light + e->light;
    e->pdf_light = lights->power_fraction[e->light] * ( rf_emits_from_both_sides( light ) ? 0.5f : 1.0f );
    e->pdf_area = light->pdf_area;
}
