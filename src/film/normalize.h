// How the sums A and B of a pixel become its value (RfNormalize). Renders cross-fit; the ratio is also that of AOVs, and of the
// estimator of gradients; what is not divided is for comparison. This is done once for a picture and for each estimate of its
// error, not for samples.
#ifndef REFRAME_FILM_NORMALIZE_H
#define REFRAME_FILM_NORMALIZE_H

#include "base/fault.h"
#include "film/film.h"

// c_h = A_h / B_h; 0 where no sample landed.
static inline double rf_film_quotient( const double* half, int c )
{
    return half[3] > 0.0 || RF_FAULT( empty_half ) ? half[c] / half[3] : 0.0;
}

// (E2) in sums, n the weights of a half's passes: [ A_e + c_o (n_e − B_e) + A_o + c_e (n_o − B_o) ] / (n_e + n_o).
// Where B is exactly n, as without reuse, this is the plain mean, bit for bit.
static inline double rf_film_crossfit( const RfFilmPixel* p, int c )
{
    double e = p->half[0][c] + rf_film_quotient( p->half[1], c ) * ( p->weight[0] - p->half[0][3] );
    double o = p->half[1][c] + rf_film_quotient( p->half[0], c ) * ( p->weight[1] - p->half[1][3] );
    return ( e + o ) / ( p->weight[0] + p->weight[1] );
}

// The value of a pixel.
static inline double rf_film_value( const RfFilmPixel* p, RfNormalize normalize, int c )
{
    double a = p->half[0][c] + p->half[1][c], b = p->half[0][3] + p->half[1][3];
    switch ( normalize )
    {
        case RF_NORMALIZE_CROSSFIT: return rf_film_crossfit( p, c );
        case RF_NORMALIZE_RATIO: return b > 0.0 ? a / b : 0.0;
        case RF_NORMALIZE_NONE: return a / ( p->weight[0] + p->weight[1] );
    }
    return 0.0;
}

// The value from one half alone.
static inline double rf_film_half_value( const RfFilmPixel* p, RfNormalize normalize, int h, int c )
{
    const double* own = p->half[h];
    switch ( normalize )
    {
        case RF_NORMALIZE_CROSSFIT:
            return ( own[c] + rf_film_quotient( p->half[1 - h], c ) * ( p->weight[h] - own[3] ) ) / p->weight[h];
        case RF_NORMALIZE_RATIO: return rf_film_quotient( own, c );
        case RF_NORMALIZE_NONE: return own[c] / p->weight[h];
    }
    return 0.0;
}

#endif
