// The data of the page, in the form that its script (src/page/assets) reads.
#ifndef REFRAME_CLI_REPORT_REPORT_COMMAND_H
#define REFRAME_CLI_REPORT_REPORT_COMMAND_H

#include "cli/report/report_frames.h"
#include "cli/options/options.h"
#include "cli/view/view_options.h"

typedef struct RfPageData
{
    const char* title;
    double fps, exposure;
    const int* numbers; // of the frames
    int count;
    const RfPageTrack* tracks;
    int track_count;
    bool has_reference;
    const json_t* cost;     // of --cost, or NULL
    const RfViewText* view; // how pictures are shown at first; without a transform: by the sRGB curve
} RfPageData;

// State of a run of `report`.

#define RF_PAGE_MOST_SEQUENCES 8 // on one page, without the reference

typedef struct RfPageRun
{
    const char* places[RF_PAGE_MOST_SEQUENCES];
    int place_count;
    const char* output;
    const char* reference; // this and the next may be NULL
    const char* layer;     // NULL: the colour
    const char* reference_layer;
    const char* cost_file;
    const char* render_file;
    const char* frame_list;
    const char* title;
    RfFps fps;
    RfViewOptions view;
    int width;     // 0: pictures as they are
    size_t values; // bytes of the page that scene values may take
    size_t passes; // bytes that pictures of passes may take
    bool overwrite, quiet;
    const char* json;

    RfPageSequence sequences[RF_PAGE_MOST_SEQUENCES + 1]; // the reference is the last
    RfPageTrack tracks[RF_PAGE_MOST_SEQUENCES + 1];
    RfViewText shown; // as chosen
    int sequence_count;
    json_t* cost;
    int* numbers; // of the page's frames
    int count;
    int* holes; // between them, that no sequence has
    int hole_count;
    int done, all;    // pictures
    char words[1024]; // a title of our own
} RfPageRun;

#endif
