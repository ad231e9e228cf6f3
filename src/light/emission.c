#include "light/emission.h"
#include "base/random.h"

#define PI 3.14159265358979324

static uint32_t bits_of( float u ) { return (uint32_t)( (double)u * 0x1p32 ); }

static bool is_two_sided( const RfLight* light ) { return rf_calls_for( light->two_sided, RF_EFFECT_TWO_SIDED_EMISSION ); }

// The punctual light of this number, or NULL.
static const RfPunctual* punctual_of( const RfLights* lights, uint32_t light )
{
    if ( light < lights->triangle_count )
        return NULL;
    int number = (int)( light - lights->triangle_count );
    return rf_calls_for( number < lights->punctual_count, RF_EFFECT_PUNCTUAL_LIGHTS ) ? lights->punctual + number : NULL;
}

// The integral of a spot's falloff over the cosines to its axis: solid angle over 2π.
static double spot_integral( const RfPunctual* spot )
{
    double outer = (double)spot->cos_outer, blend = (double)rf_spot_blend( spot ), most = fmin( 1.0, ( 1.0 - outer ) / blend );
    return blend * most * most * most / 3.0 + fmax( 1.0 - outer - blend, 0.0 );
}

static double disc_area( const RfLights* lights ) { return PI * (double)lights->radius * (double)lights->radius; }

// The direction of this cosine to a unit axis.
static RfVec3 around( RfVec3 axis, double cosine, float turn )
{
    RfVec3 t, b;
    rf_basis( axis, &t, &b );
    double sine = sqrt( fmax( ( 1.0 - cosine ) * ( 1.0 + cosine ), 0.0 ) ), phi = 2.0 * PI * (double)turn;
    RfVec3 across = rf_add( rf_scale( t, (float)( sine * cos( phi ) ) ), rf_scale( b, (float)( sine * sin( phi ) ) ) );
    return rf_normalize( rf_madd( across, axis, (float)cosine ) );
}

// In proportion to the falloff, whose integral is a cubic and then a line.
static RfVec3 sample_spot( const RfPunctual* spot, const float u[2] )
{
    double blend = (double)rf_spot_blend( spot ), at = (double)u[0] * spot_integral( spot ), flat = at - blend / 3.0;
    double cosine = (double)spot->cos_outer + ( flat < 0.0 ? blend * cbrt( 3.0 * at / blend ) : blend + flat );
    return around( spot->direction, fmin( cosine, 1.0 ), u[1] );
}

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

// `side`: a number of its own in [0, 1).
static bool sample_triangle( const RfLights* lights, const RfScene* scene, float side, const float u[2], RfEmission* e )
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

// The environment by two numbers: within a pixel of its map by a hash of them.
static bool sample_environment( const RfSky* sky, const float u[2], RfEmission* e )
{
    uint32_t bits[2] = { bits_of( u[0] ), bits_of( u[1] ) };
    RfRandomKey key = { bits[0], bits[1] };
    float within[2] = { rf_random( key, 0 ), rf_random( key, 1 ) };
    RfSkySample s = rf_sample_sky( sky, bits, sky->environment->map != NULL ? within : u );
    e->direction = rf_scale( s.wi, -1.0f );
    e->radiance = s.radiance;
    e->pdf_solid_angle = s.pdf_solid_angle;
    return shines( e->radiance );
}

static bool sample_infinite( const RfLights* lights, const RfPunctual* sun, const float u[2], RfEmission* e )
{
    e->infinite = true;
    if ( sun == NULL )
    {
        bool emits = sample_environment( &lights->sky, u, e );
        e->normal = e->direction;
        return emits;
    }
    e->delta_direction = true;
    e->pdf_solid_angle = 1.0f;
    e->direction = e->normal = sun->direction;
    e->radiance = sun->intensity;
    return shines( e->radiance );
}

bool rf_sample_emitter_of( const RfLights* lights, const RfScene* scene, uint32_t light, float pdf_light, float side,
                           const float u[2], RfEmission* e )
{
    *e = ( RfEmission ){ .range = INFINITY, .light = light, .pdf_light = pdf_light };
    const RfPunctual* lamp = punctual_of( lights, e->light );
    if ( e->light < lights->triangle_count )
        return sample_triangle( lights, scene, side, u, e );
    if ( lamp == NULL || lamp->kind == RF_PUNCTUAL_DIRECTIONAL )
        return sample_infinite( lights, lamp, u, e );
    e->delta_position = true;
    e->position = lamp->position;
    e->pdf_area = 1.0f;
    e->range = lamp->range;
    return shines( lamp->intensity );
}

bool rf_sample_emitter( const RfLights* lights, const RfScene* scene, const float u[4], RfEmission* e )
{
    uint32_t light = rf_select_light_by_power( lights, bits_of( u[0] ), bits_of( u[1] ) );
    float column = u[0] * (float)lights->count;
    return rf_sample_emitter_of( lights, scene, light, lights->power_fraction[light], column - floorf( column ), u + 2, e );
}

