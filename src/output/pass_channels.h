// The passes of a frame as channels of its file, with their names and conventions: the AOVs and the layers that only some renders have.
#ifndef REFRAME_OUTPUT_PASS_CHANNELS_H
#define REFRAME_OUTPUT_PASS_CHANNELS_H

#include "output/pass_names.h"
#include "reframe/render.h"

// A pass: some channels of the same pixels.
typedef struct RfPass
{
    const char* layer;   // its name, "depth"; NULL: the channels belong to the colour, as A does
    const char* letters; // of its channels
    const float* values; // as many floats a pixel as letters
    bool half;           // 16 bits are enough in a file
    bool zero[4];        // channels that are 0 whatever the values are
} RfPass;

// The channels of all passes of a frame but R, G, B. The values stay the frame's.
typedef struct RfPassChannels
{
    RfExrChannel channels[RF_EXR_MAX_CHANNELS];
    char names[RF_EXR_MAX_CHANNELS][RF_PASS_CHANNEL_SIZE];
    char parts[RF_EXR_MAX_CHANNELS][RF_PASS_CHANNEL_SIZE]; // the layers that they are channels of
    int count;
} RfPassChannels;

// Lists them as `files` asks for. Motion to the frame before and to the frame after is 0 where `still`. Fails with
// RF_ERROR_USAGE where there are more than a file can hold.
RfResult rf_list_pass_channels( const RfFrameResult* frame, const RfFrameFiles* files, const bool still[2], RfPassChannels* list,
                                RfError* error );

#endif
