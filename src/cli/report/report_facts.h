// What the page says in words and figures beside the pictures: tables, what accuracy costs, warnings.
#ifndef REFRAME_CLI_REPORT_REPORT_FACTS_H
#define REFRAME_CLI_REPORT_REPORT_FACTS_H

#include "cli/report/report_frames.h"
#include "cli/report/report_command.h"

#include <jansson.h>

// Tables of the page about a sequence: rows of [group, label, value] from measurements, the
// headers of the files and the JSON of render.

// An array. NULL where memory ran out.
json_t* rf_page_facts_json( const RfPageTrack* track );

// What `cost --json` found, for the page: rows of the chart, and a note in words.

// Fails where the JSON of --cost, or of a folder, is of another scene than the frames.
RfResult rf_check_cost_scene( const RfPageRun* report, RfError* error );

// An array of { name, note, rows }: of --cost, else of each folder that has one.
json_t* rf_page_cost_json( const RfPageData* data );

// Numbers as people read them: "1.23 M", "4.5 GB", "3 min 20 s".

void rf_format_bytes( double bytes, char text[32] );

// What the page warns of: what the export lost, what render said of the scene, and what the frames lack.

// An array of { sequence, text, loss }, the index of the sequence, a line about it, and whether the export lost something of the
// whole picture, which comes first.
json_t* rf_page_warnings_json( const RfPageData* data );

#endif
