#include "cli/options/render_options.h"

#include "cli/options/effect_options.h"
#include "cli/options/file_options.h"
#include "cli/options/shot_options.h"
#include "output/names.h"

#include <string.h>

static const char* const s_compressions[] = { "none", "zip", "piz", NULL }; // in the order of RfExrCompression
static const char* const s_files[] = { "SCENE" };

#define WRITE_QUEUE 2                  // frames: one being written, one waiting
#define MOST_SPP_FOR_NOISE ( 1 << 16 ) // noise that has not come down by then will not

// The option table writes here. Every parse starts from the defaults; the result is copied out.
static RfRenderOptions s_parsed;
static int s_compression_index;
static bool s_float, s_float_given, s_half_given;

static const RfOption s_options[] = {
    { .name = "output",
      .writes = "",
      .letter = 'o',
      .type = RF_OPTION_STRING,
      .value = &s_parsed.output,
      .meta = "PATTERN",
      .help = "where the frames go: out/frame.####.exr, #### (or %04d) is the frame's number; its folder is made" },
    { .name = "camera",
      .reads = true,
      .type = RF_OPTION_STRING,
      .value = &s_parsed.camera,
      .meta = "NAME|FILE",
      .default_text = "the scene file's, else the first animated one, else the first",
      .help = "a camera of the scene, or a camera-path file (.json)" },
    { .name = "frames",
      .in_file = true,
      .type = RF_OPTION_STRING,
      .value = &s_parsed.frames,
      .meta = "A-B[xSTEP][,...]",
      .default_text = "all",
      .help = "frames by their numbers, as in Blender, else from 1; negative ones count from the end" },
    { .name = "fps",
      .in_file = true,
      .type = RF_OPTION_FPS,
      .value = &s_parsed.fps,
      .meta = "R",
      .default_text = "the scene's, else 24",
      .help = "frames per second of the camera's path, 24 or 24000/1001" },
    { .name = "size",
      .in_file = true,
      .type = RF_OPTION_SIZE,
      .value = &s_parsed.size,
      .min = 1,
      .max = RF_MAX_IMAGE_SIDE,
      .meta = "WxH",
      .default_text = "the scene's, else 960x540",
      .help = "pixels; also 720p, 1080p, 1440p, 2160p or 4k" },
    RF_LENS_OPTIONS( s_parsed, true ),
    RF_EFFECT_OPTIONS( s_parsed, true ),
    { .name = "spp",
      .in_file = true,
      .type = RF_OPTION_INT,
      .value = &s_parsed.settings.spp,
      .min = 1,
      .max = 1048576,
      .meta = "S",
      .given = &s_parsed.spp_given,
      .default_text = "28; with --noise 65536, with --time 1048576",
      .help = "samples traced per pixel and frame in all, over the groups that hold the frame; the most that --noise and --time "
              "may take" },
    { .name = "noise",
      .in_file = true,
      .type = RF_OPTION_RATIO,
      .value = &s_parsed.settings.noise,
      .min = 0,
      .max = RF_MAX_NOISE,
      .meta = "E",
      .default_text = "0: off",
      .help = "every frame is rendered until its estimated relMSE is at most E; 1% is 0.01" },
    { .name = "time",
      .in_file = true,
      .type = RF_OPTION_TIME,
      .value = &s_parsed.settings.time,
      .min = 0,
      .max = RF_MAX_TIME,
      .meta = "T",
      .default_text = "0: off",
      .help =
          "seconds of rendering for each frame asked for, on average, also 20s, 5m, 1h30m; with --noise, whichever comes first" },
    { .name = "group",
      .in_file = true,
      .type = RF_OPTION_INT,
      .value = &s_parsed.settings.group,
      .min = 0,
      .max = 1048576,
      .keyword = "auto",
      .keyword_value = RF_GROUP_AUTO,
      .meta = "N|auto",
      .default_text = "auto",
      .help = "paths serve groups of 2N+1 frames; 0: no reuse" },
    { .name = "estimator",
      .in_file = true,
      .type = RF_OPTION_STRING,
      .value = &s_parsed.estimator,
      .meta = "reuse|gradient",
      .default_text = "reuse",
      .help = "how pixels are estimated: reuse of frames and tiles, or gradient-domain path reusing, which has tiles but no "
              "groups yet" },
    { .name = "tile",
      .in_file = true,
      .type = RF_OPTION_STRING,
      .value = &s_parsed.tile,
      .meta = "WxH|rooksN|1",
      .default_text = "3x3; with --estimator gradient 6x6",
      .help = "pixels of a frame that share their paths: blocks, N of an NxN grid, or none" },
    { .name = "adaptive",
      .in_file = true,
      .type = RF_OPTION_CHOICE,
      .value = &s_parsed.adaptive,
      .choices = rf_adaptive_words,
      .bare = "on",
      .negated = "off",
      .default_text = "auto",
      .help = "extra samples for pixels that few other frames help: borders, what comes into view, mirrors, glass, and more "
              "where these are noisy; auto: in frames where they pay. --adaptive alone is on, --no-adaptive is off" },
    { .name = "tile-roulette",
      .in_file = true,
      .type = RF_OPTION_BOOL,
      .value = &s_parsed.settings.tile_roulette,
      .default_text = "no",
      .help = "Russian roulette on the connections in a tile that are worth little" },
    { .name = "light-paths",
      .in_file = true,
      .type = RF_OPTION_CHOICE,
      .value = &s_parsed.light_paths,
      .choices = rf_light_paths_words,
      .default_text = "off",
      .help = "light that mirrors and glass send on, by paths from the lights that serve all frames of a group: caustics, lamps "
              "behind glass; auto: where there are mirrors or clear glass" },
    { .name = "kernel-normalization",
      .in_file = true,
      .type = RF_OPTION_CHOICE,
      .value = &s_parsed.kernel_normalization,
      .choices = rf_kernel_normalization_words,
      .default_text = "exact",
      .help =
          "of --light-paths: how links are divided by their probability; disc is faster and biased, density is photon mapping "
          "by the same footprints, both for comparison" },
    { .name = "weights",
      .in_file = true,
      .type = RF_OPTION_CHOICE,
      .value = &s_parsed.weights,
      .choices = rf_weights_words,
      .default_text = "exact",
      .help = "how reused paths are weighted; the others are biased, for comparison" },
    { .name = "normalize",
      .in_file = true,
      .type = RF_OPTION_CHOICE,
      .value = &s_parsed.normalize,
      .choices = rf_normalize_words,
      .default_text = "crossfit",
      .help = "how the sum of weights is divided out" },
    { .name = "reconstruction",
      .in_file = true,
      .type = RF_OPTION_CHOICE,
      .value = &s_parsed.reconstruction,
      .choices = rf_reconstruction_words,
      .default_text = "weighted",
      .help =
          "of --estimator gradient: least squares weighted by the other half's variances, or by constants; l1 is biased; none: "
          "the pixels without their differences" },
    RF_FILTER_OPTIONS( s_parsed, true ),
    { .name = "max-depth",
      .in_file = true,
      .type = RF_OPTION_INT,
      .value = &s_parsed.settings.max_depth,
      .min = 1,
      .max = 1000,
      .meta = "D",
      .default_text = "12",
      .help = "path vertices after the eye" },
    { .name = "light-samples",
      .in_file = true,
      .type = RF_OPTION_INT,
      .value = &s_parsed.settings.light_samples,
      .min = 1,
      .max = 64,
      .meta = "K",
      .default_text = "1",
      .help = "light samples per vertex" },
    { .name = "seed",
      .in_file = true,
      .type = RF_OPTION_UINT64,
      .value = &s_parsed.settings.seed,
      .meta = "S",
      .default_text = "1",
      .help = "of the random numbers" },
    { .name = "memory",
      .type = RF_OPTION_MEMORY,
      .value = &s_parsed.settings.memory,
      .min = 1048576,
      .meta = "SIZE",
      .default_text = "half of what is free",
      .help = "budget beyond the scene and its BVH: 512M, 4G" },
    { .name = "hold-all",
      .type = RF_OPTION_BOOL,
      .value = &s_parsed.settings.hold_all,
      .default_text = "no",
      .help = "all hit records of a group in memory at once, for comparison; the pictures do not depend on it" },
    { .name = "threads",
      .type = RF_OPTION_INT,
      .value = &s_parsed.settings.threads,
      .min = 1,
      .max = 1024,
      .meta = "T",
      .default_text = "all cores",
      .help = "threads; the pictures do not depend on them" },
    RF_AOV_OPTION( s_parsed, "further channels of each frame:" ),
    { .name = "alpha",
      .in_file = true,
      .type = RF_OPTION_BOOL,
      .value = &s_parsed.alpha,
      .default_text = "no",
      .help = "RGBA: coverage of each pixel by what is not sky; the colour is premultiplied, without the sky behind things" },
    { .name = "compression",
      .type = RF_OPTION_CHOICE,
      .value = &s_compression_index,
      .choices = s_compressions,
      .default_text = "zip",
      .help = "of the EXR files" },
    { .name = "half",
      .type = RF_OPTION_BOOL,
      .value = &s_parsed.settings.files.half,
      .given = &s_half_given,
      .default_text = "yes",
      .help = "16-bit floats for the colour and the AOVs that need no more" },
    { .name = "float",
      .type = RF_OPTION_BOOL,
      .value = &s_float,
      .given = &s_float_given,
      .default_text = "no",
      .help = "32-bit floats for all channels" },
    { .name = "resume",
      .type = RF_OPTION_BOOL,
      .value = &s_parsed.resume,
      .help = "keep the frames that are there and of this very render; others are an error, or replaced with --overwrite" },
    { .name = "overwrite",
      .type = RF_OPTION_BOOL,
      .value = &s_parsed.overwrite,
      .help = "replace the frames that are there, with --resume only those of another render" },
    { .name = "json",
      .writes = ".json",
      .type = RF_OPTION_STRING,
      .value = &s_parsed.json,
      .meta = "FILE",
      .help = "the result for programs, also of an interrupted render; - is standard output" },
    { .name = "quiet", .type = RF_OPTION_BOOL, .value = &s_parsed.quiet, .help = "no progress" },
};

