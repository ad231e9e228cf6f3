// Verifies a written EXR.
#ifndef REFRAME_IMAGE_EXR_VERIFY_H
#define REFRAME_IMAGE_EXR_VERIFY_H

#include "image/exr.h"
#include "image/exr_stream.h"

// Reads the file of the stream back and compares: the last defence against a library or a disk
// that lost data silently. `size` has the size of the channels.
RfResult rf_verify_exr( const RfExrStream* written, const RfExrChannel* channels, int count, const RfImage* size,
                        RfError* error );

#endif
