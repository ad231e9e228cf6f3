// A group of frames: its passes, whose batches are traced in parallel and then accumulated into the films in order.
#ifndef REFRAME_RENDER_PASS_H
#define REFRAME_RENDER_PASS_H

#include "render/renderer.h"

// Room for the list of the jobs that a pass traces, if the settings have pieces; free r->traced_jobs.
RfResult rf_alloc_traced_jobs( RfRenderer* renderer, RfError* error );

// Renders group `number`, or goes on with it, and hands over the frames that it finishes. Reports progress after each chunk of
// batches; fails with RF_ERROR_INTERRUPTED, or as the caller's callback does.
RfResult rf_render_group( RfRenderer* renderer, int number, RfError* error );

#endif
