// The results of `reframe cost`: table, text, JSON, plot.
#ifndef REFRAME_CLI_TUNE_COST_REPORT_H
#define REFRAME_CLI_TUNE_COST_REPORT_H

#include "cli/options/cost_options.h"
#include "measure/cost.h"

#include <jansson.h>

typedef struct RfCostReport
{
    const RfCostOptions* options;
    const RfCostJob* job;
    const RfCost* cost;
    int per_sweep[2];    // frames of a sweep, by path tracing and with reuse
    double load_seconds; // until rays can be traced: part of a render of all frames
} RfCostReport;

void rf_print_cost( const RfCostReport* report );
json_t* rf_cost_json( const RfCostReport* report );
RfResult rf_write_cost_plot( const RfCostReport* report, const char* path, RfError* error );

#endif
