// Tables of the page about a sequence: rows of [group, label, value] from measurements, the
// headers of the files and the JSON of render.
#ifndef REFRAME_CLI_REPORT_REPORT_FACTS_H
#define REFRAME_CLI_REPORT_REPORT_FACTS_H

#include "cli/report/report_frames.h"

// An array. NULL where memory ran out.
json_t* rf_page_facts_json( const RfPageTrack* track );

// Numbers as people read them: "1.23 M", "4.5 GB", "3 min 20 s".
void rf_format_count( double count, char text[32] );
void rf_format_bytes( double bytes, char text[32] );
void rf_format_seconds( double seconds, char text[32] );

#endif
