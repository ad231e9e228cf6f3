// Mirrors and glass, smooth or rough: reflection and transmission of facets, over a base that may show through.
#include "base/fault.h"
#include "bsdf/lane.h"
#include "bsdf/thin_film.h"

// What glass with dispersion or a thin film has of its own, by channel of light: the indices of refraction and the channels that a
// path carries.
typedef struct Spectrum
{
    float ior[3];   // of the far side over the near one
    float share[3]; // of the channels in the light that the path carries; their sum is 1
    float film, film_ior, film_thickness;
    bool splits; // the channels refract differently
} Spectrum;

// The channels' indices over that of the outside, 1: three wavelengths on the straight line through the index at the Fraunhofer d
// line, red and blue each half of nF − nC = (nd − 1) / V from green (KHR_materials_dispersion, implementation). dispersion: 20 / V.
static inline void disperse( float ior, float dispersion, float out[3] )
{
    float half = ( ior - 1.0f ) * 0.025f * dispersion;
    out[0] = rf_maxf( ior - half, 1.0f );
    out[1] = ior;
    out[2] = ior + half;
}

// As rf_pack_channels has them; their sum is 1.
static inline void unpack_channels( float code, float share[3] )
{
    int bits = (int)code, channel[3] = { bits & 255, bits >> 8 & 255, bits >> 16 & 255 },
        sum = channel[0] + channel[1] + channel[2];
    for ( int c = 0; c < 3; ++c )
        share[c] = sum > 0 ? (float)channel[c] / (float)sum : 1.0f / 3.0f;
}

// `ior` as RF_PARAM_IOR has it: of the far side over the near one. Thin walls do not refract, and panes must not depend on the path
// that comes to them.
static inline Spectrum make_spectrum( float ior, float dispersion, float film, float film_ior, float film_thickness,
                                      float choice )
{
    Spectrum s = { .film = rf_film_strength( film, film_thickness ), .film_ior = film_ior, .film_thickness = film_thickness };
    bool inside = ior > 0.0f && ior < 1.0f;
    s.splits = dispersion > 0.0f && ior > 0.0f;
    disperse( inside ? 1.0f / ior : fabsf( ior ), s.splits ? dispersion : 0.0f, s.ior );
    for ( int c = 0; c < 3 && inside; ++c )
        s.ior[c] = 1.0f / s.ior[c];
    unpack_channels( ior > 0.0f ? choice : 0.0f, s.share );
    return s;
}

static inline float mean_carried( const Spectrum* s, RfVec3 c )
{
    return s->share[0] * c.x + s->share[1] * c.y + s->share[2] * c.z;
}

// The channel that refraction goes on with, of those that are carried and transmitted, and the probability of that: 0 if there is
// none. `u` is uniform in [0, 1).
static inline int draw_channel( const Spectrum* s, RfVec3 transmitted, float u, float* probability )
{
    const float p[3] = { s->share[0] * transmitted.x, s->share[1] * transmitted.y, s->share[2] * transmitted.z };
    float sum = p[0] + p[1] + p[2], left = u * sum;
    int drawn = 0;
    *probability = 0.0f;
    if ( !( sum > 0.0f ) )
        return drawn;
    for ( int c = 0; c < 3; ++c )
    {
        if ( !( p[c] > 0.0f ) || ( *probability > 0.0f && left < 0.0f ) )
            continue;
        drawn = c;
        *probability = p[c] / sum;
        left -= p[c];
    }
    return drawn;
}

// Whether a lane is spectral is a constant wherever a Glass is made: all that takes one is inlined, so that glass without a spectrum
// pays nothing for it.
typedef struct Glass
{
    RfVec3 n, base, specular, tint;
    float alpha;
    float ior;              // of the far side over the near one; 0: mirror, which has no base: base.x is what its reflectance at
                            // grazing angles lacks of 1
    float metal;            // fraction that is metal with F0 `specular`; base and tint are scaled by the rest
    float base_share, bare; // fraction of the rest that is base, and the fraction of that which no coat covers
    bool thin;
    bool spectral;
    Spectrum spectrum; // if spectral
} Glass;

