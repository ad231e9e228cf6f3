// What it costs to split the light of a render by groups (--light-groups) and passes (--aov emission and so on).
#ifndef REFRAME_CLI_TUNE_SPLIT_COSTS_H
#define REFRAME_CLI_TUNE_SPLIT_COSTS_H

#include "reframe/render.h"

#include <jansson.h>

typedef struct RfSplitCosts
{
    int films;                      // more of each frame; 0: nothing is asked for
    size_t bytes_films, bytes_hits; // more
    double time_share;              // more time, as a share of that without; NaN: not measured
} RfSplitCosts;

// Of a render of the shot with these settings, whose group is known. `measure`: the time is measured on some pixels.
RfResult rf_find_split_costs( const RfShot* shot, const RfRenderSettings* settings, bool measure, RfSplitCosts* costs,
                              RfError* error );

// A line; nothing where there are none.
void rf_print_split_costs( const RfSplitCosts* costs );

// Null where there are none.
json_t* rf_split_costs_json( const RfSplitCosts* costs );

#endif
