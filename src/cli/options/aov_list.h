// The layers of --aov: their list, and their channels in a file.
#ifndef REFRAME_CLI_OPTIONS_AOV_LIST_H
#define REFRAME_CLI_OPTIONS_AOV_LIST_H

#include "image/exr.h"
#include "reframe/render.h"

#include <stddef.h>

#define RF_MAX_AOV_CHANNELS 32

// "albedo,depth" to RF_AOV_BITs; NULL is none. Fails with RF_ERROR_USAGE,
// naming the word that is no layer or comes twice.
RfResult rf_parse_aovs( const char* text, unsigned* layers, RfError* error );

// "albedo,depth", in the order of RfAov.
void rf_format_aovs( unsigned layers, char* text, size_t size );

// The channels of a frame's layers, which stay the frame's. `names` holds their
// names. Colour-like ones (albedo, normal) are half where `half`, all others
// need the range or the precision of 32 bits.
typedef struct RfAovChannels
{
    RfExrChannel channels[RF_MAX_AOV_CHANNELS];
    char names[RF_MAX_AOV_CHANNELS][24];
    int count;
} RfAovChannels;

void rf_list_aov_channels( const RfFrameResult* result, bool half, RfAovChannels* list );

#endif
