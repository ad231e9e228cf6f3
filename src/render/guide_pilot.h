// Decides whether paths are guided, and learns the guide.
#ifndef REFRAME_RENDER_GUIDE_PILOT_H
#define REFRAME_RENDER_GUIDE_PILOT_H

#include "render/renderer.h"

// With RF_GUIDE_AUTO, sets renderer->guide where a pilot tells that it pays. It depends on the scene, the path of the camera and the
// settings alone, never on the frames that are asked for. Fails with RF_ERROR_MEMORY, or as rf_check_worlds.
RfResult rf_find_guide( RfRenderer* renderer, RfError* error );

#endif
