// A look along the path before a render that is to reach a noise or a flicker: small pictures of a few groups, from which
// follows how much noisier some frames are than others. It predicts the time to the end (stop_ahead.h) and changes no picture.
#ifndef REFRAME_RENDER_AHEAD_H
#define REFRAME_RENDER_AHEAD_H

#include "render/renderer.h"

// Fills in renderer->stop.ahead and allocates renderer->forecast, before the render's memory is allocated. Does nothing where
// no progress is reported; where the budget has no room or the pictures are tiny, stop.ahead stays empty.
// Fails with RF_INTERRUPTED where the caller interrupts.
RfResult rf_look_ahead( RfRenderer* renderer, RfError* error );

#endif
