// What glass with dispersion or a thin film has of its own, by channel of light: the indices of refraction, Fresnel's reflectance,
// and the channels that a path carries.
#ifndef REFRAME_BSDF_SPECTRUM_H
#define REFRAME_BSDF_SPECTRUM_H

#include "bsdf/thin_film.h"
#include "bsdf/lane.h"

typedef struct RfSpectrum
{
    float ior[3];   // of the far side over the near one
    float share[3]; // of the channels in the light that the path carries; their sum is 1
    float film, film_ior, film_thickness;
    bool splits; // the channels refract differently
} RfSpectrum;

// The channels' indices over that of the outside, 1: three wavelengths on the straight line through the index at the Fraunhofer d
// line, red and blue each half of nF − nC = (nd − 1) / V from green (KHR_materials_dispersion, implementation). dispersion: 20 / V.
static inline void rf_disperse( float ior, float dispersion, float out[3] )
{
    float half = ( ior - 1.0f ) * 0.025f * dispersion;
    out[0] = rf_maxf( ior - half, 1.0f );
    out[1] = ior;
    out[2] = ior + half;
}

// As rf_pack_channels has them; their sum is 1.
static inline void rf_unpack_channels( float code, float share[3] )
{
    int bits = (int)code, channel[3] = { bits & 255, bits >> 8 & 255, bits >> 16 & 255 },
        sum = channel[0] + channel[1] + channel[2];
    for ( int c = 0; c < 3; ++c )
        share[c] = sum > 0 ? (float)channel[c] / (float)sum : 1.0f / 3.0f;
}

// `ior` as RF_PARAM_IOR has it: of the far side over the near one. Thin walls do not refract, and panes must not depend on the path
// that comes to them.
static inline RfSpectrum rf_make_spectrum( float ior, float dispersion, float film, float film_ior, float film_thickness,
                                           float choice )
{
    RfSpectrum s = { .film = rf_film_strength( film, film_thickness ), .film_ior = film_ior, .film_thickness = film_thickness };
    bool inside = ior > 0.0f && ior < 1.0f;
    s.splits = dispersion > 0.0f && ior > 0.0f;
    rf_disperse( inside ? 1.0f / ior : fabsf( ior ), s.splits ? dispersion : 0.0f, s.ior );
    for ( int c = 0; c < 3 && inside; ++c )
        s.ior[c] = 1.0f / s.ior[c];
    rf_unpack_channels( ior > 0.0f ? choice : 0.0f, s.share );
    return s;
}

static inline float rf_mean_carried( const RfSpectrum* s, RfVec3 c )
{
    return s->share[0] * c.x + s->share[1] * c.y + s->share[2] * c.z;
}

// The channel that refraction goes on with, of those that are carried and transmitted, and the probability of that: 0 if there is
// none. `u` is uniform in [0, 1).
static inline int rf_draw_channel( const RfSpectrum* s, RfVec3 transmitted, float u, float* probability )
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

#endif
