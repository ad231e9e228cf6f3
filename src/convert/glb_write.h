// A model as binary glTF 2.0 (.glb), in the strict form that validators accept.
#ifndef REFRAME_CONVERT_GLB_WRITE_H
#define REFRAME_CONVERT_GLB_WRITE_H

#include "convert/model.h"
#include "image/atomic_file.h"

// Writes the file whole or not at all. A file that is there is replaced where
// `overwrite` says so and is RF_ERROR_IO else. A model that glTF cannot hold
// (indices out of range, coordinates that are not finite, more than 4 GiB) is
// RF_ERROR_FORMAT or RF_ERROR_UNSUPPORTED and names the part.
RfResult rf_write_glb( const char* path, const RfModel* model, bool overwrite, RfError* error );

// The same into an open file, which the caller commits or discards.
RfResult rf_append_glb( RfAtomicFile* file, const RfModel* model, RfError* error );

#endif
