// The importer of other formats, a program of its own (src/import): whatever a
// file does to it (crash, hang, all memory taken) is an error here and no more.
#ifndef REFRAME_CONVERT_RUN_IMPORTER_H
#define REFRAME_CONVERT_RUN_IMPORTER_H

#include "convert/root_transform.h"

typedef struct RfImporterRun
{
    const char* program; // path of reframe-import, see rf_find_importer
    const char* source;
    const char* target; // written whole or not at all, replaced where it is there
    size_t memory;      // bytes of address space it may take
    double seconds;     // of wall clock, then it is killed
    bool z_up;
    double scale;
    bool ( *is_interrupted )( void* user ); // asked several times a second; or NULL
    void* user;
} RfImporterRun;

// Runs it and waits; no process is left whatever happens. Its warnings go to
// the log. RF_ERROR_FORMAT where the importer refuses the file or dies of it,
// RF_ERROR_MEMORY, RF_ERROR_INTERRUPTED; nothing is written then.
RfResult rf_run_importer( const RfImporterRun* run, RfModelCounts* counts, RfLog* log, RfError* error );

// Looks for reframe-import beside the running program, then in ../libexec/reframe
// and ../lib/reframe from there.
RfResult rf_find_importer( char* path, size_t size, RfError* error );

#endif
