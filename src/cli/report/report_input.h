// Input of `reframe report`: folders or patterns of sequences, and JSON of other commands
// found beside the frames.
#ifndef REFRAME_CLI_REPORT_REPORT_INPUT_H
#define REFRAME_CLI_REPORT_REPORT_INPUT_H

#include "image/exr.h"
#include "page/passes.h"

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#define RF_PAGE_NAME_SIZE 4096

typedef struct RfPageSequence
{
    char name[256];    // for people: the folder's name
    const char* layer; // as of rf_read_exr_layer; NULL: the colour
    char layer_text[RF_PASS_LAYER_SIZE];
    char pattern[RF_PAGE_NAME_SIZE]; // of its files
    int* frames;                     // that are there, ascending
    int frame_count;
    char first[RF_PAGE_NAME_SIZE]; // the file of the first of them
    bool is_reference;
    RfExrHeader header;                // of the first file
    json_t* render;                    // of `render --json`, or NULL
    json_t* plan;                      // with the ranges that several machines render, or NULL
    json_t* progress;                  // of these: frames finished and asked for, by task
    json_t* cost;                      // of `cost --json`, or NULL
    char cost_file[RF_PAGE_NAME_SIZE]; // where it was found
    char scene[RF_PAGE_NAME_SIZE];     // as the frames' header names it; empty: it does not
} RfPageSequence;

// Finds the only sequence of a folder, or the one that `place` names by #### or as a single file,
// and in its folder the JSON of render and cost, recognised by their keys. rf_close_page_sequence
// in any case.
RfResult rf_open_page_sequence( const char* place, const char* layer, RfPageSequence* sequence, RfError* error );
void rf_close_page_sequence( RfPageSequence* sequence );

// Loads the JSON of `render` or `cost` from a file that must hold it and replaces *json.
// `option` begins the error line.
RfResult rf_load_render_json( const char* path, const char* option, json_t** json, RfError* error );
RfResult rf_load_cost_json( const char* path, const char* option, json_t** json, RfError* error );

// True if two names are of the same scene: equal but for the folder. An empty one may be of any.
bool rf_is_same_scene( const char* a, const char* b );

// The scene that the JSON of `render` or `cost` names, or "".
const char* rf_scene_of_json( const json_t* json );

// Is the frame there?
bool rf_has_page_frame( const RfPageSequence* sequence, int frame );

// What the page shows of the data window, in its pixels: what lies in the display window, without overscan; all where nothing does.
RfExrWindow rf_page_window( const RfExrHeader* header );

// The file of a frame.
RfResult rf_page_frame_path( const RfPageSequence* sequence, int frame, char path[RF_PAGE_NAME_SIZE], RfError* error );

// A sequence that several machines render, as `reframe report` finds it: the ranges that `tune --nodes` cut, how far each
// is, and the JSON of the tasks as one.

// The numbers of its "left" as "3, 4, 8-12", truncated with "..." if too long.
void rf_format_left( const json_t* left, char* text, size_t size );

// Says on standard output what is not finished of a sequence, unless all is, or nothing is known of it (NULL).
void rf_tell_unfinished( const char* name, const json_t* progress );

// Appends rows to the facts of a page: how many frames are finished, which are not, and each task's share.
void rf_add_progress_facts( json_t* facts, const json_t* progress );

#endif
