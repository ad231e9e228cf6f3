// Which channels of an EXR are its colour.
#ifndef REFRAME_IMAGE_EXR_CHANNELS_H
#define REFRAME_IMAGE_EXR_CHANNELS_H

#include "image/exr_stream.h"

typedef struct RfExrChannels
{
    const char* names[3]; // of red, green and blue, or of Y alone; owned by the context
    int count;            // 3, or 1 for Y
} RfExrChannels;

// R, G, B; else the layer P with P.R, P.G and P.B, where there is but one or but
// one whose name ends with "Combined"; else Y. Else an error names what is there.
RfResult rf_find_exr_channels( const RfExrStream* stream, const exr_attr_chlist_t* list, RfExrChannels* channels,
                               RfError* error );

// Fails, naming it, where a channel of this name is missing or subsampled.
RfResult rf_check_exr_channel( const RfExrStream* stream, const exr_attr_chlist_t* list, const char* name, RfError* error );

#endif
