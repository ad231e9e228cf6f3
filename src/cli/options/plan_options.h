// Options of `reframe plan`: those of a render.
#ifndef REFRAME_CLI_OPTIONS_PLAN_OPTIONS_H
#define REFRAME_CLI_OPTIONS_PLAN_OPTIONS_H

#include "cli/options/render_options.h"
#include "scene/json/json_document.h"

// Parses and checks what can be checked without the scene. With *help set the
// help was asked for and nothing else is valid. There is no `output`.
RfResult rf_parse_plan_options( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error );

// The same over the defaults of a scene file.
RfResult rf_parse_plan_options_over( const RfField* defaults, int argc, char** argv, RfRenderOptions* options, RfError* error );

void rf_print_plan_help( void );

#endif