RF_KERNEL Glass glass_of( const RfBsdfLanes* lanes, int i, bool spectral )
{
    Glass g = {
        .n = rf_at( rf_lanes3( lanes->n ), i ),
        .base = rf_at( rf_lanes3( lanes->param + RF_PARAM_DIFFUSE ), i ),
        .specular = rf_at( rf_lanes3( lanes->param + RF_PARAM_SPECULAR ), i ),
        .tint = rf_at( rf_lanes3( lanes->param + RF_PARAM_TINT ), i ),
        .alpha = lanes->param[RF_PARAM_SHAPE][i],
        .ior = fabsf( lanes->param[RF_PARAM_IOR][i] ),
        .metal = lanes->param[RF_PARAM_F90][i],
        .base_share = lanes->param[RF_PARAM_COAT_F0][i],
        .bare = lanes->param[RF_PARAM_COAT_F90][i],
        .thin = lanes->param[RF_PARAM_IOR][i] < 0.0f,
        .spectral = spectral,
    };
    if ( spectral )
        g.spectrum = make_spectrum( lanes->param[RF_PARAM_IOR][i], lanes->param[RF_PARAM_DISPERSION][i],
                                    lanes->param[RF_PARAM_FILM][i], lanes->param[RF_PARAM_FILM_IOR][i],
                                    lanes->param[RF_PARAM_FILM_THICKNESS][i], lanes->param[RF_PARAM_CHOICE][i] );
    return g;
}

// The mean of a colour over the channels of the path.
RF_KERNEL float mean_of( const Glass* g, RfVec3 c ) { return g->spectral ? mean_carried( &g->spectrum, c ) : rf_mean( c ); }

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

static RfVec3 film_reflectance( const Spectrum* s, float cos_o, RfVec3 f0 )
{
    return rf_film_fresnel( f0, cos_o, s->film_ior, s->film_thickness );
}

// By channel, with a thin film. The film lies on the outside; light from inside meets the reflectance that light has outside on the
// same way, since what passes a film that does not absorb is the same from both sides.
static RfVec3 spectral_dielectric( const Spectrum* s, float cos_o )
{
    float f[3];
    for ( int c = 0; c < 3; ++c )
    {
        f[c] = dielectric( cos_o, s->ior[c] );
        if ( !( s->film > 0.0f ) || f[c] >= 1.0f )
            continue;
        bool inside = s->ior[c] < 1.0f;
        float n = inside ? 1.0f / s->ior[c] : s->ior[c], r = ( n - 1.0f ) / ( n + 1.0f ), f0 = r * r;
        float cosine = inside ? rf_minf( n * sqrtf( rf_maxf( refracted2( cos_o, s->ior[c] ), 0.0f ) ), 1.0f ) : cos_o;
        RfVec3 film = film_reflectance( s, cosine, rf_vec3( f0, f0, f0 ) );
        f[c] += s->film * ( ( c == 0 ? film.x : c == 1 ? film.y : film.z ) - f[c] );
    }
    return rf_vec3( f[0], f[1], f[2] );
}

RF_KERNEL RfVec3 dielectric_of( const Glass* g, float cos_o )
{
    if ( g->spectral )
        return spectral_dielectric( &g->spectrum, cos_o );
    float f = dielectric( cos_o, g->ior );
    return rf_vec3( f, f, f );
}

// Seen from inside a body, where total reflection would add to what the base reflects.
static inline bool is_inside( const Glass* g ) { return !g->thin && g->ior < 1.0f; }

// The most that can be reflected and transmitted together: bare base does neither.
static inline float glass_share( const Glass* g )
{
    return 1.0f - g->base_share * ( is_inside( g ) ? 1.0f : g->bare ) * ( 1.0f - g->metal );
}

// What a metal reflects by Schlick, and `grazing` by its weight.
static inline RfVec3 metallic( const Glass* g, float w, float grazing )
{
    float white = w * grazing;
    return rf_add( rf_scale( g->specular, 1.0f - w ), rf_vec3( white, white, white ) );
}

