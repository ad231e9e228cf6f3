// Rows of a page from the JSON of render: effects, time, memory and rays.
#ifndef REFRAME_CLI_REPORT_REPORT_RESOURCES_H
#define REFRAME_CLI_REPORT_REPORT_RESOURCES_H

#include <jansson.h>

// Appends the names of the effects.
void rf_add_effects( json_t* facts, const json_t* render );

// Appends time, memory and rays.
void rf_add_costs( json_t* facts, const json_t* render );

#endif
