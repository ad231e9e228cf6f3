// The films of a frame: its pixels, the differences of neighbours, and the squares of both, from which their
// variances are estimated; and the picture that fits them best (E9).
#ifndef REFRAME_GRADIENT_FILMS_H
#define REFRAME_GRADIENT_FILMS_H

#include "film/aov.h"
#include "gradient/sampling.h"
#include "render/estimator.h"

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

// Bytes of the workspace of rf_finish_gradients.
size_t rf_finish_gradients_bytes( const RfRenderSettings* settings, int width, int height );

// RfEstimator.finish: the reconstruction that the settings ask for.
RfRelmse rf_finish_gradients( const RfRenderSettings* settings, const RfFilm* films, RfPicture* picture, void* scratch );

#endif
