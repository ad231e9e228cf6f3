// The frames that --resume keeps, in the result of the run that keeps them.
#ifndef REFRAME_CLI_RENDER_RENDER_KEPT_H
#define REFRAME_CLI_RENDER_RENDER_KEPT_H

#include "cli/options/render_options.h"

#include <jansson.h>

// The array "frames" in ascending order: the elements of `rendered` and one for each of the
// `count` kept frames (indices from 0). Figures of a kept frame come from its header, its seconds
// from the older JSON at options->json where that describes the same file, else null. The caller
// owns the new array; NULL where memory ran out.
json_t* rf_join_kept_frames( const RfRenderOptions* options, const RfCameraPath* path, const int* kept, int count,
                             json_t* rendered );

#endif
