// Mirrors and glass, smooth or rough: reflection and transmission of facets, over a base that may show through.
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

// The probability of sampling the base, from the camera's cosine alone.
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

// Events at a point of a mirror or of glass.

// Mirrors and glass. A microfacet surface (GGX; alpha 0: smooth) that reflects
// by Fresnel's equations and transmits the rest, tinted (Walter et al. 2007), over
// a Lambert base where the material is not fully transmissive, mixed with a metal
// of the same roughness where textures say so. Not vectorised: such lanes are few
// and diverge.
//
// Light sampling can find the directions of the base and of rough reflection. All
// other lobes have RF_DELTA_PDF: smooth ones, and transmission, which only BSDF
// sampling finds.

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

// What single lobes of mirrors and glass are: panes, and delta lobes that are asked for by name.

// Rays from below the shading horizon do not go straight: they are lifted to it, so the wall is no pane for them.
static RfPane pane( const Glass* g, float cos_o )
{
    if ( !g->thin || g->alpha > 0.0f || cos_o < RF_MIN_COS || !( rf_max_component( g->tint ) > 0.0f ) )
        return ( RfPane ){ 0.0f, { 0, 0, 0 } };
    float base = base_probability( g, cos_o ), reflect = reflection_probability( g, reflectance( g, cos_o ) );
    float rest = 1.0f - dielectric( cos_o, g->ior );
    // below 1, so that it shows whether there was a pane
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
