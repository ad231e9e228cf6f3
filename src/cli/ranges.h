// Ranges of frames for several machines, told and as JSON.
#ifndef REFRAME_CLI_RANGES_H
#define REFRAME_CLI_RANGES_H

#include "reframe/plan.h"

#include <jansson.h>

typedef struct RfRanges
{
    RfPlanRange* list;
    int count;
    int nodes;          // asked for
    int group;          // cut for groups of this half-width
    const int* numbers; // of all frames, ascending; the caller's
    int step;           // from the number of a frame of the path to that of the next
} RfRanges;

// Cuts frames of these numbers for `nodes` machines; the rest as for rf_plan_ranges. Free with rf_free_ranges.
RfResult rf_cut_ranges( int nodes, const int* numbers, int step, int eye_count, const int* eyes, int frame_count,
                        const RfRenderSettings* settings, RfRanges* ranges, RfError* error );
void rf_free_ranges( RfRanges* ranges );

// Frames as --frames takes them: "1-24", "1,7,9-15x2". The caller frees the text; NULL where memory ran out.
char* rf_frame_list( const int* numbers, int count, int step );

// A line for each range, and one on what the cuts cost.
void rf_print_ranges( const RfRanges* ranges );

// {"wanted", "group", "step", "ranges": [{"frames", "count", "work"}], "overhead", "longest"}
json_t* rf_ranges_json( const RfRanges* ranges );

#endif
