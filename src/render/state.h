// The state of a render that is interrupted, or may be: the films of the frames in work, and where in the groups it stopped. A render that
// begins with it gives the same bits as one that was never interrupted (but with settings.time, which looks at a clock).
#ifndef REFRAME_RENDER_STATE_H
#define REFRAME_RENDER_STATE_H

#include "render/renderer.h"

// What it takes at most.
size_t rf_state_bytes( RfRenderer* renderer );

// Hands it to callbacks->save, piece by piece, after a chunk of batches, with all finished frames handed over. Fails as that does.
RfResult rf_save_state( RfRenderer* renderer, RfError* error );

// Takes it from callbacks->load, before the first group. Fails as that does, with RF_ERROR_USAGE for the state of other frames or
// settings, and with RF_ERROR_MEMORY where it holds the films of more frames than the budget.
RfResult rf_load_state( RfRenderer* renderer, RfError* error );

#endif
