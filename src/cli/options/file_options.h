// Defaults of options from the `render` object of a scene file.
#ifndef REFRAME_CLI_OPTIONS_FILE_OPTIONS_H
#define REFRAME_CLI_OPTIONS_FILE_OPTIONS_H

#include "cli/options/options.h"
#include "base/json.h"

// Stores the members of the object in the values of the table's options. A key is
// the name of an option that a file may give (`in_file`), with '_' for '-'. Numbers
// and booleans are those of JSON, also for choices that can be given as --name and --no-name; a size is an array of two numbers, fps a number or
// "24000/1001", all else a string. Ranges are those of the command line; errors name
// the JSON path. Strings point into the JSON.
RfResult rf_take_file_options( const RfCommandTable* table, const RfField* object );

// Rewrites the error of an option ("--frames: there is no frame 9") as one of the
// scene file ("scene.json: render.frames: there is no frame 9").
RfResult rf_fail_file_option( const RfField* field, const RfError* error );

#endif
