// What the page warns of: what render said of the scene, and what the frames lack.
#ifndef REFRAME_CLI_REPORT_REPORT_WARNINGS_H
#define REFRAME_CLI_REPORT_REPORT_WARNINGS_H

#include "cli/report/report_data.h"

// An array of { sequence, text }, the index of the sequence and a line about it.
json_t* rf_page_warnings_json( const RfPageData* data );

#endif
