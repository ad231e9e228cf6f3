// State of a run of `flicker`.
#ifndef REFRAME_CLI_COMPARE_FLICKER_RUN_H
#define REFRAME_CLI_COMPARE_FLICKER_RUN_H

#include "cli/compare/flicker_report.h"
#include "cli/compare/flicker_seams.h"
#include "measure/flicker_read.h"
#include "measure/slit_scan.h"

#define RF_FLICKER_NAME_SIZE 4096

typedef struct RfFlickerRun
{
    const char* pattern;
    const char* reference; // this and the next five may be NULL
    const char* layer;     // NULL: the colour
    const char* reference_layer;
    const char* frame_list;
    const char* motion;
    const char* depth;
    bool compensate, compensate_given;
    int period; // of --border; 0: from the files
    bool spectrum;
    const char* png; // or NULL
    int column;      // 0: the middle
    bool column_given;
    double exposure;
    bool exposure_given;
    const char* json; // or NULL
    bool quiet;
    bool table; // standard output is free for the table

    int* frames;
    int frame_count;
    int first_frame; // of the whole sequence
    char first_path[RF_FLICKER_NAME_SIZE];
    RfExrHeader header;     // of the first frame
    RfExrHeader layered;    // of the first that has motion layers, or of the first; the layers' names lie there
    RfFlickerLayers layers; // that are read
    RfSeams seams;
    RfFlickerFrame ring[RF_SPECTRUM_FRAMES]; // frame i at i modulo the number of them
    int ring_size;
    RfErrorSummary errors;
    RfSlitScan slit;
    RfFlickerReport report;
} RfFlickerRun;

// The file of a frame.
RfResult rf_flicker_path( const char* pattern, int frame, char path[RF_FLICKER_NAME_SIZE], RfError* error );

// Lists the frames: at least two, consecutive, all in the reference too.
RfResult rf_find_flicker_frames( RfFlickerRun* flicker, RfError* error );

// Chooses layers from the header of the first frame. Against a reference, motion is also followed
// in additional figures, where any frame has it.
RfResult rf_find_layers_to_read( RfFlickerRun* flicker, RfError* error );

// Groups, the window of the spectrum and the slit-scan, by the frames found.
RfResult rf_prepare_flicker( RfFlickerRun* flicker, RfError* error );

// Measures all frames and writes what is asked for.
RfResult rf_go_through_frames( RfFlickerRun* flicker, RfError* error );

#endif
