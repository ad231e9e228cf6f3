// The picture of a frame, from its films.
#ifndef REFRAME_GRADIENT_PICTURE_H
#define REFRAME_GRADIENT_PICTURE_H

#include "render/estimator.h"

// Bytes that rf_finish_gradients works in.
size_t rf_finish_gradients_bytes( const RfRenderSettings* settings, int width, int height );

// RfEstimator.finish: the reconstruction that the settings ask for.
RfRelmse rf_finish_gradients( const RfRenderSettings* settings, const RfFilm* films, RfPicture* picture, void* scratch );

#endif
