// Pixels whose values are beyond the range of their channels in the files of a render.
#ifndef REFRAME_CLI_RENDER_CLIPPED_PIXELS_H
#define REFRAME_CLI_RENDER_CLIPPED_PIXELS_H

#include "cli/render/render_command.h"

#include <jansson.h>

// Adds "clipped_pixels" of the file of frame `number`, as its header says, and if there are any "clipped_layers".
void rf_add_clipped( const char* pattern, int number, json_t* row );

// The sum of "clipped_pixels" over the frames.
json_t* rf_sum_clipped( const json_t* frames );

// Warns of them, in the frames that were rendered and those that were kept.
void rf_warn_of_clipped( RfRenderJob* job );

#endif
