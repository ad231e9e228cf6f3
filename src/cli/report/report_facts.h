// Tables of the page about a sequence: rows of [group, label, value] from measurements, the
// headers of the files and the JSON of render.
#ifndef REFRAME_CLI_REPORT_REPORT_FACTS_H
#define REFRAME_CLI_REPORT_REPORT_FACTS_H

#include "cli/report/report_frames.h"

// An array. NULL where memory ran out.
json_t* rf_page_facts_json( const RfPageTrack* track );

#endif
