// GGX with two roughnesses, a thin film, or both, over the Lambert base of ggx.c: the blocks of RF_BSDF_ANISOTROPIC,
// RF_BSDF_IRIDESCENT and the base of RF_BSDF_LAYERED.
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
#ifndef REFRAME_BSDF_FACETS_H
#define REFRAME_BSDF_FACETS_H

#include "bsdf/film.h"

// What the functions below are compiled for: `stretch`: has the parameters of anisotropy, `film`: those of a film.
typedef struct RfFacetsOf
{
    bool stretch, film;
} RfFacetsOf;

// The arrays of a block of lanes.
typedef struct RfFacetsIn
{
    const float *nx, *ny, *nz, *dx, *dy, *dz, *sx, *sy, *sz, *alpha, *f90, *coat_f0, *coat_f90;
    const float *tx, *ty, *tz, *anisotropy;        // NULL without stretch
    const float *film, *film_ior, *film_thickness; // NULL without a film
} RfFacetsIn;

static inline RfFacetsIn rf_facets_in( RfFacetsOf of, const RfBsdfLanes* lanes, int first )
{
    const float* const* p = lanes->param;
    RfFacetsIn in = {
        .nx = lanes->n[0] + first,
        .ny = lanes->n[1] + first,
        .nz = lanes->n[2] + first,
        .dx = p[RF_PARAM_DIFFUSE] + first,
        .dy = p[RF_PARAM_DIFFUSE + 1] + first,
        .dz = p[RF_PARAM_DIFFUSE + 2] + first,
        .sx = p[RF_PARAM_SPECULAR] + first,
        .sy = p[RF_PARAM_SPECULAR + 1] + first,
        .sz = p[RF_PARAM_SPECULAR + 2] + first,
        .alpha = p[RF_PARAM_SHAPE] + first,
        .f90 = p[RF_PARAM_F90] + first,
        .coat_f0 = p[RF_PARAM_COAT_F0] + first,
        .coat_f90 = p[RF_PARAM_COAT_F90] + first,
    };
    if ( of.stretch )
    {
        in.tx = p[RF_PARAM_TANGENT] + first;
        in.ty = p[RF_PARAM_TANGENT + 1] + first;
        in.tz = p[RF_PARAM_TANGENT + 2] + first;
        in.anisotropy = p[RF_PARAM_ANISOTROPY] + first;
    }
    if ( of.film )
    {
        in.film = p[RF_PARAM_FILM] + first;
        in.film_ior = p[RF_PARAM_FILM_IOR] + first;
        in.film_thickness = p[RF_PARAM_FILM_THICKNESS] + first;
    }
    return in;
}

// (1 − cos)⁵ of Schlick's Fresnel; rounding may have made the cosine exceed 1.
RF_KERNEL float rf_facets_weight( float cos_theta )
{
    float m = rf_maxf( 1.0f - cos_theta, 0.0f ), m2 = m * m;
    return m2 * m2 * m;
}

// At one angle: F, and T.
typedef struct RfFacetsFresnel
{
    RfVec3 reflected;
    float passed;
} RfFacetsFresnel;

RF_KERNEL RfFacetsFresnel rf_facets_fresnel( RfFacetsOf of, const RfFacetsIn* in, int i, float cos_theta )
{
    float weight = rf_facets_weight( cos_theta ), grazing = in->f90[i] * weight, rest = 1.0f - weight;
    RfVec3 bare = rf_vec3( in->sx[i] * rest + grazing, in->sy[i] * rest + grazing, in->sz[i] * rest + grazing );
    float lost = in->coat_f0[i] + ( in->coat_f90[i] - in->coat_f0[i] ) * weight;
    if ( !of.film )
        return ( RfFacetsFresnel ){ bare, 1.0f - lost };
    float strength = rf_film_strength( in->film[i], in->film_thickness[i] ), f0 = in->coat_f0[i];
    RfThinFilm film = rf_film_at( cos_theta, in->film_ior[i], in->film_thickness[i] );
    RfVec3 over = rf_film_over( film, rf_vec3( in->sx[i], in->sy[i], in->sz[i] ) );
    RfVec3 dielectric = rf_film_over( film, rf_vec3( f0, f0, f0 ) );
    float brightest = rf_max_component( dielectric );
    return ( RfFacetsFresnel ){ rf_film_mix( bare, over, strength ), 1.0f - ( lost + ( brightest - lost ) * strength ) };
}

