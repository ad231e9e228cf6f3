// Defaults of options from the `render` object of a scene file.
#ifndef REFRAME_CLI_OPTIONS_FILE_OPTIONS_H
#define REFRAME_CLI_OPTIONS_FILE_OPTIONS_H

#include "cli/options/options.h"
#include "scene/json/json_document.h"

// Stores what the object gives into the values of the table's options. A key is
// an option's name with '_' for '-', of those that a file may give (`in_file`).
// Whole numbers, numbers and true or false are those of JSON; a size is an array
// of two, fps a number or "24000/1001", all else a string. Ranges are those of
// the command line; faults name the JSON path. Strings stay those of the JSON.
RfResult rf_take_file_options( const RfCommandTable* table, const RfField* object );

// The error of an option ("--frames: there is no frame 9") as one of the value
// that a file gives it ("scene.json: render.frames: there is no frame 9").
RfResult rf_fail_file_option( const RfField* field, const RfError* error );

#endif