bool rf_emit_towards( const RfLights* lights, const RfScene* scene, RfVec3 direction, RfEmission* e )
{
    (void)scene; // the radiance of a point of a triangle is the same in all directions
    e->direction = direction;
    const RfPunctual* lamp = punctual_of( lights, e->light );
    if ( lamp == NULL )
    {
        float cosine = rf_dot( e->normal, direction );
        e->pdf_solid_angle = cosine * RF_INV_PI;
        return cosine > 0.0f && set_throughput( e, (double)cosine );
    }
    e->normal = direction;
    if ( lamp->kind == RF_PUNCTUAL_POINT )
    {
        e->radiance = lamp->intensity;
        e->pdf_solid_angle = 0.25f * RF_INV_PI;
        return set_throughput( e, 1.0 );
    }
    float falloff = rf_spot_falloff( lamp, rf_dot( lamp->direction, direction ) );
    e->radiance = rf_scale( lamp->intensity, falloff );
    e->pdf_solid_angle = (float)( (double)falloff / ( 2.0 * PI * spot_integral( lamp ) ) );
    return falloff > 0.0f && set_throughput( e, 1.0 );
}

static RfVec3 sample_direction( const RfLights* lights, const RfEmission* e, const float u[2] )
{
    const RfPunctual* lamp = punctual_of( lights, e->light );
    if ( lamp == NULL )
        return around( e->normal, sqrt( 1.0 - (double)u[0] ), u[1] );
    if ( lamp->kind == RF_PUNCTUAL_SPOT )
        return sample_spot( lamp, u );
    return around( rf_vec3( 0, 0, 1 ), 1.0 - 2.0 * (double)u[0], u[1] );
}

// Where on the disc a ray from infinity starts. The disc lies a little before the ball around the scene.
static void sample_disc( const RfLights* lights, const float u[2], RfEmission* e )
{
    RfVec3 t, b;
    rf_basis( e->direction, &t, &b );
    float r = lights->radius * sqrtf( u[0] ), phi = 2.0f * RF_PI * u[1];
    RfVec3 p = rf_madd( rf_madd( lights->center, t, r * cosf( phi ) ), b, r * sinf( phi ) );
    e->position = rf_madd( p, e->direction, -1.01f * lights->radius );
    e->pdf_area = (float)( 1.0 / disc_area( lights ) );
}

bool rf_sample_emission( const RfLights* lights, const RfScene* scene, const float u[6], RfEmission* e )
{
    if ( !rf_sample_emitter( lights, scene, u, e ) )
        return false;
    if ( !e->infinite )
        return rf_emit_towards( lights, scene, sample_direction( lights, e, u + 4 ), e );
    sample_disc( lights, u + 4, e );
    return set_throughput( e, 1.0 );
}

// Of a triangle: one side emits unless both do.
static void find_triangle_pdf( const RfLight* light, RfEmission* e )
{
    float cosine = rf_dot( light->normal, e->direction );
    if ( is_two_sided( light ) )
    {
        cosine = fabsf( cosine );
        e->pdf_light *= 0.5f;
    }
    e->pdf_area = light->pdf_area;
    e->pdf_solid_angle = rf_maxf( cosine, 0.0f ) * RF_INV_PI;
}

static bool passes_ball( const RfLights* lights, RfVec3 position, RfVec3 direction )
{
    RfVec3 across = rf_cross( rf_sub( lights->center, position ), direction );
    return rf_dot( across, across ) <= lights->radius * lights->radius;
}

void rf_find_emission_pdf( const RfLights* lights, RfEmission* e )
{
    const RfPunctual* lamp = punctual_of( lights, e->light );
    e->pdf_light = lights->power_fraction[e->light];
    e->pdf_area = e->pdf_solid_angle = 1.0f;
    if ( e->light < lights->triangle_count )
        find_triangle_pdf( lights->light + e->light, e );
    else if ( lamp != NULL && lamp->kind == RF_PUNCTUAL_POINT )
        e->pdf_solid_angle = 0.25f * RF_INV_PI;
    else if ( lamp != NULL && lamp->kind == RF_PUNCTUAL_SPOT )
        e->pdf_solid_angle = (float)( (double)rf_spot_falloff( lamp, rf_dot( lamp->direction, e->direction ) ) /
                                      ( 2.0 * PI * spot_integral( lamp ) ) );
    else
    {
        if ( lamp == NULL )
            e->pdf_solid_angle = rf_sky_pdf_solid_angle( &lights->sky, rf_scale( e->direction, -1.0f ) );
        e->pdf_area = passes_ball( lights, e->position, e->direction ) ? (float)( 1.0 / disc_area( lights ) ) : 0.0f;
    }
}

static double lamp_power( const RfLights* lights, const RfPunctual* lamp )
{
    double luminance = (double)rf_luminance( lamp->intensity );
    switch ( lamp->kind )
    {
        case RF_PUNCTUAL_POINT: return 4.0 * PI * luminance;
        case RF_PUNCTUAL_SPOT: return 2.0 * PI * spot_integral( lamp ) * luminance;
        case RF_PUNCTUAL_DIRECTIONAL: return disc_area( lights ) * luminance;
    }
    return 0.0;
}

double rf_light_power( const RfLights* lights, uint32_t number )
{
    const RfPunctual* lamp = punctual_of( lights, number );
    if ( lamp != NULL )
        return lamp_power( lights, lamp );
    if ( number >= lights->triangle_count )
        return 4.0 * PI * (double)lights->sky.mean_luminance * disc_area( lights );
    const RfLight* light = lights->light + number;
    return PI * (double)rf_luminance( light->radiance ) * (double)light->area * ( is_two_sided( light ) ? 2.0 : 1.0 );
}

double rf_total_light_power( const RfLights* lights )
{
    double sum = 0.0;
    for ( uint32_t i = 0; i < lights->count; ++i )
        sum += rf_light_power( lights, i );
    return sum;
}
