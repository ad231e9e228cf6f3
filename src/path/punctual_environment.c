#include "path/punctual_environment.h"

#include "base/fault.h"
#include "light/punctual.h"

// Radiance and density in the right ratio, the radiance as large as may be: the density remains far above those
// of scattering models, which it competes with in MIS.
static void set_bright( const RfPunctual* p, double scale, float probability, RfPunctualEnvironmentSample* sample )
{
    double most = (double)rf_max_component( p->intensity ), delta = (double)RF_MAX_PUNCTUAL_RADIANCE / ( most * scale );
    if ( !( most * scale > 0.0 ) )
        return;
    sample->radiance = rf_scale( p->intensity, (float)( (double)RF_MAX_PUNCTUAL_RADIANCE / most ) );
    sample->pdf_solid_angle = probability * (float)delta;
}

static RfPunctualEnvironmentSample sample_punctual( const RfLights* lights, const RfPunctual* p, float probability, RfVec3 from )
{
    RfPunctualEnvironmentSample sample = { .pdf_solid_angle = probability * RF_DELTA_PDF };
    if ( p->kind == RF_PUNCTUAL_DIRECTIONAL )
    {
        sample.wi = rf_scale( p->direction, -1.0f );
        sample.distance = 2.0f * ( rf_length( rf_sub( from, lights->center ) ) + lights->radius );
        sample.radiance = rf_scale( p->intensity, RF_DELTA_PDF );
        return sample;
    }
    RfVec3 to_light = rf_sub( p->position, from );
    float d2 = rf_dot( to_light, to_light );
    sample.distance = sqrtf( d2 );
    if ( !( d2 > 0.0f ) )
    {
        sample.pdf_solid_angle = 0.0f;
        return sample;
    }
    sample.wi = rf_scale( to_light, 1.0f / sample.distance );
    // bounds the radiance next to the light
    float least = 1e-5f * lights->radius;
    d2 = rf_maxf( d2, least * least );
    float falloff = rf_spot_falloff( p, -rf_dot( p->direction, sample.wi ) ) * rf_range_falloff( d2, p->range ),
          scale = falloff / d2 * RF_DELTA_PDF;
    if ( rf_max_component( p->intensity ) * scale < RF_MAX_PUNCTUAL_RADIANCE || RF_FAULT( lamp_bright ) ||
         RF_FAULT( lamp_infinite ) )
        sample.radiance = rf_scale( p->intensity, scale );
    else
        set_bright( p, falloff / (double)d2, probability, &sample );
    return sample;
}

static RfPunctualEnvironmentSample sample_sky( const RfLights* lights, RfRandomKey key, uint32_t dimension, const float u[2],
                                               float probability, RfVec3 from )
{
    uint32_t own = dimension & ~RF_DIMENSION_OPPOSITE, half = own == dimension ? 0 : 0x80000000u;
    uint32_t bits[2] = { rf_random_bits( key, ( own + 1 ) | RF_DIMENSION_TWIN ) ^ half,
                         rf_random_bits( key, ( own + 2 ) | RF_DIMENSION_TWIN ) ^ half };
    RfSkySample sky = rf_sample_sky_direction( &lights->sky, bits, u );
    return ( RfPunctualEnvironmentSample ){
        .wi = sky.wi,
        .radiance = rf_vec3( 1.0f, 1.0f, 1.0f ),
        .pdf_solid_angle = sky.pdf_solid_angle * probability,
        .distance = 2.0f * ( rf_length( rf_sub( from, lights->center ) ) + lights->radius ),
        .sky = true,
    };
}

RfPunctualEnvironmentSample rf_sample_punctual_environment( const RfLights* lights, RfLightSelection selection, RfRandomKey key,
                                                            uint32_t dimension, const float u[2], RfVec3 from )
{
    int number = (int)( selection.light - lights->triangle_count );
    return rf_calls_for( number < lights->punctual_count, RF_EFFECT_PUNCTUAL_LIGHTS )
               ? sample_punctual( lights, lights->punctual + number, selection.probability, from )
               : sample_sky( lights, key, dimension, u, selection.probability, from );
}
