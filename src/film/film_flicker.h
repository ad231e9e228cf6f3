// What can be reported of the flicker of two neighbouring frames from the halves of their films
// (src/reuse/estimators.md, section 17).
#ifndef REFRAME_FILM_FILM_FLICKER_H
#define REFRAME_FILM_FILM_FLICKER_H

#include "film/film.h"

#include <math.h>

// Estimated means over pixels and channels of e_t² of both frames and of the product of their errors. What two frames
// share is in the product.
typedef struct RfFlicker
{
    double before, now, product; // NaN: unknown
    double worst_share;          // part of F1² that its ten worst pixels carry
} RfFlicker;

// Estimated error of the picture of a film, 3 values per pixel: of the right size and with the right correlation to that
// of another frame, with a sign that means nothing.
void rf_keep_film_error( const RfFilm* film, RfFilmCombine combine, float* error );

// The flicker of two films, or of what was kept of the film before and a film.
RfFlicker rf_flicker_of_films( const RfFilm* before, const RfFilm* now, RfFilmCombine combine );
RfFlicker rf_flicker_since( const float* before, const RfFilm* now, RfFilmCombine combine );

// Mean square of the error of one film.
double rf_film_mean_square( const RfFilm* film, RfFilmCombine combine );

// F1² (E13).
static inline double rf_flicker_f1_squared( const RfFlicker* f ) { return f->before + f->now - 2.0 * f->product; }

// Does F1 hang on a few pixels? Then it is only known to be at least what the others make of it.
#define RF_FLICKER_AMBIGUOUS 0.3
static inline bool rf_flicker_is_lower_bound( const RfFlicker* f ) { return isgreater( f->worst_share, RF_FLICKER_AMBIGUOUS ); }

// F1² as it is reported, and to stop by: what it hardly exceeds.
static inline double rf_reported_flicker( const RfFlicker* f )
{
    return rf_flicker_f1_squared( f ) * ( rf_flicker_is_lower_bound( f ) ? 1.0 - f->worst_share : 1.0 );
}
static inline double rf_flicker_doubt( const RfFlicker* f ) { return rf_flicker_is_lower_bound( f ) ? RF_RELMSE_DOUBT : 1.0; }

#endif
