// The results of `reframe tune`: table, JSON, plot.
#ifndef REFRAME_CLI_TUNE_TUNE_REPORT_H
#define REFRAME_CLI_TUNE_TUNE_REPORT_H

#include "measure/tune.h"

#include <jansson.h>

typedef struct RfTuneReport
{
    const RfTune* tune;
    const char* scene;
    const char* command; // of the winner; NULL: there is none
    int width, height;   // of the render
    int frames;          // asked for
    double budget;
} RfTuneReport;

void rf_print_tune( const RfTuneReport* report );
json_t* rf_tune_json( const RfTuneReport* report );
RfResult rf_write_tune_plot( const RfTuneReport* report, const char* path, RfError* error );

#endif
