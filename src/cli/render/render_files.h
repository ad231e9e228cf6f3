// The files of a render: what is there already, what is in the way, and what --check reports of them.
#ifndef REFRAME_CLI_RENDER_RENDER_FILES_H
#define REFRAME_CLI_RENDER_RENDER_FILES_H

#include "cli/options/render_options.h"
#include "reframe/output.h"
#include "cli/render/render_command.h"

#include <jansson.h>

// Checks, before anything is rendered, that the pattern fits `count` frames
// (indices from 0), that the folder is there (its last part is made where it is
// missing) and can be written, and that no frame is in the way: an error
// without --resume or --overwrite. With --resume moves the frames that are there
// and of this very render from the list to `kept`, which has room for them all;
// one that is not of it is an error, or stays in the list with --overwrite; a damaged one stays in it and is warned of.
RfResult rf_prepare_output( const RfOutput* output, const RfRenderOptions* options, int* frames, int* count, int* kept,
                            RfLog* log, RfError* error );

// The films that an interrupted render left for the first of these frames: *films is their file, for --resume, or NULL where there
// are none. An error without --resume, and where they are of another render, unless with --overwrite: then they are not used.
// Films for other frames of the same render are not used, and warned of.
RfResult rf_find_films( RfFramesLeft* left, const RfRenderOptions* options, RfLog* log, FILE** films, RfError* error );

// The array "frames" in ascending order: the elements of `rendered` and one for each of the
// `count` kept frames (indices from 0). Figures of a kept frame come from its header, its seconds and specks
// from the older JSON at options->json where that describes the same file, else null. The caller
// owns the new array; NULL where memory ran out.
json_t* rf_join_kept_frames( const RfRenderJob* job );

// Looks at the file of every frame asked for: is it there, of this very render, and can all of it be read? Reports it, as JSON
// too, with the ranges that --nodes asks for. RF_ERROR_IO unless every frame is finished.
RfResult rf_check_render( RfRenderJob* job, RfError* error );

#endif
