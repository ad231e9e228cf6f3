// The layers of --aov: their list, and their channels in a file.
#ifndef REFRAME_CLI_LAYER_LIST_H
#define REFRAME_CLI_LAYER_LIST_H

#include "image/exr.h"
#include "reuse/render.h"

#include <stddef.h>

#define RF_MAX_LAYER_CHANNELS 32

// "albedo,depth" to RF_LAYER_BITs; NULL is none. Fails with RF_ERROR_USAGE,
// naming the word that is no layer or comes twice.
RfResult rf_parse_layers( const char* text, unsigned* layers, RfError* error );

// "albedo,depth", in the order of RfLayer.
void rf_format_layers( unsigned layers, char* text, size_t size );

// The channels of a frame's layers, which stay the frame's. `names` holds their
// names. Colour-like ones (albedo, normal) are half where `half`, all others
// need the range or the precision of 32 bits.
typedef struct RfLayerChannels
{
    RfExrChannel channels[RF_MAX_LAYER_CHANNELS];
    char names[RF_MAX_LAYER_CHANNELS][24];
    int count;
} RfLayerChannels;

void rf_list_layer_channels( const RfFrameResult* result, bool half, RfLayerChannels* list );

#endif
