#include "cli/options/plan_options.h"

#include "cli/options/shot_options.h"
#include "output/names.h"

static const char* const s_files[] = { "SCENE" };
static RfRenderOptions s_parsed; // the table points here
static bool s_group_given;

static const RfOption s_options[] = {
    RF_PATH_OPTIONS( s_parsed, "frames that rays and seconds are of; the group does not depend on them" ),
    RF_LENS_OPTIONS( s_parsed, true ),
    RF_EFFECT_OPTIONS( s_parsed, true ),
    { .name = "spp",
      .type = RF_OPTION_INT,
      .value = &s_parsed.settings.spp,
      .min = 1,
      .max = RF_MAX_SPP,
      .meta = "S",
      .given = &s_parsed.spp_given,
      .default_text = "28; with --noise or --flicker 65536, with --time 1048576",
      .help = "samples traced per pixel and frame in all, over the groups that hold the frame; the most that --noise, --flicker "
              "and --time may take" },
    { .name = "noise",
      .type = RF_OPTION_RATIO,
      .value = &s_parsed.settings.noise,
      .min = 0,
      .max = RF_MAX_NOISE,
      .meta = "E",
      .default_text = "0: off",
      .help =
          "a render that stops at this relMSE: what its films take, and roughly what it takes in time; rays and the seconds of "
          "the rows are of the most samples" },
    { .name = "flicker",
      .type = RF_OPTION_RATIO,
      .value = &s_parsed.settings.flicker,
      .min = 0,
      .max = RF_MAX_FLICKER,
      .meta = "F",
      .default_text = "0: off",
      .help = "the same for one that stops at this F1" },
    { .name = "time",
      .type = RF_OPTION_TIME,
      .value = &s_parsed.settings.time,
      .min = 0,
      .max = RF_MAX_TIME,
      .meta = "T",
      .default_text = "0: off",
      .help = "the same for one that stops after so many seconds a frame" },
    RF_ESTIMATOR_OPTION( s_parsed ),
    RF_NODES_OPTION( s_parsed, "also cut the frames into ranges for N machines, and say what the cuts cost" ),
    { .name = "group",
      .type = RF_OPTION_INT,
      .value = &s_parsed.settings.group,
      .min = 0,
      .max = 1048576,
      .keyword = "auto",
      .keyword_value = RF_GROUP_AUTO,
      .meta = "N|auto",
      .given = &s_group_given,
      .default_text = "the scene file's, else auto",
      .help = "the group that --nodes cuts for" },
    RF_TILE_OPTION( s_parsed ),
    { .name = "adaptive",
      .type = RF_OPTION_CHOICE,
      .value = &s_parsed.adaptive,
      .choices = rf_adaptive_words,
      .bare = "on",
      .negated = "off",
      .default_text = "auto",
      .help = "what extra samples for some pixels may take of memory; their rays are not predicted" },
    { .name = "weights",
      .type = RF_OPTION_CHOICE,
      .value = &s_parsed.weights,
      .choices = rf_weights_words,
      .default_text = "exact",
      .help = "how reused paths are weighted; eq15 takes more memory" },
    { .name = "normalize",
      .type = RF_OPTION_CHOICE,
      .value = &s_parsed.normalize,
      .choices = rf_normalize_words,
      .default_text = "crossfit",
      .help = "how the sum of weights is divided out; here it makes no difference" },
    RF_FILTER_OPTIONS( s_parsed, true ),
    RF_LIGHT_OPTIONS( s_parsed ),
    RF_MACHINE_OPTIONS( s_parsed, "threads of the render; the group does not depend on them" ),
    RF_AOV_OPTION( s_parsed, "further channels, which need memory:" ),
    RF_RESULT_OPTIONS( s_parsed, "no words on the costs being measured" ),
};

static const RfCommandTable s_table = {
    .command = "plan",
    .summary = "Shows which group sizes fit and which one pays: a row for each half-width N with memory, chunks, "
               "rays and the gain that is to be expected; * marks what render --group auto takes. SCENE is that of render, and "
               "so are the options, as far as memory and the choice depend on them.",
    .files = s_files,
    .file_count = 1,
    .options = s_options,
    .option_count = sizeof s_options / sizeof s_options[0]
};

// Parses on top of the current values.
static RfResult parse( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error )
{
    RfResult result = rf_parse_options( &s_table, argc, argv, &s_parsed.scene, help, error );
    if ( result != RF_OK || *help )
        return result;
    if ( s_group_given && s_parsed.nodes == 0 )
        return rf_fail( error, RF_ERROR_USAGE, "--group: is what --nodes cuts for; the rows show other groups without it" );
    *options = s_parsed;
    return rf_settle_render_options( options, error );
}

RfResult rf_parse_plan_options( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error )
{
    s_parsed = rf_default_render_options();
    s_group_given = false;
    return parse( argc, argv, options, help, error );
}

RfResult rf_parse_plan_options_over( const RfField* defaults, int argc, char** argv, RfRenderOptions* options, RfError* error )
{
    bool help;
    s_group_given = false;
    RfResult result = rf_read_render_defaults( defaults, &s_parsed );
    return result == RF_OK ? parse( argc, argv, options, &help, error ) : result;
}

void rf_print_plan_help( void ) { rf_print_help( &s_table, stdout ); }