// What a metallic fraction reflects under a film.
static RfVec3 metallic_under_film( const Glass* g, float cos_o, RfVec3 bare, float fraction )
{
    if ( !( g->spectrum.film > 0.0f ) || !( fraction > 0.0f ) )
        return bare;
    RfVec3 film = rf_scale( film_reflectance( &g->spectrum, cos_o, rf_scale( g->specular, 1.0f / fraction ) ), fraction );
    return rf_madd( bare, rf_sub( film, bare ), g->spectrum.film );
}

// Reflectance: of mirrors and metals by Schlick, coloured.
RF_KERNEL RfVec3 reflectance( const Glass* g, float cos_o )
{
    float w = rf_schlick_weight( cos_o );
    if ( g->ior == 0.0f )
    {
        RfVec3 bare = metallic( g, w, 1.0f - g->base.x );
        return g->spectral ? metallic_under_film( g, cos_o, bare, 1.0f ) : bare;
    }
    float share = 1.0f - g->base_share * ( is_inside( g ) ? 1.0f : g->bare );
    if ( g->spectral )
    {
        RfVec3 metal = metallic_under_film( g, cos_o, metallic( g, w, g->metal ), g->metal );
        return rf_madd( metal, spectral_dielectric( &g->spectrum, cos_o ), share * ( 1.0f - g->metal ) );
    }
    float f = dielectric( cos_o, g->ior ) * share * ( 1.0f - g->metal ) + w * g->metal;
    return rf_add( rf_vec3( f, f, f ), rf_scale( g->specular, 1.0f - w ) );
}

// Transmission of the coat over the base, one way; under a film by the largest channel (KHR_materials_iridescence). Inside there
// is no coat: the base has its share of the surface, and the rest reflects and transmits.
RF_KERNEL RfVec3 base_transmission( const Glass* g, float cos_theta )
{
    if ( g->ior <= 0.0f )
        return rf_vec3( 0, 0, 0 );
    if ( is_inside( g ) )
        return rf_vec3( 1, 1, 1 );
    RfVec3 f = dielectric_of( g, cos_theta );
    if ( g->spectral && g->spectrum.film > 0.0f )
        f.x = f.y = f.z = rf_max_component( f );
    float coat = 1.0f - g->bare;
    return rf_vec3( 1.0f - coat * f.x, 1.0f - coat * f.y, 1.0f - coat * f.z );
}

// The probability of sampling the base, from the camera's cosine alone.
RF_KERNEL float base_probability( const Glass* g, float cos_o )
{
    RfVec3 through = base_transmission( g, cos_o );
    float base = g->spectral ? mean_of( g, rf_mul( g->base, through ) ) : rf_mean( g->base ) * through.x;
    float f = mean_of( g, reflectance( g, cos_o ) );
    float specular = f + ( 1.0f - f ) * mean_of( g, g->tint );
    return base > 0.0f ? base / ( base + specular ) : 0.0f;
}

// What a facet that reflects f transmits, at most.
RF_KERNEL RfVec3 transmitted_by_channel( const Glass* g, RfVec3 f )
{
    float share = glass_share( g );
    RfVec3 rest = rf_vec3( rf_maxf( share - f.x, 0.0f ), rf_maxf( share - f.y, 0.0f ), rf_maxf( share - f.z, 0.0f ) );
    return rf_mul( g->tint, rest );
}

// The probability of reflection rather than transmission, given the facet.
RF_KERNEL float reflection_probability( const Glass* g, RfVec3 f )
{
    float reflected = mean_of( g, f ), transmitted = rf_maxf( glass_share( g ) - reflected, 0.0f ) * mean_of( g, g->tint );
    if ( g->spectral ) // by channel: a path that carries one alone has its chances
        transmitted = mean_of( g, transmitted_by_channel( g, f ) );
    return reflected + transmitted > 0.0f || RF_FAULT( no_reflection ) ? reflected / ( reflected + transmitted ) : 1.0f;
}

static inline float smith( float alpha, float cos_theta ) // 1 + 2 Λ
{
    float a2 = alpha * alpha, c2 = cos_theta * cos_theta;
    return sqrtf( a2 / c2 + 1.0f - a2 );
}

static inline RfVec3 mirrored( RfVec3 wo, RfVec3 h ) { return rf_sub( rf_scale( h, 2.0f * rf_dot( wo, h ) ), wo ); }

