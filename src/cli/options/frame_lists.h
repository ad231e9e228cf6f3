// Frames: lists of them, sequences of files, and the ranges that several machines render.
#ifndef REFRAME_CLI_OPTIONS_FRAME_LISTS_H
#define REFRAME_CLI_OPTIONS_FRAME_LISTS_H

#include "reframe/camera.h"
#include "reframe/error.h"
#include "reframe/plan.h"
#include "scene_file/scene_file.h"

#include <jansson.h>

// Lists of frames: "A", "A-B", "A-BxSTEP", with commas between them. Negative numbers count from the end, "-5--1", unless the
// range begins with '@': "@-3-3" are those that have these numbers.

// Parses the frames that `text` names of a sequence that has those `there`, at least one and ascending: *count numbers, from 1 or
// the first of it to the last, ascending, each once; the caller frees them. NULL text: all of these.
RfResult rf_parse_frames( const char* text, const int* there, int there_count, int** frames, int* count, RfError* error );

// The frames of a camera path, as indices from 0, for text from the command line or
// from the scene file; in the latter case errors name the file. Of a path in steps, A-B are the frames in between.
RfResult rf_choose_frames( const char* text, const RfSceneFile* file, const RfCameraPath* path, int** frames, int* count,
                           RfError* error );

// What a command reads frame by frame: a file, a sequence named with ####, or the folder of one.

#define RF_FILE_NAME_SIZE 4096

typedef struct RfSequenceInput
{
    char pattern[RF_FILE_NAME_SIZE]; // or a file
    bool is_sequence;
    int* frames; // numbers in the names, ascending; NULL for a file
    int count;
    int first; // number of the first frame, whether it is wanted or not
} RfSequenceInput;

// Finds the frames of `from`; `list` (--frames) names those that are wanted, or NULL: all. Free it in any case.
RfResult rf_find_sequence_input( const char* from, const char* list, RfSequenceInput* input, RfError* error );
void rf_free_sequence_input( RfSequenceInput* input );

// The file of a frame, or the one file.
RfResult rf_sequence_input_name( const RfSequenceInput* input, int frame, char name[RF_FILE_NAME_SIZE], RfError* error );

// Warns of frames that are missing between the first and the last.
RfResult rf_warn_of_missing( const RfSequenceInput* input, RfLog* log, RfError* error );

// Is there a folder, or a file, of this name?
bool rf_is_folder( const char* path );

typedef struct RfFolderList
{
    char** names; // without the folder, sorted
    int count;
} RfFolderList;

// Lists the files of a folder that have this ending, without hidden ones. Free it in any case.
RfResult rf_list_folder( const char* folder, const char* suffix, RfFolderList* list, RfError* error );
void rf_free_folder_list( RfFolderList* list );

// Frames of a camera path that are to be divided between machines.
typedef struct RfDividedFrames
{
    const int* numbers; // ascending
    const int* runs;    // of the path that they show, likewise
    int count;
    int step;             // from the number of a frame of the path to that of the next
    int run_count;        // of the path
    const RfEye* cameras; // of its runs, which say where its cuts are
} RfDividedFrames;

// Ranges of frames for several machines, reported and as JSON.
typedef struct RfRanges
{
    RfPlanRange* list;
    int count;
    int nodes; // asked for
    int group; // cut for groups of this half-width
    RfDividedFrames frames;
} RfRanges;

// Cuts frames for `nodes` machines, as rf_plan_ranges does. Free with rf_free_ranges.
RfResult rf_cut_ranges( int nodes, const RfDividedFrames* frames, const RfRenderSettings* settings, RfRanges* ranges,
                        RfError* error );
void rf_free_ranges( RfRanges* ranges );

// A line for each range, and one on what the cuts cost.
void rf_print_ranges( const RfRanges* ranges );

// {"wanted", "group", "step", "ranges": [{"frames", "count", "work"}], "overhead", "longest"}
json_t* rf_ranges_json( const RfRanges* ranges );

#endif