static const RfCommandTable s_table = { .command = "render",
                                        .summary = "Renders a camera's path to a sequence of EXR files. SCENE is a .glb, a .gltf "
                                                   "or a scene file (.json), which may hold defaults of these options.",
                                        .files = s_files,
                                        .file_count = 1,
                                        .options = s_options,
                                        .option_count = sizeof s_options / sizeof s_options[0] };

int rf_default_most_spp( double noise ) { return noise > 0.0 ? MOST_SPP_FOR_NOISE : RF_MAX_SPP; }

static bool ends_with( const char* text, const char* end )
{
    size_t length = strlen( text ), end_length = strlen( end );
    return length > end_length && strcmp( text + length - end_length, end ) == 0;
}

static RfResult check( const RfRenderOptions* options, RfError* error )
{
    if ( options->output == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "-o is missing: say where the frames go, such as -o out/frame.####.exr" );
    if ( !ends_with( options->output, ".exr" ) )
        return rf_fail( error, RF_ERROR_USAGE, "--output: wants a name that ends in .exr, got '%s'", options->output );
    if ( s_half_given && s_float_given && options->settings.files.half == s_float )
        return rf_fail( error, RF_ERROR_USAGE, "--half and --float: only one of the two" );
    return RF_OK;
}

RfRenderOptions rf_default_render_options( void )
{
    RfRenderOptions options = { .settings = rf_default_render_settings() };
    options.estimator = rf_estimator_name( options.settings.estimator );
    options.settings.files = rf_default_frame_files();
    options.settings.queue = WRITE_QUEUE;
    options.weights = options.settings.weights;
    options.normalize = options.settings.normalize;
    options.adaptive = options.settings.adaptive;
    options.reconstruction = options.settings.reconstruction;
    options.light_paths = options.settings.light_paths;
    options.kernel_normalization = options.settings.kernel_normalization;
    options.filter = -1;
    return options;
}