// The transmitted direction: refracted by the facet by this index, or in a thin wall straight on,
// spread like the reflection.
RF_KERNEL RfVec3 transmitted( const Glass* g, float ior, RfVec3 wo, RfVec3 h )
{
    if ( g->thin )
    {
        RfVec3 r = mirrored( wo, h );
        return rf_madd( r, g->n, -2.0f * rf_dot( r, g->n ) );
    }
    float cos_o = rf_dot( wo, h ), inverse = 1.0f / ior;
    float t = sqrtf( rf_maxf( refracted2( cos_o, ior ), 0.0f ) );
    return rf_normalize( rf_madd( rf_scale( wo, -inverse ), h, inverse * ( cos_o - t ) ) );
}

// A direction, its weight f |cos| / density, and the density.
typedef struct GlassSample
{
    RfVec3 wi, weight;
    float pdf_solid_angle;
} GlassSample;

// Of the colour by an index of refraction, drawn with `probability`.
RF_KERNEL GlassSample transmit( const Glass* g, float ior, RfEyeLane eye, RfVec3 h, RfVec3 colour, float probability )
{
    GlassSample out = { transmitted( g, ior, eye.wo, h ), { 0, 0, 0 }, RF_DELTA_PDF };
    float cos_i = -rf_dot( g->n, out.wi );
    if ( cos_i <= 0.0f )
        return out;
    // radiance scales with the squared index
    float radiance_scale = g->thin && !RF_FAULT( radiance_scale ) ? 1.0f : 1.0f / ( ior * ior );
    float shadow = g->alpha > 0.0f ? 2.0f / ( 1.0f + smith( g->alpha, cos_i ) ) : 1.0f;
    out.weight = rf_scale( colour, radiance_scale * shadow / probability );
    return out;
}

