// A look along the path before a render that is to reach a noise or a flicker: small pictures of a few groups, from which
// follows how much noisier some frames are than others. It foretells the time to the end (stop_ahead.h) and changes no picture.
#ifndef REFRAME_RENDER_AHEAD_H
#define REFRAME_RENDER_AHEAD_H

#include "render/renderer.h"

// Fills in r->ahead, before the render's memory is allocated. Where --memory has no room for it, r->ahead stays empty.
// Fails with RF_INTERRUPTED where the caller interrupts.
RfResult rf_look_ahead( RfRenderer* renderer, RfError* error );

#endif
