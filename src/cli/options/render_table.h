// Internal to the options of `reframe render`: their table, and what it writes to.
#ifndef REFRAME_CLI_OPTIONS_RENDER_TABLE_H
#define REFRAME_CLI_OPTIONS_RENDER_TABLE_H

#include "cli/options/render_options.h"

// What a parse has found so far. Every parse starts from the defaults; the result is copied out.
typedef struct RfRenderParse
{
    RfRenderOptions options;
    int compression; // index of its word
    bool is_float, is_float_given, is_half_given;
} RfRenderParse;

extern RfRenderParse rf_render_parse;
extern const RfCommandTable rf_render_table;

#endif
