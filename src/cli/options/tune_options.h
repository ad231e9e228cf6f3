// Options of `reframe tune`: those of a render, and the time it may take.
#ifndef REFRAME_CLI_OPTIONS_TUNE_OPTIONS_H
#define REFRAME_CLI_OPTIONS_TUNE_OPTIONS_H

#include "cli/options/render_options.h"
#include "scene/json/json_document.h"

typedef struct RfTuneOptions
{
    RfRenderOptions render; // without group, tile and output
    double budget;          // seconds
    int goal;               // an RfTuneGoal
    const char* svg;        // NULL: none
} RfTuneOptions;

// Parses and checks what can be checked without the scene. With *help set the
// help was asked for and nothing else is valid.
RfResult rf_parse_tune_options( int argc, char** argv, RfTuneOptions* options, bool* help, RfError* error );

// The same over the defaults of a scene file.
RfResult rf_parse_tune_options_over( const RfField* defaults, int argc, char** argv, RfTuneOptions* options, RfError* error );

void rf_print_tune_help( void );

// The command line of the best settings: "reframe render SCENE -o frame.####.exr --group N
// --tile T" and those of the user's options that `render` takes, quoted for a shell. The
// caller frees it; NULL where memory ran out. `estimator` is named unless it is NULL.
char* rf_tuned_command( int argc, char** argv, const RfEstimator* estimator, int group, const RfTile* tile );

#endif
