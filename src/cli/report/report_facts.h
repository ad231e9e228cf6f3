// What the page says in words and figures beside the pictures: verdict, tables and warnings.
#ifndef REFRAME_CLI_REPORT_REPORT_FACTS_H
#define REFRAME_CLI_REPORT_REPORT_FACTS_H

#include "cli/report/report_frames.h"

// Rows of [group, label, value] about a sequence: measurements, costs from the JSON of render, and the attributes of its first file,
// Reframe's own by their names, which are those of the options.
json_t* rf_page_facts_json( const RfPageTrack* track );

// An array of { sequence, text, loss }: the index of the sequence, a line about it, and whether the export lost something of the
// whole picture, which comes first.
json_t* rf_page_warnings_json( const RfPageRun* report );

// { text, basis, worst_frame }: which sequence reaches the same noise in less time, or how noisy the one is; what the figures rest on;
// and the number of the frame with the largest error, null where no error is known or there is one frame.
json_t* rf_page_verdict_json( const RfPageRun* report );

// "4.5 GB"
void rf_format_bytes( double bytes, char text[32] );

#endif