// The probability of sampling the specular lobe, from F and T of μo.
RF_KERNEL float rf_facets_probability( RfFacetsFresnel at_o, RfVec3 diffuse )
{
    float specular = rf_mean( at_o.reflected ), sum = specular + rf_mean( diffuse ) * at_o.passed;
    float ratio = specular / ( sum > 0.0f ? sum : 1.0f );
    return sum > 0.0f ? ratio : 1.0f;
}

// F of the half vector, T T / π, and the probability.
typedef struct RfFacetsBlock
{
    float x[RF_BLOCK], y[RF_BLOCK], z[RF_BLOCK], base[RF_BLOCK], probability[RF_BLOCK];
} RfFacetsBlock;

RF_KERNEL void rf_facets_reflect_block( RfFacetsOf of, int count, const RfFacetsIn* in, const RfEyeBlock* eyes,
                                        const float* const wi[3], int first, RfFacetsBlock* restrict out )
{
    const float* restrict ix = wi[0] + first, * restrict iy = wi[1] + first, * restrict iz = wi[2] + first;
    const RfFacetsIn lanes = *in;
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 w = rf_vec3( ix[i], iy[i], iz[i] ), half = rf_add( rf_vec3( eyes->x[i], eyes->y[i], eyes->z[i] ), w );
        float cos_i = rf_maxf( rf_dot( rf_vec3( lanes.nx[i], lanes.ny[i], lanes.nz[i] ), w ), 0.0f );
        // wo · h = |wo + wi| / 2
        RfFacetsFresnel at_h = rf_facets_fresnel( of, &lanes, i, 0.5f * sqrtf( rf_dot( half, half ) ) );
        RfFacetsFresnel at_o = rf_facets_fresnel( of, &lanes, i, eyes->cos_o[i] );
        RfFacetsFresnel at_i = rf_facets_fresnel( of, &lanes, i, cos_i );
        out->x[i] = at_h.reflected.x;
        out->y[i] = at_h.reflected.y;
        out->z[i] = at_h.reflected.z;
        out->base[i] = RF_INV_PI * ( at_o.passed * at_i.passed );
        out->probability[i] = rf_facets_probability( at_o, rf_vec3( lanes.dx[i], lanes.dy[i], lanes.dz[i] ) );
    }
}

// The tangents of a lane and the roughness along them.
typedef struct RfStretch
{
    RfVec3 t, b;
    float alpha_t, alpha_b;
} RfStretch;

RF_KERNEL RfStretch rf_stretch_of_lane( RfFacetsOf of, const RfFacetsIn* in, int i, RfVec3 n )
{
    RfStretch g = { .alpha_t = in->alpha[i], .alpha_b = in->alpha[i] };
    if ( !of.stretch )
    {
        rf_basis( n, &g.t, &g.b );
        return g;
    }
    g.t = rf_vec3( in->tx[i], in->ty[i], in->tz[i] );
    g.b = rf_cross( n, g.t );
    g.alpha_t += ( 1.0f - g.alpha_t ) * in->anisotropy[i] * in->anisotropy[i];
    return g;
}

RF_KERNEL void rf_facets_block( RfFacetsOf of, int first, int count, const RfFacetsIn* in, const RfEyeBlock* eyes,
                                const RfFacetsBlock* reflected, const float* const wi[3], float* const f[3],
                                float* pdf_solid_angle )
{
    const float* restrict ix = wi[0] + first, * restrict iy = wi[1] + first, * restrict iz = wi[2] + first;
    float* restrict fx = f != NULL ? f[0] + first : NULL;
    float* restrict fy = f != NULL ? f[1] + first : NULL;
    float* restrict fz = f != NULL ? f[2] + first : NULL;
    float* restrict pdf = pdf_solid_angle != NULL ? pdf_solid_angle + first : NULL;
    const RfFacetsIn lanes = *in;
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 n = rf_vec3( lanes.nx[i], lanes.ny[i], lanes.nz[i] ), o = rf_vec3( eyes->x[i], eyes->y[i], eyes->z[i] );
        RfVec3 w = rf_vec3( ix[i], iy[i], iz[i] ), half = rf_add( o, w );
        RfStretch g = rf_stretch_of_lane( of, &lanes, i, n );
        float cos_o = eyes->cos_o[i], dot_i = rf_dot( n, w ), cos_i = rf_maxf( dot_i, 0.0f ), along = cos_o + cos_i;
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
            fx[i] = lobe * reflected->x[i] + base * lanes.dx[i];
            fy[i] = lobe * reflected->y[i] + base * lanes.dy[i];
            fz[i] = lobe * reflected->z[i] + base * lanes.dz[i];
        }
        if ( pdf != NULL )
        {
            float probability = reflected->probability[i], visible = lit * 0.5f * d / ( cos_o + so ); // D G1(μo) / (4 μo)
            pdf[i] = probability * visible + ( 1.0f - probability ) * ( cos_i * RF_INV_PI );
        }
    }
}

