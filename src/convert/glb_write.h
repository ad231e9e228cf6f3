// Writes models as binary glTF 2.0 (.glb) that passes the glTF validator.
#ifndef REFRAME_CONVERT_GLB_WRITE_H
#define REFRAME_CONVERT_GLB_WRITE_H

#include "convert/model.h"
#include "image/atomic_file.h"

// Writes the file atomically. An existing file is replaced if `overwrite` is set, else
// the call fails with RF_ERROR_IO. A model that glTF cannot hold (indices out of range,
// coordinates that are not finite, more than 4 GiB) fails with RF_ERROR_FORMAT or
// RF_ERROR_UNSUPPORTED; the message names the part.
RfResult rf_write_glb( const char* path, const RfModel* model, bool overwrite, RfError* error );

// Appends the .glb to an open file, which the caller commits or discards.
RfResult rf_append_glb( RfAtomicFile* file, const RfModel* model, RfError* error );

#endif
