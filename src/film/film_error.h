// What can be reported of a film's error without a reference, from its two halves: the relMSE of a frame, and the flicker of two
// neighbouring ones (src/reuse/estimators.md).
#ifndef REFRAME_FILM_FILM_ERROR_H
#define REFRAME_FILM_FILM_ERROR_H

#include "film/film.h"

#include <math.h>

// Pixels that stand out: each has more than RF_SPECK times the mean error of the others, and an error that can be seen. They are
// few, or there are none.
#define RF_SPECK 64.0
#define RF_LEAST_SPECK 1e-3 // part of a pixel in relMSE, times the pixels
#define RF_MOST_SPECKS 0.02 // of a film's pixels, or 10: more than that are noise

#define RF_LISTED_SPECKS 64

typedef struct RfSpeckList
{
    int pixels;   // all of them
    double share; // part of RfRelmse.likely that they carry
    double rest;  // the relMSE of the picture without them; NaN: unknown
    int count;    // of those below, the worst, in descending order
    struct
    {
        int pixel;       // row by row
        double share;    // of RfRelmse.likely
        double variance; // of the picture there, estimated, summed over the channels
    } worst[RF_LISTED_SPECKS];
} RfSpeckList;

// What can be reported of a film's relMSE.
typedef struct RfRelmse
{
    double likely;       // the best guess; NaN: unknown
    double least;        // what it is at least, if the worst pixels really are as bright as they are now
    double worst_share;  // part of `likely` that its ten worst pixels carry
    bool is_lower_bound; // `likely` hangs on these pixels, or on light that is rare: only `least` is certain
    RfSpeckList specks;
} RfRelmse;

// A figure that nothing more is known of.
static inline RfRelmse rf_plain_relmse( double relmse )
{
    return ( RfRelmse ){ .likely = relmse, .least = relmse, .specks.rest = relmse };
}

static inline double rf_reported_relmse( const RfRelmse* r ) { return r->is_lower_bound ? r->least : r->likely; }

// With what is only known to be a lower bound, 19 of 20 true errors are below so many times `likely`.
#define RF_RELMSE_DOUBT 2.0

// The figure to stop by: what the error hardly exceeds.
static inline double rf_prudent_relmse( const RfRelmse* r )
{
    return r->is_lower_bound ? RF_RELMSE_DOUBT * r->likely : r->likely;
}

// Estimated relMSE of `rgb`, the combined film, from the difference of the halves; NaN where one
// of them is empty. How often it holds is in src/render/README.md.
RfRelmse rf_estimate_relmse( const RfFilm* film, RfNormalize normalize, const float* rgb );

// The denominators of this estimate for all pixels, from a picture and its halves, of 3 floats per pixel, without what is added for
// light too rare to be seen by most pixels.
void rf_likely_denominators( int width, int height, const float* rgb, const float* half_a, const float* half_b, double* below );

// Estimated means over pixels and channels of e_t² of both frames and of the product of their errors, each divided by the mean of the
// denominators of their relMSE. What two frames share is in the product.
typedef struct RfFlicker
{
    double before, now, product; // NaN: unknown
    double worst_share;          // part of F1² that its ten worst pixels carry
} RfFlicker;

// Estimated error of the picture of a film, of a pixel 3 values and the denominator of its relMSE: of the right size and with the right
// correlation to that of another frame, with a sign that means nothing.
#define RF_KEPT_FLOATS 4
void rf_keep_film_error( const RfFilm* film, RfNormalize normalize, float* kept );

// The flicker of two films, or of what was kept of the film before and a film.
RfFlicker rf_flicker_of_films( const RfFilm* before, const RfFilm* now, RfNormalize normalize );
RfFlicker rf_flicker_since( const float* before, const RfFilm* now, RfNormalize normalize );

// The mean of e² alone.
double rf_film_mean_square( const RfFilm* film, RfNormalize normalize );

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
