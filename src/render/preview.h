// The picture of the frame in work, for callbacks->preview.
#ifndef REFRAME_RENDER_PREVIEW_H
#define REFRAME_RENDER_PREVIEW_H

#include "render/renderer.h"

// After a pass: hands the picture over if the caller wants it, and it is time for one.
void rf_show_preview( RfRenderer* renderer );

#endif
