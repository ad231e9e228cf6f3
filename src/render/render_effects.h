// Effects that this build lacks (base/built_in.h).
#ifndef REFRAME_RENDER_RENDER_EFFECTS_H
#define REFRAME_RENDER_RENDER_EFFECTS_H

#include "render/estimator.h"

// Refuses, by name, what a render calls for and the build has been made without.
RfResult rf_check_built( const RfShot* shot, const RfRenderSettings* settings, RfError* error );

#endif
