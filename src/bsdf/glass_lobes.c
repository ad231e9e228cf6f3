// What single lobes of mirrors and glass are: panes, and delta lobes that are asked for by name.
#include "bsdf/glass.h"

// Rays below the horizon that eyes are lifted to do not go straight, so the wall is no pane for them.
static RfPane pane( const Glass* g, float cos_o )
{
    if ( !g->thin || g->alpha > 0.0f || cos_o < RF_MIN_COS || !( rf_max_component( g->tint ) > 0.0f ) )
        return ( RfPane ){ 0.0f, { 0, 0, 0 } };
    float base = base_probability( g, cos_o ), reflect = reflection_probability( g, reflectance( g, cos_o ) );
    float rest = 1.0f - dielectric( cos_o, g->ior );
    // below 1, so that it tells whether there was a pane
    float probability = rf_minf( ( 1.0f - base ) * ( 1.0f - reflect ), 1.0f - 0x1p-24f );
    return ( RfPane ){ probability, rf_scale( g->tint, rest ) };
}

RfPane rf_pane_of_material( const RfMaterial* m, float cos_o )
{
    Glass g = {
        .base = m->diffuse,
        .specular = m->specular,
        .tint = m->tint,
        .alpha = m->alpha,
        .ior = m->ior,
        .metal = m->f90,
        .base_share = m->coat_f0,
        .bare = m->coat_f90,
        .thin = m->thin && m->ior > 0.0f,
    };
    return pane( &g, cos_o );
}

RfPane rf_pane_of_lane( const RfBsdfLanes* lanes, int lane, RfVec3 wo )
{
    Glass g = glass_of( lanes, lane );
    return pane( &g, rf_dot( g.n, wo ) );
}

RfDeltaEvent rf_glass_event( const RfBsdfLanes* lanes, int lane, RfVec3 wo, bool transmits )
{
    Glass g = glass_of( lanes, lane );
    RfEyeLane eye = rf_lift_to_horizon( g.n, wo );
    float base = base_probability( &g, eye.cos_o );
    RfVec3 f = reflectance( &g, rf_dot( eye.wo, g.n ) );
    float reflect = reflection_probability( &g, f );
    float probability = ( 1.0f - base ) * ( transmits ? 1.0f - reflect : reflect );
    if ( g.alpha > 0.0f || !( probability > 0.0f ) )
        return ( RfDeltaEvent ){ wo, { 0, 0, 0 }, 0.0f };
    if ( !transmits )
        return ( RfDeltaEvent ){ mirrored( eye.wo, g.n ), rf_scale( f, 1.0f / probability ), probability };
    GlassSample s = sample_transmission( &g, eye, g.n, probability );
    return ( RfDeltaEvent ){ s.wi, s.weight, probability };
}

float rf_glass_reflection( const RfMaterial* material, float cos_o, RfVec3* weight )
{
    Glass g = { .base = material->diffuse,
                .specular = material->specular,
                .tint = material->tint,
                .ior = material->ior,
                .metal = material->f90,
                .base_share = material->coat_f0,
                .bare = material->coat_f90,
                .thin = material->thin };
    float base = base_probability( &g, cos_o );
    RfVec3 f = reflectance( &g, cos_o );
    float probability = ( 1.0f - base ) * reflection_probability( &g, f );
    *weight = probability > 0.0f ? rf_scale( f, 1.0f / probability ) : rf_vec3( 0, 0, 0 );
    return probability;
}

void rf_glass_delta_lobes( const RfMaterial* m, float ior, float cos_o, RfVec3* reflected, RfVec3* transmitted )
{
    Glass g = { .base = m->diffuse,
                .specular = m->specular,
                .tint = m->tint,
                .ior = ior,
                .metal = m->f90,
                .base_share = m->coat_f0,
                .bare = m->coat_f90 };
    *reflected = reflectance( &g, cos_o );
    *transmitted = ior > 0.0f ? rf_scale( m->tint, 1.0f - dielectric( cos_o, ior ) ) : rf_vec3( 0, 0, 0 );
}

float rf_reflection_probability_of_lane( const RfBsdfLanes* lanes, int lane, RfVec3 wo )
{
    Glass g = glass_of( lanes, lane );
    return reflection_probability( &g, reflectance( &g, rf_lift_to_horizon( g.n, wo ).cos_o ) );
}
