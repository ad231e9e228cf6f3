// Internal to this folder: selects the channels of an EXR, for colour or for a named layer.
#ifndef REFRAME_IMAGE_EXR_LAYER_H
#define REFRAME_IMAGE_EXR_LAYER_H

#include "image/exr_stream.h"

typedef struct RfExrChannels
{
    const char* names[3]; // red, green and blue, or Y alone; owned by the context
    int count;            // 3, or 1 for Y
} RfExrChannels;

// Finds the colour: R, G, B; else a layer P with P.R, P.G and P.B, if it is the only one or
// the only one whose name ends with "Combined"; else Y. Otherwise the error lists the channels
// or layers, `remedy` is that of several layers (RF_REMEDY_LAYER or none), and channels->count is their
// number.
RfResult rf_find_exr_channels( const RfExrStream* stream, const exr_attr_chlist_t* list, RfRemedy remedy, RfExrChannels* channels,
                               RfError* error );

// Opens the first part of a file that has the colour, or the channels named by `layer` (NULL:
// the colour), and finds them. Close with rf_close_exr_part after success.
RfResult rf_open_exr_layer( RfExrStream* stream, const char* layer, RfExrPart* part, RfExrChannels* channels, RfError* error );

// Fails if a channel of this name is missing or subsampled.
RfResult rf_check_exr_channel( const RfExrStream* stream, const exr_attr_chlist_t* list, const char* name, RfError* error );

#endif
