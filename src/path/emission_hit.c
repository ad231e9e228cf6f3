// Emission hit by BSDF sampling: light sampling at the ray's origin could have
// found it as well (src/reuse/estimators.md, E3).
#include "base/fault.h"
#include "path/wavefront.h"

// Where emission goes.
typedef struct Receiver
{
    bool defer_mis;
    RfChainLight* chain_light;
    RfArrivals* arrivals;
} Receiver;

static inline void add_arrival( const RfPathSettings* settings, const RfRayLanes* rays, int r, RfVec3 light, float light_pdf,
                                const Receiver* to )
{
    RfArrivals* arrivals = to->arrivals;
    int slot = rays->slot[r];
    float l[3] = { light.x * rays->throughput[0][r], light.y * rays->throughput[1][r], light.z * rays->throughput[2][r] };
    if ( to->chain_light != NULL && rf_take_chain_light( to->chain_light, slot, l ) )
        return;
    rf_close_chain( to->chain_light, slot, l );
    if ( to->defer_mis )
    {
        for ( int c = 0; c < 3; ++c )
            arrivals->emitted[c][slot] = l[c];
        arrivals->light_pdf_solid_angle[slot] = light_pdf;
        return;
    }
    float pdf = rays->pdf_solid_angle[r];
    float weight = pdf / ( pdf + (float)settings->light_samples * light_pdf );
    for ( int c = 0; c < 3; ++c )
        arrivals->rest[c][slot] += l[c] * weight;
}

// The probability that a light sample at the ray's origin selects this light.
static float selection_probability( const RfPathSettings* settings, const RfRayLanes* rays, int r, uint32_t light )
{
    RfVec3 o = rf_vec3( rays->o[0][r], rays->o[1][r], rays->o[2][r] );
    RfVec3 n = rf_vec3( rays->n[0][r], rays->n[1][r], rays->n[2][r] );
    return rf_light_probability( rf_tracer_lights( settings->tracer ), settings->light_sampling, light, o, n );
}

// Behind panes the ray's density is q times as large. Only the quotient of the two
// densities matters.
static inline float light_pdf_behind( const float* pane_probability, int r, float light_pdf )
{
    return pane_probability != NULL ? light_pdf / pane_probability[r] : light_pdf;
}

static void add_emission( const RfPathSettings* settings, const RfRayLanes* rays, const RfVertexLanes* v,
                          const uint32_t* triangle, const float* pane_probability, const Receiver* to )
{
    const RfTriangleRecord* triangles = rf_tracer_triangles( settings->tracer );
    for ( int i = 0; i < v->count; ++i )
    {
        if ( v->light_pdf_solid_angle[i] == 0.0f )
            continue;
        int r = v->ray[i];
        RfVec3 emission = rf_vec3( v->emission[0][i], v->emission[1][i], v->emission[2][i] );
        uint32_t light = triangles[triangle[r]].light;
        float probability = RF_FAULT( selection ) ? 1.0f : selection_probability( settings, rays, r, light );
        float light_pdf = light_pdf_behind( pane_probability, r, v->light_pdf_solid_angle[i] * probability );
        add_arrival( settings, rays, r, emission, light_pdf, to );
    }
}

static void add_sky( const RfPathSettings* settings, const RfRayLanes* rays, const uint32_t* triangle,
                     const float* pane_probability, const Receiver* to )
{
    const RfLights* lights = rf_tracer_lights( settings->tracer );
    if ( !rf_has_sky( lights ) )
        return;
    for ( int r = 0; r < rays->count; ++r )
    {
        if ( triangle[r] != RF_MISS )
            continue;
        RfVec3 d = rf_vec3( rays->d[0][r], rays->d[1][r], rays->d[2][r] );
        RfVec3 sky = rf_sky_radiance( &lights->sky, d );
        float light_pdf =
            rf_sky_pdf_solid_angle( &lights->sky, d ) * selection_probability( settings, rays, r, rf_sky_number( lights ) );
        add_arrival( settings, rays, r, sky, light_pdf_behind( pane_probability, r, light_pdf ), to );
    }
}

void rf_add_emission_hits( const RfPathSettings* settings, const RfRayLanes* rays, const RfVertexLanes* vertices,
                           const uint32_t* triangle, const float* pane_probability, bool defer_mis, RfChainLight* chain_light,
                           RfArrivals* arrivals )
{
    Receiver to = { defer_mis, chain_light, arrivals };
    add_emission( settings, rays, vertices, triangle, pane_probability, &to );
    add_sky( settings, rays, triangle, pane_probability, &to );
}
