// A point of a mirror or of glass, and its events. Private to glass.c and glass_lobes.c.
#ifndef REFRAME_BSDF_GLASS_H
#define REFRAME_BSDF_GLASS_H

#include "base/fault.h"
#include "bsdf/lane.h"

typedef struct Glass
{
    RfVec3 n, base, specular, tint;
    float alpha;
    float ior;              // of the far side over the near one; 0: mirror, which has no base: base.x is what its reflectance at
                            // grazing angles lacks of 1
    float metal;            // fraction that is metal with F0 `specular`; base and tint are scaled by the rest
    float base_share, bare; // fraction of the rest that is base, and the fraction of that which no coat covers
    bool thin;
} Glass;

static inline Glass glass_of( const RfBsdfLanes* lanes, int i )
{
    return ( Glass ){
        .n = rf_vec3( lanes->n[0][i], lanes->n[1][i], lanes->n[2][i] ),
        .base = rf_vec3( lanes->param[RF_PARAM_DIFFUSE][i], lanes->param[RF_PARAM_DIFFUSE + 1][i],
                         lanes->param[RF_PARAM_DIFFUSE + 2][i] ),
        .specular = rf_vec3( lanes->param[RF_PARAM_SPECULAR][i], lanes->param[RF_PARAM_SPECULAR + 1][i],
                             lanes->param[RF_PARAM_SPECULAR + 2][i] ),
        .tint = rf_vec3( lanes->param[RF_PARAM_TINT][i], lanes->param[RF_PARAM_TINT + 1][i], lanes->param[RF_PARAM_TINT + 2][i] ),
        .alpha = lanes->param[RF_PARAM_SHAPE][i],
        .ior = fabsf( lanes->param[RF_PARAM_IOR][i] ),
        .metal = lanes->param[RF_PARAM_F90][i],
        .base_share = lanes->param[RF_PARAM_COAT_F0][i],
        .bare = lanes->param[RF_PARAM_COAT_F90][i],
        .thin = lanes->param[RF_PARAM_IOR][i] < 0.0f,
    };
}

// The square of ior cosθt by Snell's law, at most 0 where all is reflected. 1 − sin²θ would lose the digits of grazing angles,
// where an index of 1 must give cosθo itself.
static inline float refracted2( float cos_o, float ior )
{
    return RF_FAULT( snell ) ? ior * ior - ( 1.0f - cos_o * cos_o ) : cos_o * cos_o + ( ior - 1.0f ) * ( ior + 1.0f );
}

// Fresnel reflectance of a dielectric for unpolarised light.
static inline float dielectric( float cos_o, float ior )
{
    cos_o = rf_maxf( cos_o, 0.0f ); // rounding may turn a grazing facet away
    float t2 = refracted2( cos_o, ior );
    if ( t2 <= 0.0f && !RF_FAULT( total_reflection ) )
        return 1.0f;
    float t = sqrtf( t2 ), dense = ior * ior * cos_o;
    float s = ( cos_o - t ) / ( cos_o + t );
    float p = ( dense - t ) / ( dense + t );
    return 0.5f * ( s * s + p * p );
}

static inline float schlick_weight( float cos_o )
{
    float m = 1.0f - rf_minf( cos_o, 1.0f ), m2 = m * m;
    return m2 * m2 * m;
}

// Seen from inside a body, where total reflection would add to what the base reflects.
static inline bool is_inside( const Glass* g ) { return !g->thin && g->ior < 1.0f; }

// The most that can be reflected and transmitted together: bare base does neither.
static inline float glass_share( const Glass* g )
{
    return 1.0f - g->base_share * ( is_inside( g ) ? 1.0f : g->bare ) * ( 1.0f - g->metal );
}

