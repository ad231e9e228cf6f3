// Is what was written what was to be written?
#ifndef REFRAME_IMAGE_EXR_VERIFY_H
#define REFRAME_IMAGE_EXR_VERIFY_H

#include "image/exr.h"
#include "image/exr_stream.h"

// Reads the stream's file back: the last guard against a library or a disk that
// lost something without saying so. `size` has the size of the channels.
RfResult rf_verify_exr( const RfExrStream* written, const RfExrChannel* channels, int count, const RfImage* size,
                        RfError* error );

#endif
