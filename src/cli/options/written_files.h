// Checks before any work that a command does not write a file that it reads, one file
// twice, or a file named like one of another kind.
#ifndef REFRAME_CLI_OPTIONS_WRITTEN_FILES_H
#define REFRAME_CLI_OPTIONS_WRITTEN_FILES_H

#include "cli/options/options.h"

// Compares what is written (options with `writes`, and the last file where the table says
// `writes_last`) with all files and options with `reads`. Fails with RF_ERROR_USAGE, naming
// the option. "-" and devices are not checked.
RfResult rf_check_written_files( const RfCommandTable* table, const char* const* files, int file_count, RfError* error );

#endif
