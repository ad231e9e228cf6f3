#include "cli/plan_options.h"

#include "cli/layer_list.h"
#include "cli/shot_options.h"

static const char* const s_files[] = { "SCENE" };
static RfRenderOptions s_parsed; // the table points here

static const RfOption s_options[] = {
    RF_PATH_OPTIONS( s_parsed, "frames that rays and seconds are of; the group does not depend on them" ),
    RF_SPP_OPTION( s_parsed ),
    RF_TILE_OPTION( s_parsed ),
    RF_LIGHT_OPTIONS( s_parsed ),
    RF_MACHINE_OPTIONS( s_parsed, "threads of the render; the group does not depend on them" ),
    RF_AOV_OPTION( s_parsed ),
    RF_RESULT_OPTIONS( s_parsed, "no words on the costs being measured" ),
};

static const RfCommandTable s_table = { .command = "plan",
                                        .summary = "Tells how large a group can be afforded and which one pays: a row for each half-width N with memory, chunks, rays and the gain that is to be expected; * marks what render --group auto takes. Options and SCENE are those of render.",
                                        .files = s_files,
                                        .file_count = 1,
                                        .options = s_options,
                                        .option_count = sizeof s_options / sizeof s_options[0] };

// On top of the values as they are.
static RfResult parse( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error )
{
    RfResult result = rf_parse_options( &s_table, argc, argv, &s_parsed.scene, help, error );
    if ( result != RF_OK || *help )
        return result;
    result = rf_parse_tile_option( &s_parsed, error );
    if ( result == RF_OK )
        result = rf_parse_layers( s_parsed.aov, &s_parsed.settings.layers, error );
    *options = s_parsed;
    return result;
}

RfResult rf_parse_plan_options( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error )
{
    s_parsed = rf_default_render_options();
    return parse( argc, argv, options, help, error );
}

RfResult rf_parse_plan_options_over( const RfField* defaults, int argc, char** argv, RfRenderOptions* options, RfError* error )
{
    bool help;
    RfResult result = rf_read_render_defaults( defaults, &s_parsed );
    return result == RF_OK ? parse( argc, argv, options, &help, error ) : result;
}

void rf_print_plan_help( void )
{
    rf_print_help( &s_table, stdout );
}
