// What `reframe render` is asked for.
#ifndef REFRAME_CLI_OPTIONS_RENDER_OPTIONS_H
#define REFRAME_CLI_OPTIONS_RENDER_OPTIONS_H

#include "cli/options/options.h"
#include "reframe/render.h"

typedef struct RfRenderOptions
{
    const char* scene;
    const char* camera; // NULL: the scene's first animated one, else its first
    const char* frames; // NULL: all
    RfFps fps;
    RfSize size;
    RfRenderSettings settings;
    bool spp_given;
    int weights, normalize; // indices of their words
    const char* tile;
    const char* aov; // NULL: none
    const char* output;
    bool resume;
    bool overwrite;
    const char* json; // NULL: none
    bool quiet;
} RfRenderOptions;

RfRenderOptions rf_default_render_options( void );

// The samples that --noise (0: --time alone) may take where --spp is not given.
int rf_default_most_spp( double noise );

// Parses and checks what can be checked without the scene. With *help set the
// help was asked for and nothing else is valid.
RfResult rf_parse_render_options( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error );

// The defaults with what the `render` object of a scene file says; a fault of it
// names its JSON path. Strings belong to the JSON.
struct RfField;
RfResult rf_read_render_defaults( const struct RfField* defaults, RfRenderOptions* options );
// The same with the command line on top, which has been parsed before.
RfResult rf_parse_render_options_over( const struct RfField* defaults, int argc, char** argv, RfRenderOptions* options,
                                       RfError* error );

// settings.tile from the word.
RfResult rf_parse_tile_option( RfRenderOptions* options, RfError* error );

// settings.layers from the words of --aov.
RfResult rf_parse_aov_option( RfRenderOptions* options, RfError* error );

// The settings from the words, once all options are known, and the samples that
// --noise and --time may take where none were given: by the same rule for all
// that speak of a render. Fails with RF_ERROR_USAGE for what does not go together.
RfResult rf_settle_render_options( RfRenderOptions* options, RfError* error );

void rf_print_render_help( void );

#endif
