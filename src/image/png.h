// PNG in memory, for pictures that are made again and again.
#ifndef REFRAME_IMAGE_PNG_H
#define REFRAME_IMAGE_PNG_H

#include "reframe/image.h"

#include <stddef.h>

// What rf_write_png writes at exposure 0, compressed less and in a small part of the time. The caller frees *bytes, NULL on
// failure; `name` begins the message. Fails with RF_ERROR_MEMORY.
RfResult rf_encode_png( const char* name, const RfImage* image, unsigned char** bytes, size_t* size, RfError* error );

#endif
