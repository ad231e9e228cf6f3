// Input of `reframe report`: folders or patterns of sequences, and beside the frames the JSON of render, of one or of the tasks
// of several machines.
#ifndef REFRAME_CLI_REPORT_REPORT_INPUT_H
#define REFRAME_CLI_REPORT_REPORT_INPUT_H

#include "cli/options/frame_lists.h"
#include "image/exr.h"
#include "page/pass_groups.h"

#include <jansson.h>

typedef struct RfPageSequence
{
    char name[256];    // for people: the folder's name
    const char* layer; // as of rf_read_exr_layer; NULL: the colour
    char layer_text[RF_PASS_LAYER_SIZE];
    RfSequenceInput input;         // of a single file the frame 1
    char first[RF_FILE_NAME_SIZE]; // the file of its first frame
    bool is_reference;
    RfExrHeader header; // of the first file
    json_t* render;     // of `render --json`, or NULL
    json_t* plan;       // with the ranges that several machines render, or NULL
    json_t* progress;   // of these: { asked, finished, left: [numbers], tasks: [{ frames, count, finished }] }, or NULL
} RfPageSequence;

// Finds the only sequence of a folder, or the one that `place` names by #### or as a single file, and the JSON in its folder,
// recognised by its keys. rf_close_page_sequence in any case.
RfResult rf_open_page_sequence( const char* place, const char* layer, RfPageSequence* sequence, RfError* error );
void rf_close_page_sequence( RfPageSequence* sequence );

// Loads the JSON of `render` from a file that must hold it and replaces *json. `option` begins the error line.
RfResult rf_load_render_json( const char* path, const char* option, json_t** json, RfError* error );

// Is the frame there?
bool rf_has_page_frame( const RfPageSequence* sequence, int frame );

// What the page shows of the data window, in its pixels: what lies in the display window, without overscan; all where nothing does.
RfExrWindow rf_page_window( const RfExrHeader* header );

// An array of numbers as "3, 4, 8-12", truncated with "..." if too long. False where there are none.
bool rf_format_numbers( const json_t* numbers, char* text, size_t size );

// "4 of 8 frames are finished, missing 3, 6-8"; false where all are, or nothing is known of it (NULL).
#define RF_UNFINISHED_SIZE 320
bool rf_format_unfinished( const json_t* progress, char text[RF_UNFINISHED_SIZE] );

#endif
