// Mirrors and glass. A microfacet surface (GGX; alpha 0: smooth) that reflects
// by Fresnel's equations and transmits the rest, tinted (Walter et al. 2007), over
// a Lambert base where the material is not fully transmissive, mixed with a metal
// of the same roughness where textures say so. Not vectorised: such lanes are few
// and diverge.
//
// Light sampling can find the directions of the base and of rough reflection. All
// other lobes have RF_DELTA_PDF: smooth ones, and transmission, which only BSDF
// sampling finds.
#include "bsdf/glass.h"

#include "base/fault.h"

// The lobes that are no deltas: the base, and rough reflection.
static RfScattering evaluate( const Glass* g, RfEyeLane eye, RfVec3 wi )
{
    RfScattering s = { { 0, 0, 0 }, 0.0f };
    float cos_i = rf_dot( g->n, wi ), cos_o = eye.cos_o;
    if ( cos_i <= 0.0f )
        return s;
    float probability = base_probability( g, cos_o );
    if ( probability > 0.0f )
    {
        s.f = rf_scale( g->base, RF_INV_PI * base_transmission( g, cos_o ) * base_transmission( g, cos_i ) );
        s.pdf_solid_angle = probability * cos_i * RF_INV_PI;
    }
    if ( g->alpha == 0.0f )
        return s;
    RfVec3 sum = rf_add( eye.wo, wi ), h = rf_normalize( sum );
    RfVec3 cross = rf_cross( g->n, h );
    float along = rf_dot( g->n, h ), a2 = g->alpha * g->alpha;
    float q = a2 * along * along + rf_dot( cross, cross );
    float d = a2 * RF_INV_PI / ( q * q );
    float so = smith( g->alpha, cos_o ), si = smith( g->alpha, cos_i );
    RfVec3 f = reflectance( g, 0.5f * rf_length( sum ) ); // wo·h, of which the product keeps two digits at grazing angles
    s.f = rf_add( s.f, rf_scale( f, d * 2.0f / ( so + si ) / ( 4.0f * cos_o * cos_i ) ) );
    s.pdf_solid_angle += ( 1.0f - probability ) * reflection_probability( g, f ) * d * 2.0f / ( 1.0f + so ) / ( 4.0f * cos_o );
    return s;
}

// Samples a visible unit normal (Heitz, JCGT 2018).
static RfVec3 sample_facet( const Glass* g, RfEyeLane eye, float u, float v )
{
    if ( g->alpha == 0.0f )
        return g->n;
    RfVec3 t, b;
    rf_basis( g->n, &t, &b );
    RfVec3 w = rf_normalize( rf_vec3( g->alpha * rf_dot( eye.wo, t ), g->alpha * rf_dot( eye.wo, b ), eye.cos_o ) );
    float z = ( 1.0f - u ) * ( 1.0f + w.z ) - w.z, r = sqrtf( rf_maxf( 1.0f - z * z, 0.0f ) ), sine, cosine;
    rf_sincos_2pi( v, &sine, &cosine );
    RfVec3 h = rf_vec3( g->alpha * ( r * cosine + w.x ), g->alpha * ( r * sine + w.y ), rf_maxf( z + w.z, 1e-9f ) );
    return rf_normalize( rf_add( rf_add( rf_scale( t, h.x ), rf_scale( b, h.y ) ), rf_scale( g->n, h.z ) ) );
}

// A non-delta lobe was sampled: weight and density are those of all such lobes.
static GlassSample finish_non_delta( const Glass* g, RfEyeLane eye, RfVec3 wi )
{
    RfScattering s = evaluate( g, eye, wi );
    GlassSample out = { wi, { 0, 0, 0 }, s.pdf_solid_angle };
    if ( s.pdf_solid_angle > 0.0f || RF_FAULT( glass_no_density ) )
        out.weight = rf_scale( s.f, rf_dot( g->n, wi ) / s.pdf_solid_angle );
    return out;
}

static GlassSample sample( const Glass* g, RfEyeLane eye, const float u[3] )
{
    float base = base_probability( g, eye.cos_o );
    if ( u[2] < base )
    {
        RfVec3 azimuth = rf_azimuth_direction( g->n, u[1] );
        return finish_non_delta( g, eye, rf_madd( rf_scale( azimuth, sqrtf( u[0] ) ), g->n, sqrtf( 1.0f - u[0] ) ) );
    }
    float u_facet = ( u[2] - base ) / ( 1.0f - base );
    RfVec3 h = sample_facet( g, eye, u[0], u[1] );
    RfVec3 f = reflectance( g, rf_dot( eye.wo, h ) );
    float reflect = reflection_probability( g, f );
    if ( u_facet >= reflect && reflect < 1.0f ) // the quotient may be 1
        return sample_transmission( g, eye, h, ( 1.0f - base ) * ( 1.0f - reflect ) );
    RfVec3 wi = mirrored( eye.wo, h );
    if ( g->alpha > 0.0f )
        return finish_non_delta( g, eye, wi );
    return ( GlassSample ){ wi, rf_scale( f, 1.0f / ( ( 1.0f - base ) * reflect ) ), RF_DELTA_PDF };
}

static void put( float* const out[3], int i, RfVec3 v )
{
    out[0][i] = v.x;
    out[1][i] = v.y;
    out[2][i] = v.z;
}

void rf_glass_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3], float* const wi[3],
                      float* const weight[3], float* pdf_solid_angle )
{
    for ( int i = 0; i < count; ++i )
    {
        Glass g = glass_of( lanes, i );
        float random[3] = { u[0][i], u[1][i], u[2][i] };
        RfEyeLane eye = rf_lift_to_horizon( g.n, rf_vec3( wo[0][i], wo[1][i], wo[2][i] ) );
        GlassSample s = sample( &g, eye, random );
        put( wi, i, s.wi );
        put( weight, i, s.weight );
        pdf_solid_angle[i] = s.pdf_solid_angle;
    }
}

void rf_glass_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                        float* const f[3], float* pdf_solid_angle )
{
    for ( int i = 0; i < count; ++i )
    {
        Glass g = glass_of( lanes, i );
        RfEyeLane eye = rf_lift_to_horizon( g.n, rf_vec3( wo[0][i], wo[1][i], wo[2][i] ) );
        RfScattering s = evaluate( &g, eye, rf_vec3( wi[0][i], wi[1][i], wi[2][i] ) );
        if ( f != NULL )
            put( f, i, s.f );
        if ( pdf_solid_angle != NULL )
            pdf_solid_angle[i] = s.pdf_solid_angle;
    }
}
