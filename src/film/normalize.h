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
static inline double rf_film_crossfit( const double half[2][4], const double weight[2], int c )
{
    double e = half[0][c] + rf_film_quotient( half[1], c ) * ( weight[0] - half[0][3] );
    double o = half[1][c] + rf_film_quotient( half[0], c ) * ( weight[1] - half[1][3] );
    return ( e + o ) / ( weight[0] + weight[1] );
}

static inline double rf_normalize_sums( const double half[2][4], const double weight[2], RfNormalize normalize, int c )
{
    double a = half[0][c] + half[1][c], b = half[0][3] + half[1][3];
    switch ( normalize )
    {
        case RF_NORMALIZE_CROSSFIT: return rf_film_crossfit( half, weight, c );
        case RF_NORMALIZE_RATIO: return b > 0.0 ? a / b : 0.0;
        case RF_NORMALIZE_NONE: return a / ( weight[0] + weight[1] );
    }
    return 0.0;
}

static inline double rf_normalize_half( const double half[2][4], const double weight[2], RfNormalize normalize, int h, int c )
{
    const double* own = half[h];
    switch ( normalize )
    {
        case RF_NORMALIZE_CROSSFIT: return ( own[c] + rf_film_quotient( half[1 - h], c ) * ( weight[h] - own[3] ) ) / weight[h];
        case RF_NORMALIZE_RATIO: return rf_film_quotient( own, c );
        case RF_NORMALIZE_NONE: return own[c] / weight[h];
    }
    return 0.0;
}

static inline bool rf_has_own( const RfFilmPixel* p, int c ) { return p->own[0][c] + p->own[1][c] > 0.0; }

// The value of a pixel.
static inline double rf_film_value( const RfFilmPixel* p, RfNormalize normalize, int c )
{
    double value = rf_normalize_sums( p->half, p->weight, normalize, c );
    return rf_has_own( p, c ) ? value + rf_normalize_sums( p->own, p->weight, normalize, c ) : value;
}

// The value from one half alone.
static inline double rf_film_half_value( const RfFilmPixel* p, RfNormalize normalize, int h, int c )
{
    double value = rf_normalize_half( p->half, p->weight, normalize, h, c );
    return rf_has_own( p, c ) ? value + rf_normalize_half( p->own, p->weight, normalize, h, c ) : value;
}

#endif
