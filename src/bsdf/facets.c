// GGX with two roughnesses, as of brushed metal (KHR_materials_anisotropy), under a thin film, in the colours of soap bubbles and
// tempered steel (KHR_materials_iridescence), or both, over the Lambert base of ggx.c.
//
//   f = D G2 F / (4 μo μi) + ρ/π T(μo) T(μi)
//
// Along the tangent t the roughness is αt, along b = n × t it is αb (Heitz, Understanding the Masking-Shadowing Function, 2014):
//
//   D = 1 / (π αt αb (ht²/αt² + hb²/αb² + hn²)²),  G1(μ) = 2μ / (μ + s),  G2 = 2 μo μi / (μo si + μi so),
//   s² = αt² wt² + αb² wb² + μ²
//
// F is Schlick's Fresnel or that of the film over the same F0, T the share of light that passes: 1 less the reflectance of the
// dielectric, of the film its brightest channel (KHR_materials_iridescence). Reciprocal. One of the two lobes is sampled; the
// specular one by visible normals.
//
// Nothing cancels, for the reasons given in ggx.c: half vectors and normals stay unnormalised, split along t, b and n.
#include "bsdf/thin_film.h"

// What the functions below are compiled for: `stretch`: has the parameters of anisotropy, `film`: those of a film.
typedef struct FacetsOf
{
    bool stretch, film;
} FacetsOf;

// The arrays of lanes.
typedef struct FacetsIn
{
    RfGgxLanes ggx;
    RfLanes3 tangent; // this and the next: with stretch only
    const float* anisotropy;
    const float *film, *film_ior, *film_thickness; // with a film only
} FacetsIn;

RF_KERNEL FacetsIn facets_in( FacetsOf of, const RfBsdfLanes* lanes )
{
    const float* const* p = lanes->param;
    FacetsIn in = { .ggx = rf_ggx_lanes( lanes ) };
    if ( of.stretch )
    {
        in.tangent = rf_lanes3( p + RF_PARAM_TANGENT );
        in.anisotropy = p[RF_PARAM_ANISOTROPY];
    }
    if ( of.film )
    {
        in.film = p[RF_PARAM_FILM];
        in.film_ior = p[RF_PARAM_FILM_IOR];
        in.film_thickness = p[RF_PARAM_FILM_THICKNESS];
    }
    return in;
}

// At one angle: F, and T.
typedef struct Fresnel
{
    RfVec3 reflected;
    float passed;
} Fresnel;

RF_KERNEL Fresnel fresnel_at( FacetsOf of, const FacetsIn* in, int i, float cos_theta )
{
    float weight = rf_schlick_weight( cos_theta ), grazing = in->ggx.f90[i] * weight, rest = 1.0f - weight;
    RfVec3 specular = rf_at( in->ggx.specular, i );
    RfVec3 bare = rf_vec3( specular.x * rest + grazing, specular.y * rest + grazing, specular.z * rest + grazing );
    float f0 = in->ggx.coat_f0[i], lost = f0 + ( in->ggx.coat_f90[i] - f0 ) * weight;
    if ( !of.film )
        return ( Fresnel ){ bare, 1.0f - lost };
    float strength = rf_film_strength( in->film[i], in->film_thickness[i] );
    RfThinFilm film = rf_film_at( cos_theta, in->film_ior[i], in->film_thickness[i] );
    RfVec3 over = rf_film_over( film, specular );
    RfVec3 dielectric = rf_film_over( film, rf_vec3( f0, f0, f0 ) );
    float brightest = rf_max_component( dielectric );
    return ( Fresnel ){ rf_film_mix( bare, over, strength ), 1.0f - ( lost + ( brightest - lost ) * strength ) };
}

// The probability of sampling the specular lobe, from F and T of μo.
RF_KERNEL float specular_probability( Fresnel at_o, RfVec3 diffuse )
{
    float specular = rf_mean( at_o.reflected ), sum = specular + rf_mean( diffuse ) * at_o.passed;
    float ratio = specular / ( sum > 0.0f ? sum : 1.0f );
    return sum > 0.0f ? ratio : 1.0f;
}

// F of the half vector, T T / π, and the probability.
typedef struct ReflectedBlock
{
    float x[RF_BLOCK], y[RF_BLOCK], z[RF_BLOCK], base[RF_BLOCK], probability[RF_BLOCK];
} ReflectedBlock;

