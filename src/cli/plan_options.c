#include "cli/plan_options.h"

#include "cli/camera_options.h"
#include "cli/layer_list.h"

static const char* const s_files[] = { "SCENE" };
static RfRenderOptions s_parsed; // the table points here

static const RfOption s_options[] = {
    { .name = "camera", .type = RF_OPTION_STRING, .value = &s_parsed.camera, .meta = "NAME|FILE",
      .default_text = "the scene file's, else the first animated one, else the first",
      .help = "a camera of the scene, or a camera-path file (.json)" },
    { .name = "frames", .type = RF_OPTION_STRING, .value = &s_parsed.frames, .meta = "A-B[xSTEP][,...]", .default_text = "all",
      .help = "frames that rays and seconds are of; the group does not depend on them" },
    { .name = "fps", .type = RF_OPTION_FPS, .value = &s_parsed.fps, .meta = "R", .default_text = "24",
      .help = "frames per second of the camera's path, 24 or 24000/1001" },
    { .name = "size", .type = RF_OPTION_SIZE, .value = &s_parsed.size, .min = 1, .max = RF_MAX_IMAGE_SIDE, .meta = "WxH",
      .default_text = "960x540", .help = "pixels" },
    { .name = "spp", .type = RF_OPTION_INT, .value = &s_parsed.settings.spp, .min = 1, .max = 1048576, .meta = "S",
      .default_text = "28", .help = "samples traced per pixel and frame in all, over the groups that hold the frame" },
    { .name = "tile", .type = RF_OPTION_STRING, .value = &s_parsed.tile, .meta = "WxH|rooksN|1", .default_text = "3x3",
      .help = "pixels of a frame that share their paths: blocks, N of an NxN grid, or none" },
    { .name = "tile-roulette", .type = RF_OPTION_BOOL, .value = &s_parsed.settings.tile_roulette, .default_text = "no",
      .help = "Russian roulette on the connections in a tile that are worth little" },
    { .name = "max-depth", .type = RF_OPTION_INT, .value = &s_parsed.settings.max_depth, .min = 1, .max = 1000, .meta = "D",
      .default_text = "12", .help = "path vertices after the eye" },
    { .name = "light-samples", .type = RF_OPTION_INT, .value = &s_parsed.settings.light_samples, .min = 1, .max = 64,
      .meta = "K", .default_text = "1", .help = "light samples per vertex" },
    { .name = "memory", .type = RF_OPTION_MEMORY, .value = &s_parsed.settings.memory, .min = 1048576, .meta = "SIZE",
      .default_text = "half of what is free", .help = "budget beyond the scene and its BVH: 512M, 4G" },
    { .name = "threads", .type = RF_OPTION_INT, .value = &s_parsed.settings.threads, .min = 1, .max = 1024, .meta = "T",
      .default_text = "all cores", .help = "threads of the render; the group does not depend on them" },
    { .name = "aov", .type = RF_OPTION_STRING, .value = &s_parsed.aov, .meta = "LAYER[,...]", .default_text = "none",
      .help = "further layers, which need memory: albedo, normal, depth, motion, variance, samples" },
    { .name = "json", .type = RF_OPTION_STRING, .value = &s_parsed.json, .meta = "FILE",
      .help = "the result for programs; - is standard output" },
    { .name = "quiet", .type = RF_OPTION_BOOL, .value = &s_parsed.quiet, .help = "no words on the costs being measured" },
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
