// A sequence that several machines render, as `reframe report` finds it: the ranges that `plan --nodes` cut, how far each
// is, and the JSON of the tasks as one.
#ifndef REFRAME_CLI_REPORT_REPORT_TASKS_H
#define REFRAME_CLI_REPORT_REPORT_TASKS_H

#include "cli/report/report_input.h"

// Does this JSON have ranges: that of `plan --nodes`, of `render --check --nodes` or of scripts/slurm-render?
bool rf_is_plan_json( const json_t* json );

// Joins the render JSON of a task to those before, into *all (NULL at first): frames, seconds, rays and warnings are added up.
void rf_join_task_json( json_t** all, const json_t* task );

// {"asked", "finished", "left": [numbers], "tasks": [{"frames", "count", "finished"}]} of the sequence's plan; NULL: it has none,
// or its ranges are not what we write.
json_t* rf_task_progress_json( const RfPageSequence* sequence );

// The numbers of its "left" as "3, 4, 8-12", truncated with "..." if too long.
void rf_format_left( const json_t* left, char* text, size_t size );

#endif
