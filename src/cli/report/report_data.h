// The data of the page, in the form that its script (src/page/assets) reads.
#ifndef REFRAME_CLI_REPORT_REPORT_DATA_H
#define REFRAME_CLI_REPORT_REPORT_DATA_H

#include "cli/report/report_frames.h"

typedef struct RfPageData
{
    const char* title;
    double fps, exposure;
    const int* numbers; // of the frames
    int count;
    const RfPageTrack* tracks;
    int track_count;
    bool has_reference;
    const json_t* cost; // of --cost, or NULL
} RfPageData;

// NULL where memory ran out.
json_t* rf_page_data_json( const RfPageData* data );

// What `report --json` writes.
json_t* rf_page_result_json( const RfPageData* data, const char* output, uint64_t bytes );

#endif
