// Samples the places of light that leaves emitters, and its radiance towards others.
#include "light/emission.h"

#include "light/kinds.h"

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
