// The files of a render: what is there already, and what is in the way.
#ifndef REFRAME_CLI_RENDER_RENDER_OUTPUT_H
#define REFRAME_CLI_RENDER_RENDER_OUTPUT_H

#include "cli/options/render_options.h"
#include "reframe/output.h"

// Checks, before anything is rendered, that the pattern fits `count` frames
// (indices from 0), that the folder is there (its last part is made where it is
// missing) and can be written, and that no frame is in the way: an error
// without --resume or --overwrite. With --resume moves the frames that are there
// and of this very render from the list to `kept`, which has room for them all;
// one that is not of it is an error, or stays in the list with --overwrite.
RfResult rf_prepare_output( const RfOutput* output, const RfRenderOptions* options, int* frames, int* count, int* kept,
                            RfError* error );

#endif