// Reflectance: of mirrors and metals by Schlick, coloured.
static inline RfVec3 reflectance( const Glass* g, float cos_o )
{
    float w = schlick_weight( cos_o );
    if ( g->ior == 0.0f )
    {
        float grazing = w * ( 1.0f - g->base.x );
        return rf_add( rf_scale( g->specular, 1.0f - w ), rf_vec3( grazing, grazing, grazing ) );
    }
    float share = 1.0f - g->base_share * ( is_inside( g ) ? 1.0f : g->bare );
    float f = dielectric( cos_o, g->ior ) * share * ( 1.0f - g->metal ) + w * g->metal;
    return rf_add( rf_vec3( f, f, f ), rf_scale( g->specular, 1.0f - w ) );
}

// Transmission of the coat over the base, one way. Inside there is no coat: the base has its share of the surface, and the
// rest reflects and transmits.
static inline float base_transmission( const Glass* g, float cos_theta )
{
    if ( g->ior <= 0.0f )
        return 0.0f;
    return is_inside( g ) ? 1.0f : 1.0f - ( 1.0f - g->bare ) * dielectric( cos_theta, g->ior );
}

// The probability of sampling the base, from the eye's cosine alone.
static inline float base_probability( const Glass* g, float cos_o )
{
    float base = rf_mean( g->base ) * base_transmission( g, cos_o );
    float f = rf_mean( reflectance( g, cos_o ) );
    float specular = f + ( 1.0f - f ) * rf_mean( g->tint );
    return base > 0.0f ? base / ( base + specular ) : 0.0f;
}

// The probability of reflection rather than transmission, given the facet.
static inline float reflection_probability( const Glass* g, RfVec3 f )
{
    float reflected = rf_mean( f ), transmitted = rf_maxf( glass_share( g ) - reflected, 0.0f ) * rf_mean( g->tint );
    return reflected + transmitted > 0.0f || RF_FAULT( no_reflection ) ? reflected / ( reflected + transmitted ) : 1.0f;
}

static inline float smith( float alpha, float cos_theta ) // 1 + 2 Λ
{
    float a2 = alpha * alpha, c2 = cos_theta * cos_theta;
    return sqrtf( a2 / c2 + 1.0f - a2 );
}

static inline RfVec3 mirrored( RfVec3 wo, RfVec3 h ) { return rf_sub( rf_scale( h, 2.0f * rf_dot( wo, h ) ), wo ); }

// The transmitted direction: refracted by the facet, or in a thin wall straight on,
// spread like the reflection.
static inline RfVec3 transmitted( const Glass* g, RfVec3 wo, RfVec3 h )
{
    if ( g->thin )
    {
        RfVec3 r = mirrored( wo, h );
        return rf_madd( r, g->n, -2.0f * rf_dot( r, g->n ) );
    }
    float cos_o = rf_dot( wo, h ), inverse = 1.0f / g->ior;
    float t = sqrtf( rf_maxf( refracted2( cos_o, g->ior ), 0.0f ) );
    return rf_normalize( rf_madd( rf_scale( wo, -inverse ), h, inverse * ( cos_o - t ) ) );
}

// A direction, its weight f |cos| / density, and the density.
typedef struct GlassSample
{
    RfVec3 wi, weight;
    float pdf_solid_angle;
} GlassSample;

static inline GlassSample sample_transmission( const Glass* g, RfEyeLane eye, RfVec3 h, float probability )
{
    GlassSample out = { transmitted( g, eye.wo, h ), { 0, 0, 0 }, RF_DELTA_PDF };
    float cos_i = -rf_dot( g->n, out.wi );
    if ( cos_i <= 0.0f )
        return out;
    // radiance scales with the squared index
    float radiance_scale = g->thin && !RF_FAULT( radiance_scale ) ? 1.0f : 1.0f / ( g->ior * g->ior );
    float shadow = g->alpha > 0.0f ? 2.0f / ( 1.0f + smith( g->alpha, cos_i ) ) : 1.0f;
    float rest = 1.0f - dielectric( rf_dot( eye.wo, h ), g->ior ); // the metallic fraction is not in the tint
    out.weight = rf_scale( rf_scale( g->tint, rest ), radiance_scale * shadow / probability );
    return out;
}

#endif