static void reset( void )
{
    s_parsed = rf_default_render_options();
    s_float = s_float_given = s_half_given = false;
    s_compression_index = s_parsed.settings.files.compression;
}

static void take_words( RfRenderOptions* options )
{
    options->settings.weights = (RfWeights)options->weights;
    options->settings.normalize = (RfNormalize)options->normalize;
    options->settings.adaptive = (RfAdaptive)options->adaptive;
    options->settings.reconstruction = (RfReconstruction)options->reconstruction;
    options->settings.light_paths = (RfLightPathsUse)options->light_paths;
    options->settings.kernel_normalization = (RfKernelNormalization)options->kernel_normalization;
}

void rf_settle_filter( RfRenderOptions* options )
{
    bool given = options->filter >= 0;
    options->settings.filter = given ? (RfFilter)options->filter : rf_default_filter( options->settings.estimator );
}

RfResult rf_parse_estimator_option( RfRenderOptions* options, RfError* error )
{
    const RfEstimator* estimator = rf_find_estimator( options->estimator );
    if ( estimator == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--estimator: wants reuse or gradient, got '%s'", options->estimator );
    options->settings.estimator = estimator;
    options->settings.tile = rf_default_tile( estimator );
    return RF_OK;
}

RfResult rf_parse_tile_option( RfRenderOptions* options, RfError* error )
{
    if ( options->tile == NULL )
        return RF_OK;
    if ( rf_parse_tile( options->tile, &options->settings.tile ) )
        return RF_OK;
    return rf_fail( error, RF_ERROR_USAGE,
                    "--tile: wants 1, WxH such as 3x3, or rooksN such as rooks16, of at most %d pixels, got '%s'",
                    RF_MAX_TILE_PIXELS, options->tile );
}

RfResult rf_parse_aov_option( RfRenderOptions* options, RfError* error )
{
    RfError reason = { 0 };
    RfResult result = rf_parse_aovs( options->aov, &options->settings.aovs, &reason );
    options->settings.aovs |= options->alpha ? RF_AOV_BIT( RF_AOV_ALPHA ) : 0u;
    return result == RF_OK ? result : rf_fail( error, result, "--aov: %.1000s", reason.text );
}

RfResult rf_settle_render_options( RfRenderOptions* options, RfError* error )
{
    RfRenderSettings* settings = &options->settings;
    take_words( options );
    if ( settings->adaptive == RF_ADAPTIVE_ON && settings->weights != RF_WEIGHTS_EXACT )
        return rf_fail( error, RF_ERROR_USAGE, "--adaptive: wants --weights exact, not %s",
                        rf_weights_name( settings->weights ) );
    RfResult result = rf_parse_estimator_option( options, error );
    if ( result == RF_OK )
        rf_settle_filter( options );
    if ( result == RF_OK && strcmp( options->estimator, "gradient" ) != 0 &&
         options->reconstruction != RF_RECONSTRUCTION_WEIGHTED )
        return rf_fail( error, RF_ERROR_USAGE, "--reconstruction: wants --estimator gradient" );
    if ( result == RF_OK )
        result = rf_parse_tile_option( options, error );
    if ( result == RF_OK )
        result = rf_parse_aov_option( options, error );
    if ( result == RF_OK )
        result = rf_parse_effect_options( options, error );
    if ( ( settings->noise > 0.0 || settings->time > 0.0 ) && !options->spp_given )
        settings->spp = rf_default_most_spp( settings->noise );
    return result;
}

// Parses on top of the current values.
static RfResult parse( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error )
{
    RfResult result = rf_parse_options( &s_table, argc, argv, &s_parsed.scene, help, error );
    if ( result != RF_OK || *help )
        return result;
    result = check( &s_parsed, error );
    s_parsed.settings.files.compression = (RfExrCompression)s_compression_index;
    if ( s_float_given )
        s_parsed.settings.files.half = !s_float;
    *options = s_parsed;
    return result == RF_OK ? rf_settle_render_options( options, error ) : result;
}

RfResult rf_parse_render_options( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error )
{
    reset();
    return parse( argc, argv, options, help, error );
}

RfResult rf_read_render_defaults( const RfField* defaults, RfRenderOptions* options )
{
    reset();
    RfError error = { 0 };
    RfField tile = rf_field_member( defaults, "tile" ), aov = rf_field_member( defaults, "aov" ),
            no_effect = rf_field_member( defaults, "no_effect" );
    RfField estimator = rf_field_member( defaults, "estimator" );
    RfResult result = rf_take_file_options( &s_table, defaults );
    if ( result == RF_OK && rf_parse_estimator_option( &s_parsed, &error ) != RF_OK )
        result = rf_fail_file_option( &estimator, &error );
    if ( result == RF_OK && rf_parse_tile_option( &s_parsed, &error ) != RF_OK )
        result = rf_fail_file_option( &tile, &error );
    if ( result == RF_OK && rf_parse_aov_option( &s_parsed, &error ) != RF_OK )
        result = rf_fail_file_option( &aov, &error );
    if ( result == RF_OK && rf_parse_effect_options( &s_parsed, &error ) != RF_OK )
        result = rf_fail_file_option( &no_effect, &error );
    take_words( &s_parsed );
    *options = s_parsed;
    return result;
}

RfResult rf_read_reuse_defaults( const RfField* defaults, RfRenderOptions* options )
{
    RfError error = { 0 };
    RfField estimator = rf_field_member( defaults, "estimator" );
    RfResult result = rf_read_render_defaults( defaults, options );
    if ( result != RF_OK || options->settings.estimator == rf_default_render_settings().estimator )
        return result;
    rf_fail( &error, RF_ERROR_USAGE, "--estimator: plan, tune and cost know the estimator reuse only" );
    return rf_fail_file_option( &estimator, &error );
}

RfResult rf_parse_render_options_over( const RfField* defaults, int argc, char** argv, RfRenderOptions* options, RfError* error )
{
    bool help;
    RfResult result = rf_read_render_defaults( defaults, options );
    return result == RF_OK ? parse( argc, argv, options, &help, error ) : result;
}

void rf_print_render_help( void ) { rf_print_help( &s_table, stdout ); }
