// Internal to adaptive sampling: extra samples for glints, which are few pixels and most of a picture's error.
#ifndef REFRAME_RENDER_ADAPTIVE_GLINT_PILOT_H
#define REFRAME_RENDER_ADAPTIVE_GLINT_PILOT_H

#include "render/renderer.h"

// Extra samples of a pixel in a pass, at most.
#define RF_MOST_GLINTS 64
// With fewer samples of a frame the pilot costs more than a hundredth of it; `auto` leaves it out.
#define RF_LEAST_GLINT_SPP 12

// Fills live->glints and live->most_glints of a frame whose film has just been cleared; `worth`: of an extra sample beside one of
// a pass.
void rf_find_glints( RfRenderer* renderer, RfLiveFilm* live, double worth );

// From the sums of the pilot (RfEstimator.add_glints), four for each of `pixels`, to extra samples per pixel in a pass. Returns the
// most; 0: none pay. `reach`: samples that a pass brings to a pixel.
float rf_set_glints( const float* sums, size_t pixels, double reach, double worth, float* extra );

#endif
