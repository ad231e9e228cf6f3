// Adds traced batches to films, in their order, by all threads.
#ifndef REFRAME_RENDER_ACCUMULATION_H
#define REFRAME_RENDER_ACCUMULATION_H

#include "render/renderer.h"

typedef struct RfFilmRange
{
    RfLiveFilm* films; // those not in use, with frame −1, are left out
    int count;
} RfFilmRange;

// Adds memory.batches[first … first + count) of a pass to the films, with `worth` times the weight of the pass.
void rf_accumulate_batches( RfRenderer* renderer, const RfPass* pass, RfFilmRange films, float worth, int first, int count );

#endif
