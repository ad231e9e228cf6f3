// Before any work: what a command is to write must not be what it reads, nor
// the same file twice, nor bear the name of another kind of file.
#ifndef REFRAME_CLI_OPTIONS_WRITTEN_FILES_H
#define REFRAME_CLI_OPTIONS_WRITTEN_FILES_H

#include "cli/options/options.h"

// The options whose `writes` is set, and the last file where the table's
// `writes_last` is, against all files and options with `reads`. RF_ERROR_USAGE
// names the option. "-" and devices are left alone.
RfResult rf_check_written_files( const RfCommandTable* table, const char* const* files, int file_count, RfError* error );

#endif
