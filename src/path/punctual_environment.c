#include "path/punctual_environment.h"

static float cone( const RfPunctual* p, RfVec3 wi )
{
    if ( p->kind != RF_PUNCTUAL_SPOT )
        return 1.0f;
    float cos_axis = -rf_dot( p->direction, wi );
    float t = ( cos_axis - p->cos_outer ) / rf_maxf( p->cos_inner - p->cos_outer, 1e-4f );
    t = rf_clampf( t, 0.0f, 1.0f );
    return t * t;
}

// The range of KHR_lights_punctual, as its text recommends.
static float window( float distance2, float range )
{
    float ratio2 = distance2 / ( range * range );
    return rf_clampf( 1.0f - ratio2 * ratio2, 0.0f, 1.0f );
}

static RfPunctualEnvironmentSample sample_punctual( const RfLights* lights, const RfPunctual* p, float pick, RfVec3 from )
{
    RfPunctualEnvironmentSample sample = { .pdf_solid_angle = pick * RF_DELTA_PDF };
    if ( p->kind == RF_PUNCTUAL_DIRECTIONAL )
    {
        sample.wi = rf_scale( p->direction, -1.0f );
        sample.distance = 2.0f * ( rf_length( rf_sub( from, lights->center ) ) + lights->radius );
        sample.radiance = rf_scale( p->intensity, RF_DELTA_PDF );
        return sample;
    }
    RfVec3 way = rf_sub( p->position, from );
    float d2 = rf_dot( way, way );
    sample.distance = sqrtf( d2 );
    if ( !( d2 > 0.0f ) )
    {
        sample.pdf_solid_angle = 0.0f;
        return sample;
    }
    sample.wi = rf_scale( way, 1.0f / sample.distance );
    // next to the light itself: no more than a hundred-thousandth of the scene away from it
    float least = 1e-5f * lights->radius;
    d2 = rf_maxf( d2, least * least );
    sample.radiance = rf_scale( p->intensity, cone( p, sample.wi ) * window( d2, p->range ) / d2 * RF_DELTA_PDF );
    return sample;
}

static RfPunctualEnvironmentSample sample_sky( const RfLights* lights, RfRandomKey key, uint32_t dimension, const float place[2],
                                               float pick, RfVec3 from )
{
    uint32_t bits[2] = { rf_random_bits( key, ( dimension + 1 ) | RF_DIMENSION_TWIN ),
                         rf_random_bits( key, ( dimension + 2 ) | RF_DIMENSION_TWIN ) };
    RfSkySample sky = rf_sample_sky( &lights->sky, bits, place );
    return ( RfPunctualEnvironmentSample ){
        .wi = sky.wi,
        .radiance = sky.radiance,
        .pdf_solid_angle = sky.pdf_solid_angle * pick,
        .distance = 2.0f * ( rf_length( rf_sub( from, lights->center ) ) + lights->radius ),
    };
}

RfPunctualEnvironmentSample rf_sample_punctual_environment( const RfLights* lights, RfLightSelection pick, RfRandomKey key,
                                                            uint32_t dimension, const float place[2], RfVec3 from )
{
    int number = (int)( pick.light - lights->triangle_count );
    return number < lights->punctual_count ? sample_punctual( lights, lights->punctual + number, pick.chance, from )
                                           : sample_sky( lights, key, dimension, place, pick.chance, from );
}