// Where channels refract differently, one goes on, for `u` in [0, 1).
RF_KERNEL GlassSample sample_transmission( const Glass* g, RfEyeLane eye, RfVec3 h, float probability, float u )
{
    RfVec3 reflected = dielectric_of( g, rf_dot( eye.wo, h ) ); // the metallic fraction is not in the tint
    RfVec3 colour = rf_mul( g->tint, rf_vec3( 1.0f - reflected.x, 1.0f - reflected.y, 1.0f - reflected.z ) );
    if ( !g->spectral || !g->spectrum.splits )
        return transmit( g, g->ior, eye, h, colour, probability );
    float chance;
    int drawn = draw_channel( &g->spectrum, colour, u, &chance );
    if ( !( chance > 0.0f ) )
        return ( GlassSample ){ transmitted( g, g->ior, eye.wo, h ), { 0, 0, 0 }, RF_DELTA_PDF };
    RfVec3 one = rf_vec3( drawn == 0 ? colour.x : 0.0f, drawn == 1 ? colour.y : 0.0f, drawn == 2 ? colour.z : 0.0f );
    return transmit( g, g->spectrum.ior[drawn], eye, h, one, probability * chance );
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

// D for a facet, without the cancellation of 1 − cos².
RF_KERNEL float facet_density( const Glass* g, RfVec3 h )
{
    RfVec3 cross = rf_cross( g->n, h );
    float along = rf_dot( g->n, h ), a2 = g->alpha * g->alpha, q = a2 * along * along + rf_dot( cross, cross );
    return along > 0.0f ? a2 * RF_INV_PI / ( q * q ) : 0.0f;
}

// The lobes that are no deltas: the base, and rough reflection.
RF_KERNEL RfScattering evaluate( const Glass* g, RfEyeLane eye, RfVec3 wi )
{
    RfScattering s = { { 0, 0, 0 }, 0.0f };
    float cos_i = rf_dot( g->n, wi ), cos_o = eye.cos_o;
    if ( cos_i <= 0.0f )
        return s;
    float probability = base_probability( g, cos_o );
    if ( probability > 0.0f )
    {
        RfVec3 in = rf_scale( base_transmission( g, cos_o ), RF_INV_PI ), out = base_transmission( g, cos_i );
        s.f = rf_mul( g->base, rf_mul( in, out ) );
        s.pdf_solid_angle = probability * cos_i * RF_INV_PI;
    }
    if ( g->alpha == 0.0f )
        return s;
    RfVec3 sum = rf_add( eye.wo, wi ), h = rf_normalize( sum );
    float d = facet_density( g, h ), so = smith( g->alpha, cos_o ), si = smith( g->alpha, cos_i );
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
RF_KERNEL GlassSample finish_non_delta( const Glass* g, RfEyeLane eye, RfVec3 wi )
{
    RfScattering s = evaluate( g, eye, wi );
    GlassSample out = { wi, { 0, 0, 0 }, s.pdf_solid_angle };
    if ( s.pdf_solid_angle > 0.0f || RF_FAULT( glass_no_density ) )
        out.weight = rf_scale( s.f, rf_dot( g->n, wi ) / s.pdf_solid_angle );
    return out;
}

RF_KERNEL GlassSample sample( const Glass* g, RfEyeLane eye, const float u[3] )
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
        return sample_transmission( g, eye, h, ( 1.0f - base ) * ( 1.0f - reflect ), ( u_facet - reflect ) / ( 1.0f - reflect ) );
    RfVec3 wi = mirrored( eye.wo, h );
    if ( g->alpha > 0.0f )
        return finish_non_delta( g, eye, wi );
    return ( GlassSample ){ wi, rf_scale( f, 1.0f / ( ( 1.0f - base ) * reflect ) ), RF_DELTA_PDF };
}

RF_KERNEL void sample_lanes( bool spectral, int count, const RfBsdfLanes* lanes, const float* const wo[3],
                             const float* const u[3], float* const wi[3], float* const weight[3], float* pdf_solid_angle )
{
    for ( int i = 0; i < count; ++i )
    {
        Glass g = glass_of( lanes, i, spectral );
        float random[3] = { u[0][i], u[1][i], u[2][i] };
        RfEyeLane eye = rf_lift_to_horizon( g.n, rf_at( rf_lanes3( wo ), i ) );
        GlassSample s = sample( &g, eye, random );
        rf_put( rf_lanes_out3( wi ), i, s.wi );
        rf_put( rf_lanes_out3( weight ), i, s.weight );
        pdf_solid_angle[i] = s.pdf_solid_angle;
    }
}

RF_KERNEL void evaluate_lanes( bool spectral, int count, const RfBsdfLanes* lanes, const float* const wo[3],
                               const float* const wi[3], float* const f[3], float* pdf_solid_angle )
{
    for ( int i = 0; i < count; ++i )
    {
        Glass g = glass_of( lanes, i, spectral );
        RfEyeLane eye = rf_lift_to_horizon( g.n, rf_at( rf_lanes3( wo ), i ) );
        RfScattering s = evaluate( &g, eye, rf_at( rf_lanes3( wi ), i ) );
        if ( f != NULL )
            rf_put( rf_lanes_out3( f ), i, s.f );
        if ( pdf_solid_angle != NULL )
            pdf_solid_angle[i] = s.pdf_solid_angle;
    }
}

#define GLASS_FUNCTIONS( model, spectral )                                                                                       \
    void rf_##model##_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],         \
                                float* const f[3], float* pdf_solid_angle )                                                      \
    {                                                                                                                            \
        evaluate_lanes( spectral, count, lanes, wo, wi, f, pdf_solid_angle );                                                    \
    }                                                                                                                            \
    void rf_##model##_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],            \
                              float* const wi[3], float* const weight[3], float* pdf_solid_angle )                               \
    {                                                                                                                            \
        sample_lanes( spectral, count, lanes, wo, u, wi, weight, pdf_solid_angle );                                              \
    }

GLASS_FUNCTIONS( glass, false )
GLASS_FUNCTIONS( spectral, true )

// FROSTED: rough glass without a spectrum where a camera sees it, from outside or, where it is thin, from either side. Like
// TRANSLUCENT it has drawn the side on which light arrives (RF_PARAM_CHOICE), where n is, and scatters the light of one hemisphere
// over the probability of its side: base and reflection on the side that is seen, and on the other, by Walter et al. (2007), eq. 21,
//
//   f = T (1 − F) D G1 G1 |o·h| |i·h| / ( |n·o| |n·i| |o + η i|² )        h = −(o + η i) / |o + η i|
//
// with the index η inside; walls without an inside spread what they transmit as they spread what they reflect.

