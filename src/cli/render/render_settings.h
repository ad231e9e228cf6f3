// What a render does otherwise than asked.
#ifndef REFRAME_CLI_RENDER_RENDER_SETTINGS_H
#define REFRAME_CLI_RENDER_RENDER_SETTINGS_H

#include "reframe/render.h"

// Says on standard error what was resolved otherwise than asked, where it is worth
// a word. The path has so many frames.
void rf_tell_settings( const RfRenderSettings* asked, const RfRenderSettings* used, const RfMemoryFit* fit, int path_frames );

#endif
