// Passes of a group: batches traced in parallel, then accumulated into the films in order.
#ifndef REFRAME_RENDER_PASS_H
#define REFRAME_RENDER_PASS_H

#include "render/renderer.h"

// Traces batches [first, first + count) of a pass into memory.batches[0 … count), and their AOVs.
void rf_trace_chunk( RfRenderer* renderer, const RfPass* pass, int first, int count );

// Adds memory.batches[0 … count) to the films of all frames of the group.
void rf_accumulate_chunk( RfRenderer* renderer, const RfPass* pass, int count );

// Before batches of a pass are traced: what they share.
void rf_prepare_pass( RfRenderer* renderer, const RfPass* pass );

// Around the chunks of a pass: clears what the estimator keeps per pass; traces extra samples and
// counts the pass.
void rf_begin_pass( RfRenderer* renderer );
void rf_end_pass( RfRenderer* renderer, const RfPass* pass );

// After all batches of a pass are traced: spreads what they left in the AOVs, where there is a pixel filter.
void rf_filter_aovs( RfRenderer* renderer, const RfPass* pass );

// After `count` batches: reports progress. Fails where the caller interrupts, or failed to take a frame.
RfResult rf_end_chunk( RfRenderer* renderer, int count, RfError* error );

// Room for the list of the jobs that a pass traces, if the settings have pieces; free r->traced_jobs.
RfResult rf_alloc_traced_jobs( RfRenderer* renderer, RfError* error );

// One pass from begin to end.
RfResult rf_render_pass( RfRenderer* renderer, const RfPass* pass, RfError* error );

#endif
