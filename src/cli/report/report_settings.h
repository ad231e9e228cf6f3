// Rows of a page about what a sequence was rendered with, from the headers of its files.
#ifndef REFRAME_CLI_REPORT_REPORT_SETTINGS_H
#define REFRAME_CLI_REPORT_REPORT_SETTINGS_H

#include "cli/report/report_frames.h"

// Appends those of a group, "Scene" or "Settings", that the header of a file has.
void rf_add_settings( json_t* facts, const char* path, const char* group );

// Appends the samples traced, and their limit.
void rf_add_samples( json_t* facts, const RfPageTrack* track );

#endif