static inline __attribute__( ( always_inline ) ) void rf_facets_evaluate( RfFacetsOf of, int count, const RfBsdfLanes* lanes,
                                                                          const float* const wo[3], const float* const wi[3],
                                                                          float* const f[3], float* pdf_solid_angle )
{
    for ( int first = 0; first < count; first += RF_BLOCK )
    {
        RfEyeBlock eyes;
        RfFacetsBlock reflected;
        int size = rf_block_size( first, count );
        RfFacetsIn in = rf_facets_in( of, lanes, first );
        rf_lift_block( first, size, lanes, wo, &eyes );
        rf_facets_reflect_block( of, size, &in, &eyes, wi, first, &reflected );
        if ( f != NULL && pdf_solid_angle != NULL )
            rf_facets_block( of, first, size, &in, &eyes, &reflected, wi, f, pdf_solid_angle );
        else if ( f != NULL )
            rf_facets_block( of, first, size, &in, &eyes, &reflected, wi, f, NULL );
        else if ( pdf_solid_angle != NULL )
            rf_facets_block( of, first, size, &in, &eyes, &reflected, wi, NULL, pdf_solid_angle );
    }
}

// Separate loops, as in ggx.c: the azimuth φ = 2πu, by its cosine and sine; and the probability.
typedef struct RfFacetsDraw
{
    float c[RF_BLOCK], s[RF_BLOCK], probability[RF_BLOCK];
} RfFacetsDraw;

RF_KERNEL void rf_facets_draw_block( RfFacetsOf of, int count, const RfFacetsIn* in, const RfEyeBlock* eyes, const float* u,
                                     RfFacetsDraw* restrict draw )
{
    const RfFacetsIn lanes = *in;
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        rf_sincos_2pi( u[i], &draw->s[i], &draw->c[i] );
        RfFacetsFresnel at_o = rf_facets_fresnel( of, &lanes, i, eyes->cos_o[i] );
        draw->probability[i] = rf_facets_probability( at_o, rf_vec3( lanes.dx[i], lanes.dy[i], lanes.dz[i] ) );
    }
}

// A visible normal by spherical caps (see ggx.c), in which all parts are sums and products of positive terms; or a direction of
// the base.
RF_KERNEL RfVec3 rf_facets_sample_lane( RfStretch g, RfVec3 n, RfVec3 o, float cos_o, float c, float s, float u,
                                        bool is_specular )
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
    return rf_vec3( is_specular ? mirrored.x : base.x, is_specular ? mirrored.y : base.y, is_specular ? mirrored.z : base.z );
}

RF_KERNEL void rf_facets_sample_block( RfFacetsOf of, int first, int count, const RfFacetsIn* in, const RfEyeBlock* eyes,
                                       const RfFacetsDraw* draw, const float* const u[3], float* const wi[3] )
{
    const float* restrict u0 = u[0] + first, * restrict u2 = u[2] + first;
    float* restrict ix = wi[0] + first, * restrict iy = wi[1] + first, * restrict iz = wi[2] + first;
    const RfFacetsIn lanes = *in;
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 n = rf_vec3( lanes.nx[i], lanes.ny[i], lanes.nz[i] ), o = rf_vec3( eyes->x[i], eyes->y[i], eyes->z[i] );
        RfStretch g = rf_stretch_of_lane( of, &lanes, i, n );
        RfVec3 w = rf_facets_sample_lane( g, n, o, eyes->cos_o[i], draw->c[i], draw->s[i], u0[i], u2[i] < draw->probability[i] );
        ix[i] = w.x;
        iy[i] = w.y;
        iz[i] = w.z;
    }
}

static inline __attribute__( ( always_inline ) ) void rf_facets_sample( RfFacetsOf of, int count, const RfBsdfLanes* lanes,
                                                                        const float* const wo[3], const float* const u[3],
                                                                        float* const wi[3] )
{
    for ( int first = 0; first < count; first += RF_BLOCK )
    {
        RfEyeBlock eyes;
        RfFacetsDraw draw;
        int size = rf_block_size( first, count );
        RfFacetsIn in = rf_facets_in( of, lanes, first );
        rf_lift_block( first, size, lanes, wo, &eyes );
        rf_facets_draw_block( of, size, &in, &eyes, u[1] + first, &draw );
        rf_facets_sample_block( of, first, size, &in, &eyes, &draw, u, wi );
    }
}

#endif
