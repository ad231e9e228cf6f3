// Passes of a group: batches traced in parallel, then accumulated into the films in order.
#ifndef REFRAME_RENDER_PASS_H
#define REFRAME_RENDER_PASS_H

#include "render/renderer.h"

// Room for the list of the jobs that a pass traces, if the settings have pieces; free r->traced_jobs.
RfResult rf_alloc_traced_jobs( RfRenderer* renderer, RfError* error );

// One pass from begin to end: chunks of as many batches as there is memory for, then extra samples. Reports progress after
// each chunk; fails with RF_ERROR_INTERRUPTED, or as the caller's callback does.
RfResult rf_render_pass( RfRenderer* renderer, const RfPass* pass, RfError* error );

// All passes of a group, likewise; where nothing ties a chunk to one pass, chunks go on with the next.
RfResult rf_render_passes( RfRenderer* renderer, const RfEstimatorGroup* estimator_group, const RfGroup* group, RfError* error );

#endif
