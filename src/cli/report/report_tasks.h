// A sequence that several machines render, as `reframe report` finds it: the ranges that `plan --nodes` cut, how far each
// is, and the JSON of the tasks as one.
#ifndef REFRAME_CLI_REPORT_REPORT_TASKS_H
#define REFRAME_CLI_REPORT_REPORT_TASKS_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

// Does this JSON have ranges: that of `plan --nodes`, of `render --check --nodes` or of scripts/slurm-render?
bool rf_is_plan_json( const json_t* json );

// Joins the render JSON of a task to those before, into *all (NULL at first): frames, seconds, rays and warnings are added up.
void rf_join_task_json( json_t** all, const json_t* task );

// {"asked", "finished", "left": [numbers], "tasks": [{"frames", "count", "finished"}]} of a plan for a sequence whose frames
// of these numbers, ascending, are there; NULL: its ranges are not what we write.
json_t* rf_task_progress_json( const json_t* plan, const int* numbers, int number_count );

// The numbers of its "left" as "3, 4, 8-12", truncated with "..." if too long.
void rf_format_left( const json_t* left, char* text, size_t size );

// Says on standard output what is not finished of a sequence, unless all is, or nothing is known of it (NULL).
void rf_tell_unfinished( const char* name, const json_t* progress );

// Appends rows to the facts of a page: how many frames are finished, which are not, and each task's share.
void rf_add_progress_facts( json_t* facts, const json_t* progress );

#endif
