// A run of `report`: what was asked for, and the sequences of the page.
#ifndef REFRAME_CLI_REPORT_REPORT_COMMAND_H
#define REFRAME_CLI_REPORT_REPORT_COMMAND_H

#include "cli/options/options.h"
#include "cli/report/report_frames.h"
#include "cli/view/view_options.h"

#define RF_PAGE_MOST_SEQUENCES 8 // on one page, without the reference

typedef struct RfPageRun
{
    const char* places[RF_PAGE_MOST_SEQUENCES];
    int place_count;
    const char* output;
    const char* reference; // this and the next may be NULL
    const char* layer;     // NULL: the colour
    const char* reference_layer;
    const char* render_file;
    const char* frame_list;
    const char* title;
    RfFps fps;
    RfViewOptions view;
    size_t values; // bytes of the page that scene values may take
    size_t passes; // bytes that pictures of passes may take
    bool overwrite, quiet;
    const char* json;

    RfPageFrames page;
    RfPageSequence sequences[RF_PAGE_MOST_SEQUENCES + 1]; // the reference is the last
    RfPageTrack tracks[RF_PAGE_MOST_SEQUENCES + 1];
    int sequence_count;
    RfViewText shown;     // as chosen; without a transform: by the sRGB curve
    int done, all;        // pictures
    char own_title[1024]; // where none is given
} RfPageRun;

#endif
