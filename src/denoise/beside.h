// The mean of a frame and those beside it, along the motion.
#ifndef REFRAME_DENOISE_BESIDE_H
#define REFRAME_DENOISE_BESIDE_H

#include "reframe/denoise.h"

#include <stdbool.h>

// Is there a frame beside this one, and what is needed to find its pixels?
bool rf_has_frames_beside( const RfNoisyFrame* frame );

// The mean of the denoised halves of the frame and of those beside it, 3 floats per pixel, where they see the same surface; elsewhere of
// fewer, or the frame's own.
void rf_mean_along_motion( const RfNoisyFrame* frame, float* const own[2], float* along[2] );

#endif
