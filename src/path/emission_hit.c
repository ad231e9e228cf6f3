// Light at the ends of scattered rays, which light samples at their origins
// could have found as well (estimators.md E3).
#include "path/wavefront.h"

static inline void add_arrival( const RfPathSettings* settings, const RfRayLanes* rays, int r, bool apart, RfVec3 light,
                                float light_pdf, RfArrivals* arrivals )
{
    int slot = rays->slot[r];
    float l[3] = { light.x, light.y, light.z };
    if ( apart )
    {
        for ( int c = 0; c < 3; ++c )
            arrivals->emitted[c][slot] = rays->throughput[c][r] * l[c];
        arrivals->light_pdf_solid_angle[slot] = light_pdf;
        return;
    }
    float pdf = rays->pdf_solid_angle[r];
    float weight = pdf / ( pdf + (float)settings->light_samples * light_pdf );
    for ( int c = 0; c < 3; ++c )
        arrivals->rest[c][slot] += rays->throughput[c][r] * l[c] * weight;
}

// With which chance a light sample at the ray's origin picks this light.
static float chance_at_origin( const RfPathSettings* settings, const RfRayLanes* rays, int r, uint32_t light )
{
    RfVec3 o = rf_vec3( rays->o[0][r], rays->o[1][r], rays->o[2][r] );
    RfVec3 n = rf_vec3( rays->n[0][r], rays->n[1][r], rays->n[2][r] );
    return rf_light_probability( rf_tracer_lights( settings->tracer ), settings->light_sampling, light, o, n );
}

static void add_emission( const RfPathSettings* settings, const RfRayLanes* rays, const RfVertexLanes* v,
                          const uint32_t* triangle, bool apart, RfArrivals* arrivals )
{
    const RfTriangleRecord* triangles = rf_tracer_triangles( settings->tracer );
    for ( int i = 0; i < v->count; ++i )
    {
        if ( v->light_pdf_solid_angle[i] == 0.0f )
            continue;
        int r = v->ray[i];
        RfVec3 emission = rf_vec3( v->emission[0][i], v->emission[1][i], v->emission[2][i] );
        float chance = chance_at_origin( settings, rays, r, triangles[triangle[r]].light );
        add_arrival( settings, rays, r, apart, emission, v->light_pdf_solid_angle[i] * chance, arrivals );
    }
}

static void add_sky( const RfPathSettings* settings, const RfRayLanes* rays, const uint32_t* triangle, bool apart,
                     RfArrivals* arrivals )
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
            rf_sky_pdf_solid_angle( &lights->sky, d ) * chance_at_origin( settings, rays, r, rf_sky_number( lights ) );
        add_arrival( settings, rays, r, apart, sky, light_pdf, arrivals );
    }
}

void rf_add_emission_hits( const RfPathSettings* settings, const RfRayLanes* rays, const RfVertexLanes* vertices,
                           const uint32_t* triangle, bool apart, RfArrivals* arrivals )
{
    add_emission( settings, rays, vertices, triangle, apart, arrivals );
    add_sky( settings, rays, triangle, apart, arrivals );
}
