// A pixel of a film in the two halves. For src/film only.
#ifndef REFRAME_FILM_FILM_PIXEL_H
#define REFRAME_FILM_FILM_PIXEL_H

#include "base/fault.h"
#include "film/film.h"

// Sums of one pixel in the two halves.
typedef struct RfFilmPixel
{
    double half[2][4];
    double weight[2];
} RfFilmPixel;

static inline RfFilmPixel rf_film_pixel( const RfFilm* film, size_t i )
{
    RfFilmPixel p = { .weight = { film->weight[0], film->weight[1] } };
    for ( int h = 0; h < 2; ++h )
    {
        p.weight[h] += film->extra[h] != NULL ? (double)film->extra[h][i] : 0.0;
        for ( size_t c = 0; c < 4; ++c )
            p.half[h][c] = (double)film->half[h][4 * i + c] + ( film->total[h] != NULL ? film->total[h][4 * i + c] : 0.0 );
    }
    return p;
}

// c_h = A_h / B_h; 0 where no sample landed.
static inline double rf_film_quotient( const double* half, int c )
{
    return half[3] > 0.0 || RF_FAULT( empty_half ) ? half[c] / half[3] : 0.0;
}

// The value of a pixel from one half alone.
static inline double rf_film_half_value( const RfFilmPixel* p, RfFilmCombine combine, int h, int c )
{
    const double* own = p->half[h];
    switch ( combine )
    {
        case RF_FILM_CROSSFIT:
            return ( own[c] + rf_film_quotient( p->half[1 - h], c ) * ( p->weight[h] - own[3] ) ) / p->weight[h];
        case RF_FILM_RATIO: return rf_film_quotient( own, c );
        case RF_FILM_PLAIN: return own[c] / p->weight[h];
    }
    return 0.0;
}

// With variance v per weight the halves differ by v (1/e + 1/o), the whole has
// v / (e + o): what the square of the difference is multiplied by. 0 where one
// of them is empty.
static inline double rf_film_half_share( const RfFilm* film )
{
    double e = film->weight[0], o = film->weight[1];
    return e > 0.0 && o > 0.0 ? e * o / ( ( e + o ) * ( e + o ) ) : 0.0;
}

#endif
