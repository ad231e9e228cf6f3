// Groups that are rendered until a noise, a flicker or a time is reached.
#ifndef REFRAME_RENDER_STOP_UNTIL_H
#define REFRAME_RENDER_STOP_UNTIL_H

#include "render/renderer.h"

// Renders the passes of a group, as many as settings.noise and settings.time want.
RfResult rf_render_until( RfRenderer* renderer, const RfEstimatorGroup* group, RfError* error );

#endif