// The side that is seen: what it scatters, and how likely each of it is.
typedef struct Frosted
{
    Glass glass; // n is on the side that is seen
    float base;  // the probability of sampling the base rather than reflection
    float side;  // the probability of the side that was drawn
    float scale; // one over it
    bool through;
} Frosted;

// A facet at 60°, which reflects about as much as all together do; at least a tenth, as lamps are seen in it.
#define FROSTED_COSINE 0.5f
#define LEAST_REFLECTION 0.1f

RF_KERNEL Frosted frosted_of( const RfBsdfLanes* lanes, int i )
{
    Frosted out = { .glass = glass_of( lanes, i, false ) };
    Glass* g = &out.glass;
    float choice = lanes->param[RF_PARAM_CHOICE][i];
    g->n = rf_scale( g->n, choice );
    float base = rf_mean( g->base ) * base_transmission( g, FROSTED_COSINE ).x;
    float here = base + rf_mean( reflectance( g, FROSTED_COSINE ) ),
          there = rf_mean( g->tint ) * ( 1.0f - dielectric( FROSTED_COSINE, g->ior ) );
    float through = there > 0.0f ? there / ( here + there ) : 0.0f;
    through = rf_minf( through, 1.0f - LEAST_REFLECTION );
    out.base = base > 0.0f ? base / here : 0.0f;
    out.through = choice < 0.0f;
    out.side = out.through ? through : 1.0f - through;
    out.scale = out.side > 0.0f ? 1.0f / out.side : 0.0f;
    return out;
}

float rf_frosted_through_probability( const RfBsdfLanes* lanes, int lane )
{
    Frosted f = frosted_of( lanes, lane );
    return f.through ? f.side : 1.0f - f.side;
}

RF_KERNEL RfScattering evaluate_through( const Frosted* at, RfEyeLane eye, RfVec3 wi )
{
    const Glass* g = &at->glass;
    RfScattering s = { { 0, 0, 0 }, 0.0f };
    float cos_i = -rf_dot( g->n, wi );
    if ( cos_i <= 0.0f )
        return s;
    RfVec3 sum = g->thin ? rf_add( eye.wo, rf_madd( wi, g->n, 2.0f * cos_i ) ) : rf_madd( eye.wo, wi, g->ior );
    RfVec3 h = rf_scale( rf_normalize( sum ), g->thin ? 1.0f : -1.0f );
    float facet_o = rf_dot( eye.wo, h ), facet_i = -rf_dot( wi, h ), length2 = rf_dot( sum, sum );
    if ( facet_o <= 0.0f || ( !g->thin && facet_i <= 0.0f ) )
        return s;
    float stretch = g->thin ? 0.25f / facet_o : g->ior * g->ior * facet_i / length2; // facets per direction
    float masking = 2.0f / ( 1.0f + smith( g->alpha, eye.cos_o ) ), shadowing = 2.0f / ( 1.0f + smith( g->alpha, cos_i ) );
    s.pdf_solid_angle = masking * facet_density( g, h ) * facet_o / eye.cos_o * stretch;
    float f = 1.0f - dielectric( facet_o, g->ior ), radiance_scale = g->thin ? 1.0f : 1.0f / ( g->ior * g->ior );
    s.f = rf_scale( g->tint, f * shadowing * radiance_scale * at->scale * s.pdf_solid_angle / cos_i );
    return s;
}

RF_KERNEL RfScattering evaluate_here( const Frosted* at, RfEyeLane eye, RfVec3 wi )
{
    const Glass* g = &at->glass;
    RfScattering s = { { 0, 0, 0 }, 0.0f };
    float cos_i = rf_dot( g->n, wi ), cos_o = eye.cos_o;
    if ( cos_i <= 0.0f )
        return s;
    RfVec3 sum = rf_add( eye.wo, wi ), h = rf_normalize( sum );
    float d = facet_density( g, h ), so = smith( g->alpha, cos_o ), si = smith( g->alpha, cos_i );
    RfVec3 in = base_transmission( g, cos_o ), out = base_transmission( g, cos_i );
    RfVec3 base = rf_scale( rf_mul( g->base, rf_mul( in, out ) ), RF_INV_PI * at->scale );
    RfVec3 f = reflectance( g, 0.5f * rf_length( sum ) );
    s.f = rf_madd( base, f, at->scale * d * 2.0f / ( so + si ) / ( 4.0f * cos_o * cos_i ) );
    s.pdf_solid_angle = at->base * cos_i * RF_INV_PI + ( 1.0f - at->base ) * d * 2.0f / ( 1.0f + so ) / ( 4.0f * cos_o );
    return s;
}

