// Finds the sequence of EXR files in a folder.
#ifndef REFRAME_CLI_REPORT_REPORT_FOLDER_H
#define REFRAME_CLI_REPORT_REPORT_FOLDER_H

#include "reframe/error.h"

#include <stddef.h>

typedef struct RfFolderList
{
    char** names; // without the folder, sorted
    int count;
} RfFolderList;

// Lists the files of a folder that have this ending, without hidden ones. Free it in any case.
RfResult rf_list_folder( const char* folder, const char* suffix, RfFolderList* list, RfError* error );
void rf_free_folder_list( RfFolderList* list );

// The pattern of the folder's frames: the last number of their names is the frame's.
// Fails where there is no EXR, or more than one sequence, which the error names; a
// folder of one file without a number gives that file.
RfResult rf_find_folder_sequence( const char* folder, char* pattern, size_t size, RfError* error );

#endif