RF_KERNEL void reflect_block( FacetsOf of, int count, const FacetsIn* in, const RfEyeBlock* eyes, const float* const wi[3],
                              ReflectedBlock* restrict out )
{
    const FacetsIn given = *in;
    const RfLanes3 directions = rf_lanes3( wi );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfEyeLane eye = rf_eye_at( eyes, i );
        RfVec3 w = rf_at( directions, i ), half = rf_add( eye.wo, w );
        float cos_i = rf_maxf( rf_dot( rf_at( given.ggx.n, i ), w ), 0.0f );
        // wo · h = |wo + wi| / 2
        Fresnel at_h = fresnel_at( of, &given, i, 0.5f * sqrtf( rf_dot( half, half ) ) );
        Fresnel at_o = fresnel_at( of, &given, i, eye.cos_o );
        Fresnel at_i = fresnel_at( of, &given, i, cos_i );
        out->x[i] = at_h.reflected.x;
        out->y[i] = at_h.reflected.y;
        out->z[i] = at_h.reflected.z;
        out->base[i] = RF_INV_PI * ( at_o.passed * at_i.passed );
        out->probability[i] = specular_probability( at_o, rf_at( given.ggx.diffuse, i ) );
    }
}

// The tangents of a lane and the roughness along them.
typedef struct Stretch
{
    RfVec3 t, b;
    float alpha_t, alpha_b;
} Stretch;

RF_KERNEL Stretch stretch_at( FacetsOf of, const FacetsIn* in, int i, RfVec3 n )
{
    Stretch g = { .alpha_t = in->ggx.alpha[i], .alpha_b = in->ggx.alpha[i] };
    if ( !of.stretch )
    {
        rf_basis( n, &g.t, &g.b );
        return g;
    }
    g.t = rf_at( in->tangent, i );
    g.b = rf_cross( n, g.t );
    g.alpha_t += ( 1.0f - g.alpha_t ) * in->anisotropy[i] * in->anisotropy[i];
    return g;
}

RF_KERNEL void evaluate_block( FacetsOf of, int count, const FacetsIn* in, const RfEyeBlock* eyes,
                               const ReflectedBlock* reflected, const float* const wi[3], float* const f[3],
                               float* pdf_solid_angle )
{
    const FacetsIn given = *in;
    const RfLanes3 directions = rf_lanes3( wi );
    const RfLanesOut3 out = rf_lanes_out3( f );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfEyeLane eye = rf_eye_at( eyes, i );
        RfVec3 n = rf_at( given.ggx.n, i ), o = eye.wo, w = rf_at( directions, i ), half = rf_add( o, w );
        Stretch g = stretch_at( of, &given, i, n );
        float cos_o = eye.cos_o, dot_i = rf_dot( n, w ), cos_i = rf_maxf( dot_i, 0.0f ), along = cos_o + cos_i;
        float ht = rf_dot( half, g.t ), hb = rf_dot( half, g.b ), ht2 = ht * ht, hb2 = hb * hb;
        float product = g.alpha_t * g.alpha_b, ratio = g.alpha_b / g.alpha_t;
        float q = ( along * along + ht2 + hb2 ) / ( product * along * along + ratio * ht2 + hb2 / ratio );
        float d = product * RF_INV_PI * q * q;
        float ot = g.alpha_t * rf_dot( o, g.t ), ob = g.alpha_b * rf_dot( o, g.b );
        float it = g.alpha_t * rf_dot( w, g.t ), ib = g.alpha_b * rf_dot( w, g.b );
        float so = sqrtf( ot * ot + ob * ob + cos_o * cos_o ), si = sqrtf( it * it + ib * ib + dot_i * dot_i );
        float lit = dot_i > 0.0f ? 1.0f : 0.0f;
        float lobe = lit * 0.5f * d / ( cos_o * si + cos_i * so ), base = lit * reflected->base[i]; // D G2 / (4 μo μi)
        if ( f != NULL )
        {
            RfVec3 fresnel = rf_vec3( reflected->x[i], reflected->y[i], reflected->z[i] );
            rf_put( out, i, rf_madd( rf_scale( fresnel, lobe ), rf_at( given.ggx.diffuse, i ), base ) );
        }
        if ( pdf_solid_angle != NULL )
        {
            float probability = reflected->probability[i], visible = lit * 0.5f * d / ( cos_o + so ); // D G1(μo) / (4 μo)
            pdf_solid_angle[i] = probability * visible + ( 1.0f - probability ) * ( cos_i * RF_INV_PI );
        }
    }
}

