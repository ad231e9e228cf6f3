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

// The place of a channel's name among those found, or -1.
int rf_exr_channel_index( const RfExrChannels* channels, const char* name );

#endif
