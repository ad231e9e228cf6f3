// What `cost --json` found, for the page: rows of the chart, and a note in words.
#ifndef REFRAME_CLI_REPORT_REPORT_COST_H
#define REFRAME_CLI_REPORT_REPORT_COST_H

#include "cli/report/report_data.h"
#include "cli/report/report_run.h"

// Fails where the JSON of --cost, or of a folder, is of another scene than the frames.
RfResult rf_check_cost_scene( const RfPageRun* report, RfError* error );

// An array of { name, note, rows }: of --cost, else of each folder that has one.
json_t* rf_page_cost_json( const RfPageData* data );

// "9.1 times faster"; "1.3 times slower" for a speedup below 1; "about as fast" around it.
void rf_format_speedup( double speedup, char text[48] );

#endif
