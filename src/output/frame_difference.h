// What a frame that is there was rendered with, where that is not what is asked for.
#ifndef REFRAME_OUTPUT_FRAME_DIFFERENCE_H
#define REFRAME_OUTPUT_FRAME_DIFFERENCE_H

#include "reframe/output.h"

#define RF_MAX_DIFFERENCES 28
#define RF_DIFFERENCE_SIZE 256

typedef struct RfFrameDifference
{
    const char* name; // of the setting, "spp"; or "version", "frame", "frames" (of the path)
    char there[RF_DIFFERENCE_SIZE];
    char here[RF_DIFFERENCE_SIZE];
} RfFrameDifference;

// Lists the settings in which the file of frame `frame` (from 0) differs from `output`, as far as its
// header holds them; returns their number. 0: it is the scene or the camera path that differs.
int rf_list_frame_differences( const RfOutput* output, int frame, RfFrameDifference list[RF_MAX_DIFFERENCES] );

#endif
