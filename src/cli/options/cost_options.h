// Options of `reframe cost`: those of a render, the time it may take, and the errors
// whose cost is wanted.
#ifndef REFRAME_CLI_OPTIONS_COST_OPTIONS_H
#define REFRAME_CLI_OPTIONS_COST_OPTIONS_H

#include "cli/options/render_options.h"
#include "scene/json/json_document.h"

#define RF_COST_ERRORS 16

typedef struct RfCostOptions
{
    RfRenderOptions render;        // without output
    double budget;                 // seconds
    const char* noise;             // as the user wrote it
    double errors[RF_COST_ERRORS]; // relMSE, as parsed from `noise`
    int error_count;
    const char* flicker;             // NULL: none
    double flickers[RF_COST_ERRORS]; // F1, as parsed from it
    int flicker_count;
    const char* svg; // NULL: none
} RfCostOptions;

// Parses and checks what can be checked without the scene. With *help set the
// help was asked for and nothing else is valid.
RfResult rf_parse_cost_options( int argc, char** argv, RfCostOptions* options, bool* help, RfError* error );

// The same over the defaults of a scene file.
RfResult rf_parse_cost_options_over( const RfField* defaults, int argc, char** argv, RfCostOptions* options, RfError* error );

void rf_print_cost_help( void );

#endif
