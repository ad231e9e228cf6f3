// The AOVs of a frame as channels of its file.
#ifndef REFRAME_OUTPUT_FRAME_AOVS_H
#define REFRAME_OUTPUT_FRAME_AOVS_H

#include "reframe/render.h"

enum
{
#define RF_COUNT_LETTERS( constant, name, letters, half, first_hit, what ) +(int)sizeof( letters ) - 1
    RF_MAX_AOV_CHANNELS = 1 RF_AOV_LIST( RF_COUNT_LETTERS ) // and A
#undef RF_COUNT_LETTERS
};

#define RF_AOV_CHANNEL_NAME_SIZE 24 // "variance.R"

// The channels of a frame's AOVs, whose values stay the frame's. `names` holds their names.
typedef struct RfAovChannels
{
    RfExrChannel channels[RF_MAX_AOV_CHANNELS];
    char names[RF_MAX_AOV_CHANNELS][RF_AOV_CHANNEL_NAME_SIZE];
    int count;
} RfAovChannels;

// Lists them; those for which 16 bits are enough are written so where `half`. Motion to the frame before
// and to the frame after is 0 where `still`.
void rf_list_aov_channels( const RfFrameResult* frame, bool half, const bool still[2], RfAovChannels* list );

#endif
