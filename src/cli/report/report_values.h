// How finely the page holds scene values: as --values allows.
#ifndef REFRAME_CLI_REPORT_REPORT_VALUES_H
#define REFRAME_CLI_REPORT_REPORT_VALUES_H

#include "cli/report/report_data.h"
#include "cli/report/report_run.h"

// The factor by which the values of all frames of a sequence are coarser than its pixels; 0: it has none.
int rf_page_value_factor( const RfPageRun* report, const RfPageTrack* track );

// Adds finer values of one frame: of the one that the verdict calls the worst, else of the first.
RfResult rf_add_fine_values( RfPageRun* report, const RfPageData* data, RfPage* page, RfError* error );

#endif
