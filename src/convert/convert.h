// Runs the importer of other formats in a process of its own (src/import), so that
// a malformed file that makes it crash, hang or run out of memory is only an error.
#ifndef REFRAME_CONVERT_CONVERT_H
#define REFRAME_CONVERT_CONVERT_H

#include "convert/model.h"

typedef struct RfImporterRun
{
    const char* program; // path of reframe-import
    const char* source;
    const char* target; // written atomically, replaced if it exists
    size_t memory;      // limit of its address space, bytes
    double seconds;     // limit of wall-clock time, after which it is killed
    RfUpAxis up;
    double scale;
    bool accept_losses;
    bool ( *is_interrupted )( void* user ); // polled several times a second; or NULL
    void* user;
} RfImporterRun;

// Runs the importer and waits for it to end; never leaves a process behind. Its
// warnings go to the log. Fails with RF_ERROR_FORMAT if the importer rejects the file or
// crashes, RF_ERROR_MEMORY or RF_ERROR_INTERRUPTED, and then writes nothing.
RfResult rf_run_importer( const RfImporterRun* run, RfModelCounts* counts, RfLog* log, RfError* error );

#endif