void rf_frosted_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                          float* const f[3], float* pdf_solid_angle )
{
    for ( int i = 0; i < count; ++i )
    {
        Frosted at = frosted_of( lanes, i );
        RfEyeLane eye = rf_lift_to_horizon( at.glass.n, rf_at( rf_lanes3( wo ), i ) );
        RfVec3 in = rf_at( rf_lanes3( wi ), i );
        RfScattering s = at.through ? evaluate_through( &at, eye, in ) : evaluate_here( &at, eye, in );
        if ( f != NULL )
            rf_put( rf_lanes_out3( f ), i, s.f );
        if ( pdf_solid_angle != NULL )
            pdf_solid_angle[i] = s.pdf_solid_angle;
    }
}

void rf_frosted_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                        float* const wi[3] )
{
    for ( int i = 0; i < count; ++i )
    {
        Frosted at = frosted_of( lanes, i );
        const Glass* g = &at.glass;
        RfEyeLane eye = rf_lift_to_horizon( g->n, rf_at( rf_lanes3( wo ), i ) );
        RfVec3 h = sample_facet( g, eye, u[0][i], u[1][i] ), out;
        if ( at.through )
            out = transmitted( g, g->ior, eye.wo, h );
        else if ( u[2][i] < at.base )
            out = rf_madd( rf_scale( rf_azimuth_direction( g->n, u[1][i] ), sqrtf( u[0][i] ) ), g->n, sqrtf( 1.0f - u[0][i] ) );
        else
            out = mirrored( eye.wo, h );
        rf_put( rf_lanes_out3( wi ), i, out );
    }
}

// What single lobes of mirrors and glass are: panes, and delta lobes that are asked for by name.

// Rays from below the shading horizon do not go straight: they are lifted to it, so the wall is no pane for them.
RF_KERNEL RfPane pane( const Glass* g, float cos_o )
{
    if ( !g->thin || g->alpha > 0.0f || cos_o < RF_MIN_COS || !( rf_max_component( g->tint ) > 0.0f ) )
        return ( RfPane ){ 0.0f, { 0, 0, 0 } };
    float base = base_probability( g, cos_o ), reflect = reflection_probability( g, reflectance( g, cos_o ) );
    RfVec3 reflected = dielectric_of( g, cos_o );
    // below 1, so that it shows whether there was a pane
    float probability = rf_minf( ( 1.0f - base ) * ( 1.0f - reflect ), 1.0f - 0x1p-24f );
    return ( RfPane ){ probability, rf_mul( g->tint, rf_vec3( 1.0f - reflected.x, 1.0f - reflected.y, 1.0f - reflected.z ) ) };
}

// What a material without a spectrum is, with an index of refraction of the far side over the near one.
static Glass glass_of_material( const RfMaterial* m, float ior )
{
    return ( Glass ){
        .base = m->diffuse,
        .specular = m->specular,
        .tint = m->tint,
        .alpha = m->alpha,
        .ior = ior,
        .metal = m->f90,
        .base_share = m->coat_f0,
        .bare = m->coat_f90,
        .thin = m->thin && ior > 0.0f,
    };
}

RfPane rf_pane_of_material( const RfMaterial* m, float cos_o )
{
    Glass g = glass_of_material( m, m->ior );
    if ( m->kind != RF_BSDF_SPECTRAL )
        return pane( &g, cos_o );
    g.spectral = true;
    g.spectrum = make_spectrum( -m->ior, m->dispersion, m->film, m->film_ior, m->film_thickness, 0.0f );
    return pane( &g, cos_o );
}

