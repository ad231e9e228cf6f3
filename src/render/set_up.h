// What a render does before its first pass.
#ifndef REFRAME_RENDER_SET_UP_H
#define REFRAME_RENDER_SET_UP_H

#include "render/renderer.h"

// Frames, groups and sizes, as the resolved settings have them. Fails with RF_ERROR_MEMORY where no render fits the budget.
RfResult rf_set_up_render( RfRenderer* renderer, int eye_count, RfError* error );

// The memory of a render that is set up; what was allocated before a failure is freed as after a render.
RfResult rf_alloc_render( RfRenderer* renderer, RfError* error );

#endif
