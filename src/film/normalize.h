// How the sums A and B of a pixel become its value (RfNormalize). Renders cross-fit; the ratio is also that of AOVs, and of the
// estimator of gradients; what is not divided is for comparison. This is done once for a picture and for each estimate of its
// error, not for samples.
#ifndef REFRAME_FILM_NORMALIZE_H
#define REFRAME_FILM_NORMALIZE_H

#include "base/fault.h"
#include "film/film.h"

// cᵒ_h = Aᵒ_h / Bᵒ_h; 0 where there is none.
static inline double rf_film_own_quotient( const RfFilmPixel* p, int h, int c )
{
    return p->own[h][3] > 0.0 ? p->own[h][c] / p->own[h][3] : 0.0;
}

// c_h = A_h / B_h, without the own-frame light of extra samples; 0 where no sample landed.
static inline double rf_film_quotient( const RfFilmPixel* p, int h, int c )
{
    double a = p->half[h][c] - p->extra[h] * rf_film_own_quotient( p, h, c ), b = p->half[h][3];
    return b > 0.0 || RF_FAULT( empty_half ) ? a / b : 0.0;
}

// A half of (E2) and (E16) in sums, n the weight of its passes: A_e + c_o (n_e − B_e). Where B is exactly n, as without reuse, this
// is A, bit for bit.
static inline double rf_film_crossfit_half( const RfFilmPixel* p, int h, int c )
{
    const double *sums = p->half[h], *own = p->own[h];
    return sums[c] + rf_film_quotient( p, 1 - h, c ) * ( p->weight[h] - sums[3] ) +
           ( own[c] + rf_film_own_quotient( p, 1 - h, c ) * ( p->weight[h] - p->extra[h] - own[3] ) );
}

// (A − e cᵒ) / B + cᵒ, with the weight e of extra samples.
static inline double rf_film_ratio( const RfFilmPixel* p, int c )
{
    double a = p->half[0][c] + p->half[1][c], b = p->half[0][3] + p->half[1][3], own_b = p->own[0][3] + p->own[1][3];
    double own = own_b > 0.0 ? ( p->own[0][c] + p->own[1][c] ) / own_b : 0.0;
    return b > 0.0 ? ( a - ( p->extra[0] + p->extra[1] ) * own ) / b + own : 0.0;
}

// The value of a pixel.
static inline double rf_film_value( const RfFilmPixel* p, RfNormalize normalize, int c )
{
    double n = p->weight[0] + p->weight[1];
    switch ( normalize )
    {
        case RF_NORMALIZE_CROSSFIT: return ( rf_film_crossfit_half( p, 0, c ) + rf_film_crossfit_half( p, 1, c ) ) / n;
        case RF_NORMALIZE_RATIO: return rf_film_ratio( p, c );
        case RF_NORMALIZE_NONE: return ( p->half[0][c] + p->half[1][c] + ( p->own[0][c] + p->own[1][c] ) ) / n;
    }
    return 0.0;
}

// The value from one half alone.
static inline double rf_film_half_value( const RfFilmPixel* p, RfNormalize normalize, int h, int c )
{
    switch ( normalize )
    {
        case RF_NORMALIZE_CROSSFIT: return rf_film_crossfit_half( p, h, c ) / p->weight[h];
        case RF_NORMALIZE_RATIO: return rf_film_quotient( p, h, c ) + rf_film_own_quotient( p, h, c );
        case RF_NORMALIZE_NONE: return ( p->half[h][c] + p->own[h][c] ) / p->weight[h];
    }
    return 0.0;
}

#endif
