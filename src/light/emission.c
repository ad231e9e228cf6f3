// Samples position and direction of light that leaves an emitter, with both densities.
#include "light/emission.h"

#include "light/kinds.h"

static uint32_t bits_of( float u ) { return (uint32_t)( (double)u * 0x1p32 ); }

bool rf_sample_emitter_of( const RfLights* lights, const RfScene* scene, uint32_t light, float pdf_light, float side,
                           const float u[2], RfEmission* e )
{
    *e = ( RfEmission ){ .range = INFINITY, .light = light, .pdf_light = pdf_light };
    return rf_light_model( lights, light )->sample_emitter( lights, scene, side, u, e );
}

bool rf_sample_emitter( const RfLights* lights, const RfScene* scene, const float u[4], RfEmission* e )
{
    uint32_t light = rf_select_light_by_power( lights, bits_of( u[0] ), bits_of( u[1] ) );
    float column = u[0] * (float)lights->count;
    return rf_sample_emitter_of( lights, scene, light, lights->power_fraction[light], column - floorf( column ), u + 2, e );
}

bool rf_emit_towards( const RfLights* lights, RfVec3 direction, RfEmission* e )
{
    e->direction = direction;
    return rf_light_model( lights, e->light )->emit( lights, e );
}

bool rf_sample_emission( const RfLights* lights, const RfScene* scene, const float u[6], RfEmission* e )
{
    return rf_sample_emitter( lights, scene, u, e ) && rf_light_model( lights, e->light )->steer( lights, u + 4, e );
}

void rf_find_emission_pdf( const RfLights* lights, RfEmission* e )
{
    e->pdf_light = lights->power_fraction[e->light];
    e->pdf_area = e->pdf_solid_angle = 1.0f;
    rf_light_model( lights, e->light )->find_pdf( lights, e );
}

double rf_light_power( const RfLights* lights, uint32_t light )
{
    return rf_light_model( lights, light )->power( lights, light );
}
