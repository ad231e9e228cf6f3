// The frames that --resume keeps, in the result of the run that keeps them.
#ifndef REFRAME_CLI_RENDER_RENDER_KEPT_H
#define REFRAME_CLI_RENDER_RENDER_KEPT_H

#include "cli/options/render_options.h"

#include <jansson.h>

// "frames" with both: the elements of `rendered` and one for each of the `count`
// frames kept (indices from 0), each of the two in ascending order, together
// too. What is told of a kept frame is from its file's header, its seconds from
// the older JSON at options->json where that tells of the same frame, else null.
// A new array; NULL where memory ran out.
json_t* rf_join_kept_frames( const RfRenderOptions* options, const int* kept, int count, json_t* rendered );

#endif