RF_KERNEL void evaluate( FacetsOf of, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                         float* const f[3], float* pdf_solid_angle )
{
    RfEyeBlock eyes;
    ReflectedBlock reflected;
    FacetsIn in = facets_in( of, lanes );
    rf_lift_block( count, lanes->n, wo, &eyes );
    reflect_block( of, count, &in, &eyes, wi, &reflected );
    RF_FOR_OUTPUTS( evaluate_block, of, count, &in, &eyes, &reflected, wi );
}

// Separate loops, as in ggx.c: the azimuth φ = 2πu, by its cosine and sine; and the probability.
typedef struct DrawBlock
{
    float c[RF_BLOCK], s[RF_BLOCK], probability[RF_BLOCK];
} DrawBlock;

RF_KERNEL void draw_block( FacetsOf of, int count, const FacetsIn* in, const RfEyeBlock* eyes, const float* u,
                           DrawBlock* restrict draw )
{
    const FacetsIn given = *in;
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        rf_sincos_2pi( u[i], &draw->s[i], &draw->c[i] );
        Fresnel at_o = fresnel_at( of, &given, i, eyes->cos_o[i] );
        draw->probability[i] = specular_probability( at_o, rf_at( given.ggx.diffuse, i ) );
    }
}

// A visible normal by spherical caps (see ggx.c), in which all parts are sums and products of positive terms; or a direction of
// the base.
RF_KERNEL RfVec3 sample_lane( Stretch g, RfVec3 n, RfVec3 o, float cos_o, float c, float s, float u, bool is_specular )
{
    float ot = g.alpha_t * rf_dot( o, g.t ), ob = g.alpha_b * rf_dot( o, g.b ), across2 = ot * ot + ob * ob;
    float inverse = 1.0f / sqrtf( across2 + cos_o * cos_o ), one_plus_z = 1.0f + cos_o * inverse;
    float height = ( 1.0f - u ) * one_plus_z;
    float radius = sqrtf( u * ( height * one_plus_z + across2 * inverse * inverse ) );
    float ht = g.alpha_t * ( radius * c + ot * inverse ), hb = g.alpha_b * ( radius * s + ob * inverse );
    RfVec3 h = rf_madd( rf_madd( rf_scale( g.t, ht ), g.b, hb ), n, height );
    RfVec3 mirrored = rf_sub( rf_scale( h, 2.0f * rf_dot( o, h ) / rf_dot( h, h ) ), o );
    float around = sqrtf( u );
    RfVec3 base = rf_madd( rf_madd( rf_scale( g.t, around * c ), g.b, around * s ), n, sqrtf( 1.0f - u ) );
    return rf_choose( is_specular, mirrored, base );
}

RF_KERNEL void sample_block( FacetsOf of, int count, const FacetsIn* in, const RfEyeBlock* eyes, const DrawBlock* draw,
                             const float* const u[3], float* const wi[3] )
{
    const FacetsIn given = *in;
    const RfLanesOut3 out = rf_lanes_out3( wi );
    const float *u0 = u[0], *u2 = u[2];
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 n = rf_at( given.ggx.n, i );
        RfEyeLane eye = rf_eye_at( eyes, i );
        Stretch g = stretch_at( of, &given, i, n );
        rf_put( out, i, sample_lane( g, n, eye.wo, eye.cos_o, draw->c[i], draw->s[i], u0[i], u2[i] < draw->probability[i] ) );
    }
}

RF_KERNEL void sample( FacetsOf of, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                       float* const wi[3] )
{
    RfEyeBlock eyes;
    DrawBlock draw;
    FacetsIn in = facets_in( of, lanes );
    rf_lift_block( count, lanes->n, wo, &eyes );
    draw_block( of, count, &in, &eyes, u[1], &draw );
    sample_block( of, count, &in, &eyes, &draw, u, wi );
}

RF_MODEL_FUNCTIONS( anisotropic, ( ( FacetsOf ){ .stretch = true } ) )
RF_MODEL_FUNCTIONS( iridescent, ( ( FacetsOf ){ .film = true } ) )
RF_MODEL_FUNCTIONS( facets, ( ( FacetsOf ){ .stretch = true, .film = true } ) )
