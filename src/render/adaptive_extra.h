// Internal to adaptive sampling: the samples of some tiles of a frame alone.
#ifndef REFRAME_RENDER_ADAPTIVE_EXTRA_H
#define REFRAME_RENDER_ADAPTIVE_EXTRA_H

#include "render/renderer.h"

// Adds the first `count` batches to the film of a frame.
void rf_accumulate_extra( RfRenderer* renderer, const RfPass* pass, RfLiveFilm* live, int count );

#endif
