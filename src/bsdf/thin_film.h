// A thin film over a dielectric or metal: its Fresnel reflectance per channel (Belcour and Barla, A Practical Extension to
// Microfacet Theory for the Modeling of Varying Iridescence, 2017), as KHR_materials_iridescence simplifies it: Schlick's Fresnel
// at both interfaces, no polarisation, the base an index without extinction per channel, from its F0 in air.
#ifndef REFRAME_BSDF_THIN_FILM_H
#define REFRAME_BSDF_THIN_FILM_H

#include "bsdf/lane.h"

// Integrals over light of D65, per channel, of cos 2πσD, cos 4πσD and cos 6πσD: σ wavenumber, D difference of the paths.
typedef struct RfFilmWaves
{
    RfVec3 once, twice, thrice;
} RfFilmWaves;

// Adds a Gaussian in σ; mean and deviation in 1/µm. Angles are multiplied by recurrence, a Gaussian g becomes g^(m²).
RF_KERNEL void rf_add_film_band( RfFilmWaves* sum, float difference, float mean, float deviation, RfVec3 weight )
{
    float turns = mean * difference, spread = deviation * difference, sine, c;
    rf_sincos_2pi( turns - (float)(int32_t)turns, &sine, &c );
    float g = rf_exp2( -28.4776585f * spread * spread ), g2 = g * g, g4 = g2 * g2; // 2π² / ln 2
    sum->once = rf_madd( sum->once, weight, g * c );
    sum->twice = rf_madd( sum->twice, weight, g4 * ( 2.0f * c * c - 1.0f ) );
    sum->thrice = rf_madd( sum->thrice, weight, g4 * g4 * g * c * ( 4.0f * c * c - 3.0f ) );
}

// A sum of Gaussians whose weights per channel sum to 1: what has no interference keeps its colour. Fitted to the colour matching
// functions of Wyman et al. (2013), in linear Rec. 709, for D from 0 to 3 µm: at most 0.017, 0.005 and 0.003 off in R, G and B.
RF_KERNEL RfFilmWaves rf_film_waves( float difference )
{
    RfFilmWaves sum = { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f } };
    rf_add_film_band( &sum, difference, 1.662381f, 0.079411f, rf_vec3( 1.714018f, -0.267580f, -0.005567f ) );
    rf_add_film_band( &sum, difference, 1.813970f, 0.104462f, rf_vec3( -0.058239f, 0.947545f, -0.157114f ) );
    rf_add_film_band( &sum, difference, 1.911180f, 0.161799f, rf_vec3( -0.844121f, 0.486521f, 0.045936f ) );
    rf_add_film_band( &sum, difference, 2.208079f, 0.103287f, rf_vec3( 0.188343f, -0.166486f, 1.116745f ) );
    return sum;
}

// Both interfaces of a film, for light at one angle.
typedef struct RfFilmLayer
{
    float ior;
    float outer;  // reflectance from the air
    float weight; // Schlick's, inside
} RfFilmLayer;

// One channel: the sum over the reflections in the film, with three terms of interference. Factors of 0.9999 keep what total
// reflection divides by from 0.
RF_KERNEL float rf_film_channel( RfFilmLayer film, float f0, float once, float twice, float thrice )
{
    float s = sqrtf( 0.9999f * f0 );
    float index = ( 1.0f + s ) / ( 1.0f - s ), q = ( index - film.ior ) / ( index + film.ior ), inner = q * q;
    inner += ( 1.0f - inner ) * film.weight;
    float both = 0.9999f * film.outer * inner, amplitude = sqrtf( both ), through = 1.0f - film.outer;
    // a denser medium turns what it reflects by half a wave: at the outer interface no light from inside
    float step = index < film.ior ? amplitude : -amplitude;
    float direct = through * through * inner / ( 1.0f - both );
    float waves = step * ( once + step * ( twice + step * thrice ) );
    return rf_minf( rf_maxf( film.outer + direct + 2.0f * ( direct - through ) * waves, 0.0f ), 1.0f );
}

// A film as light at one angle meets it.
typedef struct RfThinFilm
{
    RfFilmLayer layer;
    RfFilmWaves waves;
} RfThinFilm;

// Of index `ior`, 1 to 100, and `thickness`, 0 to 1e5 nm, at this cosine in air, 0 to 1.
RF_KERNEL RfThinFilm rf_film_at( float cos_theta, float ior, float thickness )
{
    float m = rf_maxf( 1.0f - cos_theta, 0.0f ), m2 = m * m; // rounding may have made the cosine exceed 1
    float cos_inside = sqrtf( 1.0f - m * ( 2.0f - m ) / ( ior * ior ) );
    float k = 1.0f - cos_inside, k2 = k * k, root = ( ior - 1.0f ) / ( ior + 1.0f ), outer = root * root;
    return ( RfThinFilm ){ { ior, outer + ( 1.0f - outer ) * ( m2 * m2 * m ), k2 * k2 * k },
                           rf_film_waves( 2e-3f * ior * thickness * cos_inside ) }; // µm
}

// The reflectance over a base of F0 `f0` in air, 0 to 1 per channel.
RF_KERNEL RfVec3 rf_film_over( RfThinFilm film, RfVec3 f0 )
{
    RfFilmWaves w = film.waves;
    return rf_vec3( rf_film_channel( film.layer, f0.x, w.once.x, w.twice.x, w.thrice.x ),
                    rf_film_channel( film.layer, f0.y, w.once.y, w.twice.y, w.thrice.y ),
                    rf_film_channel( film.layer, f0.z, w.once.z, w.twice.z, w.thrice.z ) );
}

// Both at once. From inside the base it is the same at the angle that is refracted into the air.
RF_KERNEL RfVec3 rf_film_fresnel( RfVec3 f0, float cos_theta, float ior, float thickness )
{
    return rf_film_over( rf_film_at( cos_theta, ior, thickness ), f0 );
}

// The strength of a film by its factor: where it has no thickness, there is none.
RF_KERNEL float rf_film_strength( float factor, float thickness ) { return factor * rf_minf( rf_maxf( thickness, 0.0f ), 1.0f ); }

// Schlick's Fresnel `bare` where there is no film, that of the film where its strength is 1.
RF_KERNEL RfVec3 rf_film_mix( RfVec3 bare, RfVec3 film, float strength )
{
    return rf_madd( rf_scale( bare, 1.0f - strength ), film, strength );
}

#endif
