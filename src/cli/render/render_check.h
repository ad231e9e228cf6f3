// reframe render --check: which frames are there.
#ifndef REFRAME_CLI_RENDER_RENDER_CHECK_H
#define REFRAME_CLI_RENDER_RENDER_CHECK_H

#include "cli/render/render_job.h"

// Looks at the file of every frame asked for: is it there, of this very render, and can all of it be read? Tells it, as JSON
// too, with the ranges that --nodes asks for. RF_ERROR_IO unless every frame is finished.
RfResult rf_check_render( RfRenderJob* job, RfError* error );

#endif
