// The films of a frame: its pixels, the differences of neighbours, and the squares of both, from which their
// variances are estimated. Then the picture that fits them best (E9).
#ifndef REFRAME_GRADIENT_GRADIENT_FILMS_H
#define REFRAME_GRADIENT_GRADIENT_FILMS_H

#include "film/aov_film.h"
#include "gradient/sampling.h"

enum
{
    RF_FILM_PRIMAL,                      // values
    RF_FILM_DX,                          // value of the pixel to the right minus that of the pixel
    RF_FILM_DY,                          // of the pixel below
    RF_FILM_SQUARES,                     // sums over the channels of the squares of these three
    RF_FILM_UNSHARED = RF_UNSHARED_FILM, // of the values, what tiles do not share: differences lack it
    RF_GRADIENT_FILMS,
};

// Adds batches to some rows of the films; returns how many samples landed there.
uint64_t rf_accumulate_gradients( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count );

#endif
