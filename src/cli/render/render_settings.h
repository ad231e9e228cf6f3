// Reports settings that were changed when they were resolved.
#ifndef REFRAME_CLI_RENDER_RENDER_SETTINGS_H
#define REFRAME_CLI_RENDER_RENDER_SETTINGS_H

#include "reframe/render.h"

// Prints on standard error which settings differ from those asked for, on a path of
// `path_frames` frames.
void rf_tell_settings( const RfRenderSettings* asked, const RfRenderSettings* used, const RfMemoryFit* fit, int path_frames );

#endif