RfPane rf_pane_of_lane( RfBsdfKind kind, const RfBsdfLanes* lanes, int lane, RfVec3 wo )
{
    if ( kind == RF_BSDF_SPECTRAL )
    {
        Glass spectral = glass_of( lanes, lane, true );
        return pane( &spectral, rf_dot( spectral.n, wo ) );
    }
    Glass g = glass_of( lanes, lane, false );
    return pane( &g, rf_dot( g.n, wo ) );
}

RfDeltaEvent rf_glass_event( const RfBsdfLanes* lanes, int lane, RfVec3 wo, bool transmits )
{
    Glass g = glass_of( lanes, lane, false );
    RfEyeLane eye = rf_lift_to_horizon( g.n, wo );
    float base = base_probability( &g, eye.cos_o );
    RfVec3 f = reflectance( &g, rf_dot( eye.wo, g.n ) );
    float reflect = reflection_probability( &g, f );
    float probability = ( 1.0f - base ) * ( transmits ? 1.0f - reflect : reflect );
    if ( g.alpha > 0.0f || !( probability > 0.0f ) )
        return ( RfDeltaEvent ){ wo, { 0, 0, 0 }, 0.0f };
    if ( !transmits )
        return ( RfDeltaEvent ){ mirrored( eye.wo, g.n ), rf_scale( f, 1.0f / probability ), probability };
    GlassSample s = sample_transmission( &g, eye, g.n, probability, 0.0f );
    return ( RfDeltaEvent ){ s.wi, s.weight, probability };
}

float rf_glass_reflection( const RfMaterial* material, float cos_o, RfVec3* weight )
{
    Glass g = glass_of_material( material, material->ior );
    float base = base_probability( &g, cos_o );
    RfVec3 f = reflectance( &g, cos_o );
    float probability = ( 1.0f - base ) * reflection_probability( &g, f );
    *weight = probability > 0.0f ? rf_scale( f, 1.0f / probability ) : rf_vec3( 0, 0, 0 );
    return probability;
}

void rf_glass_delta_lobes( const RfMaterial* m, float ior, float cos_o, RfVec3* reflected, RfVec3* transmitted )
{
    Glass g = glass_of_material( m, ior );
    *reflected = reflectance( &g, cos_o );
    *transmitted = ior > 0.0f ? rf_scale( m->tint, 1.0f - dielectric( cos_o, ior ) ) : rf_vec3( 0, 0, 0 );
}

float rf_reflection_probability_of_lane( RfBsdfKind kind, const RfBsdfLanes* lanes, int lane, RfVec3 wo )
{
    if ( kind == RF_BSDF_SPECTRAL )
    {
        Glass spectral = glass_of( lanes, lane, true );
        return reflection_probability( &spectral, reflectance( &spectral, rf_lift_to_horizon( spectral.n, wo ).cos_o ) );
    }
    Glass g = glass_of( lanes, lane, false );
    return reflection_probability( &g, reflectance( &g, rf_lift_to_horizon( g.n, wo ).cos_o ) );
}

RfSmoothLobes rf_smooth_lobes_of_lane( RfBsdfKind kind, const RfBsdfLanes* lanes, int lane, RfVec3 wo )
{
    Glass g = glass_of( lanes, lane, kind == RF_BSDF_SPECTRAL );
    RfEyeLane eye = rf_lift_to_horizon( g.n, wo );
    RfVec3 through = dielectric_of( &g, eye.cos_o );
    float ior = g.spectral && g.spectrum.splits ? g.spectrum.ior[1] : g.ior;
    RfSmoothLobes lobes = {
        .base = rf_mul( g.base, base_transmission( &g, eye.cos_o ) ), // of mirrors: 0
        .reflected = reflectance( &g, eye.cos_o ),
        .transmitted = rf_mul( g.tint, rf_vec3( 1.0f - through.x, 1.0f - through.y, 1.0f - through.z ) ),
        .reflected_wi = mirrored( eye.wo, g.n ),
    };
    lobes.transmitted_wi = ior > 0.0f ? transmitted( &g, ior, eye.wo, g.n ) : rf_scale( eye.wo, -1.0f );
    return lobes;
}
