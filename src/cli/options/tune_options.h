// What `reframe tune` is asked for: options of a render, and how long it may look.
#ifndef REFRAME_CLI_OPTIONS_TUNE_OPTIONS_H
#define REFRAME_CLI_OPTIONS_TUNE_OPTIONS_H

#include "cli/options/render_options.h"
#include "scene/json/json_document.h"

typedef struct RfTuneOptions
{
    RfRenderOptions render; // without group, tile and output
    double budget;          // seconds
    const char* svg;        // NULL: none
} RfTuneOptions;

// Parses and checks what can be checked without the scene. With *help set the
// help was asked for and nothing else is valid.
RfResult rf_parse_tune_options( int argc, char** argv, RfTuneOptions* options, bool* help, RfError* error );

// The same over the defaults of a scene file.
RfResult rf_parse_tune_options_over( const RfField* defaults, int argc, char** argv, RfTuneOptions* options, RfError* error );

void rf_print_tune_help( void );

// "reframe render SCENE -o frame.####.exr --group N --tile T" with those of the
// options that the user gave which a render takes, quoted for a shell. To be
// freed; NULL where there is no memory.
char* rf_tuned_command( int argc, char** argv, int group, const RfTile* tile );

#endif
