// What a command reads frame by frame: a file, a sequence named with ####, or the folder of one.
#ifndef REFRAME_CLI_OPTIONS_SEQUENCE_INPUT_H
#define REFRAME_CLI_OPTIONS_SEQUENCE_INPUT_H

#include "reframe/error.h"

#include <stdbool.h>

#define RF_FILE_NAME_SIZE 4096

typedef struct RfSequenceInput
{
    char pattern[RF_FILE_NAME_SIZE]; // or a file
    bool is_sequence;
    int* frames; // numbers in the names, ascending; NULL for a file
    int count;
} RfSequenceInput;

// Finds the frames of `from`; `list` (--frames) names those that are wanted, or NULL: all. Free it in any case.
RfResult rf_find_sequence_input( const char* from, const char* list, RfSequenceInput* input, RfError* error );
void rf_free_sequence_input( RfSequenceInput* input );

// Warns of frames that are missing between the first and the last.
RfResult rf_warn_of_missing( const RfSequenceInput* input, RfLog* log, RfError* error );

// Is there a folder, or a file, of this name?
bool rf_is_folder( const char* path );
bool rf_is_file( const char* path );

#endif
