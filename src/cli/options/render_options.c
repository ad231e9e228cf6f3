// What is made of the options of `reframe render`.
#include "cli/options/render_options.h"

#include "cli/options/file_options.h"
#include "cli/options/options.h"
#include "cli/options/shot_options.h"
#include "output/names.h"
#include "reframe/camera.h"
#include "reframe/effects.h"
#include "reframe/render.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// What a parse has found so far. Every parse starts from the defaults; the result is copied out.
typedef struct RenderParse
{
    RfRenderOptions options;
    int compression; // index of its word
    bool is_float, is_float_given, is_half_given;
} RenderParse;

// --shutter, --fstop and --focus.

#define MAX_SHUTTER 100.0 // frames

static bool parse_number( const char* text, const char* end, double* number )
{
    char* stop;
    *number = strtod( text, &stop );
    return stop == end && stop > text && isfinite( *number ) != 0;
}

static bool parse_shutter( const char* text, double shutter[2] )
{
    const char *end = text + strlen( text ), *comma = strchr( text, ',' );
    double length;
    if ( comma != NULL )
        return parse_number( text, comma, shutter ) && parse_number( comma + 1, end, shutter + 1 ) && shutter[0] <= shutter[1] &&
               shutter[0] >= -MAX_SHUTTER && shutter[1] <= MAX_SHUTTER;
    if ( !parse_number( text, end, &length ) || length < 0.0 || length > MAX_SHUTTER )
        return false;
    shutter[0] = -0.5 * length;
    shutter[1] = 0.5 * length;
    return true;
}

RfResult rf_parse_lens_options( const RfRenderOptions* options, RfLens* lens, RfError* error )
{
    *lens = ( RfLens ){ .has_shutter = options->shutter != NULL, .has_fstop = options->fstop_given, .fstop = options->fstop };
    if ( options->shutter != NULL && !parse_shutter( options->shutter, lens->shutter ) )
        return rf_fail( error, RF_ERROR_USAGE,
                        "--shutter %.80s: want frames, 0 to %g, as 0.5, or when it opens and closes, as -0.25,0.25",
                        options->shutter, MAX_SHUTTER );
    if ( options->focus == NULL )
        return RF_OK;
    bool number = parse_number( options->focus, options->focus + strlen( options->focus ), &lens->focus );
    if ( number && !( lens->focus > 0.0 && lens->focus <= 1e6 ) )
        return rf_fail( error, RF_ERROR_USAGE, "--focus %.80s: want metres above 0, or the name of a node", options->focus );
    if ( !number )
        lens->focus = 0.0;
    lens->focus_node = number ? NULL : options->focus;
    return RF_OK;
}

const char* const rf_effects_words[] = { "auto", "all", NULL };

// What decides on effects that cannot be left out of a scene, and what to type instead.
typedef struct Instead
{
    const char* option;
    const char* type;
} Instead;

static const Instead s_instead[RF_EFFECT_COUNT] = {
    [RF_EFFECT_CAMERA_ANIMATION] = { NULL, "render a still by --frames 1" },
    [RF_EFFECT_SMOOTH_METALS] = { NULL, "give --no-effect chains" },
    [RF_EFFECT_LIGHT_PATHS] = { "--light-paths", "give --light-paths off" },
    [RF_EFFECT_FRAME_GROUPS] = { "--group", "give --group 0" },
    [RF_EFFECT_TILE_CONNECTIONS] = { "--tile", "give --tile 1" },
    [RF_EFFECT_ADAPTIVE] = { "--adaptive", "give --no-adaptive" },
    [RF_EFFECT_STOP_RULE] = { "--noise, --flicker, --time", "leave --noise, --flicker and --time out" },
    [RF_EFFECT_PIXEL_FILTER] = { "--filter", "give --filter box" },
    [RF_EFFECT_OTHER_PROJECTION] = { NULL, "render along a path of a camera in perspective" },
    [RF_EFFECT_GRADIENTS] = { "--estimator", "give --estimator reuse" },
    [RF_EFFECT_ALPHA] = { "--alpha", "give --no-alpha" },
};

const char* rf_effect_option( RfEffectId effect ) { return s_instead[effect].option; }

// Sets options->left_out from --no-effect. Fails with RF_ERROR_USAGE.
static RfResult parse_effect_options( RfRenderOptions* options, RfError* error )
{
    RfError reason = { 0 };
    RfResult result = rf_parse_effects( options->no_effect, &options->left_out, &reason );
    if ( result != RF_OK )
        return rf_fail( error, result, "--no-effect: %.1000s", reason.text );
    for ( int i = 0; i < RF_EFFECT_COUNT; ++i )
    {
        RfEffectId id = (RfEffectId)i;
        if ( ( options->left_out & RF_EFFECT_BIT( i ) ) == 0 || rf_effect_without( id ) != RF_WITHOUT_IMPOSSIBLE )
            continue;
        return rf_fail( error, RF_ERROR_USAGE, "--no-effect: %s cannot be left out of a scene: %s", rf_effect_name( id ),
                        s_instead[i].type != NULL ? s_instead[i].type : rf_effect_without_text( id ) );
    }
    return RF_OK;
}

// Options may call for a lens where no camera of the scene does.
static bool may_be_called_for( const RfEffect* row )
{
    return row->on || row->id == RF_EFFECT_DEPTH_OF_FIELD || row->id == RF_EFFECT_MOTION_BLUR;
}

static void warn_of( const RfEffect* row, RfLog* log )
{
    const char* text = rf_effect_without_text( row->id );
    if ( !may_be_called_for( row ) )
        rf_warn( log, "--no-effect %s: changes nothing: %s", row->name, row->why );
    else if ( rf_effect_without( row->id ) == RF_WITHOUT_OTHER_PICTURE )
        rf_warn( log, "--no-effect %s: the picture is another than the scene asks for: %s", row->name, text );
    else
        rf_warn( log, "--no-effect %s: the picture is the same in the mean, with other noise: %s", row->name, text );
}

RfResult rf_take_effect_options( const RfRenderOptions* options, RfScene* scene, RfLog* log, RfError* error )
{
    RfEffect rows[RF_MAX_EFFECTS];
    RfRenderOptions parsed = *options;
    RfResult result = parse_effect_options( &parsed, error );
    if ( result != RF_OK )
        return result;
    uint64_t forced = options->effects == RF_EFFECTS_ALL ? rf_forcible_effects() & ~parsed.left_out : 0;
    int count = parsed.left_out != 0 ? rf_list_render_effects( scene, NULL, 0, &options->settings, rows ) : 0;
    result = rf_choose_effects( scene, forced, parsed.left_out, error );
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        if ( ( parsed.left_out & RF_EFFECT_BIT( rows[i].id ) ) != 0 )
            warn_of( rows + i, log );
    }
    return result;
}

// The options of `reframe render`, a row each.

static const char* const s_compressions[] = { "none", "zip", "piz", NULL }; // in the order of RfExrCompression
static const char* const s_files[] = { "SCENE" };

static RenderParse render_parse;

static const RfOption s_options[] = {
    { .name = "output",
      .writes = "",
      .letter = 'o',
      .type = RF_OPTION_STRING,
      .value = &render_parse.options.output,
      .meta = "PATTERN",
      .help = "where the frames go: out/frame.####.exr, #### (or %04d) is the frame's number; its folder is made" },
    { .name = "camera",
      .reads = true,
      .type = RF_OPTION_STRING,
      .value = &render_parse.options.camera,
      .meta = "NAME|FILE",
      .default_text = "the scene file's, else the first animated one, else the first",
      .help = "a camera of the scene, or a camera-path file (.json)" },
    { .name = "frames",
      .in_file = true,
      .type = RF_OPTION_STRING,
      .value = &render_parse.options.frames,
      .meta = "A-B[xSTEP][,...]",
      .default_text = "all",
      .help = "frames by their numbers, as in Blender, else from 1; negative ones count from the end" },
    { .name = "fps",
      .in_file = true,
      .type = RF_OPTION_FPS,
      .value = &render_parse.options.fps,
      .meta = "R",
      .default_text = "the scene's, else 24",
      .help = "frames per second of the camera's path, 24 or 24000/1001" },
    { .name = "size",
      .in_file = true,
      .type = RF_OPTION_SIZE,
      .value = &render_parse.options.size,
      .min = 1,
      .max = RF_MAX_IMAGE_SIDE,
      .meta = "WxH",
      .default_text = "the scene's, else 960x540",
      .help = "pixels; also 720p, 1080p, 1440p, 2160p or 4k" },
    RF_LENS_OPTIONS( render_parse.options, true ),
    RF_EFFECT_OPTIONS( render_parse.options, true ),
    { .name = "spp",
      .in_file = true,
      .type = RF_OPTION_INT,
      .value = &render_parse.options.settings.spp,
      .min = 1,
      .max = 1048576,
      .meta = "S",
      .given = &render_parse.options.spp_given,
      .default_text = "28; with --noise or --flicker 65536, with --time 1048576",
      .help = "samples traced per pixel and frame in all, over the groups that hold the frame; the most that --noise, --flicker "
              "and --time may take" },
    { .name = "noise",
      .in_file = true,
      .type = RF_OPTION_RATIO,
      .value = &render_parse.options.settings.noise,
      .min = 0,
      .max = RF_MAX_NOISE,
      .meta = "E",
      .default_text = "0: off",
      .help = "every frame is rendered until its estimated relMSE is at most E; 1% is 0.01" },
    { .name = "flicker",
      .in_file = true,
      .type = RF_OPTION_RATIO,
      .value = &render_parse.options.settings.flicker,
      .min = 0,
      .max = RF_MAX_FLICKER,
      .meta = "F",
      .default_text = "0: off",
      .help =
          "neighbouring frames are rendered until the estimated F1 of every pair (reframe flicker) is at most F; with --noise, "
          "both hold" },
    { .name = "time",
      .in_file = true,
      .type = RF_OPTION_TIME,
      .value = &render_parse.options.settings.time,
      .min = 0,
      .max = RF_MAX_TIME,
      .meta = "T",
      .default_text = "0: off",
      .help = "seconds of rendering for each frame asked for, on average, also 20s, 5m, 1h30m; with --noise or --flicker, "
              "whichever comes first" },
    { .name = "group",
      .in_file = true,
      .type = RF_OPTION_INT,
      .value = &render_parse.options.settings.group,
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
      .value = &render_parse.options.estimator,
      .meta = "reuse|gradient",
      .default_text = "reuse",
      .help = "how pixels are estimated: reuse of frames and tiles, or gradient-domain path reusing, which has tiles but no "
              "groups" },
    { .name = "tile",
      .in_file = true,
      .type = RF_OPTION_STRING,
      .value = &render_parse.options.tile,
      .meta = "WxH|rooksN|1",
      .default_text = "3x3; with --estimator gradient 4x4",
      .help = "pixels of a frame that share their paths: blocks, N of an NxN grid, or none" },
    { .name = "adaptive",
      .in_file = true,
      .type = RF_OPTION_CHOICE,
      .value = &render_parse.options.adaptive,
      .choices = rf_adaptive_words,
      .bare = "on",
      .negated = "off",
      .default_text = "auto",
      .help = "extra samples for pixels that few other frames help: borders, what comes into view, mirrors, glass, and more "
              "where these are noisy; auto: in frames where they pay. --adaptive alone is on, --no-adaptive is off" },
    { .name = "light-paths",
      .in_file = true,
      .type = RF_OPTION_CHOICE,
      .value = &render_parse.options.light_paths,
      .choices = rf_light_paths_words,
      .default_text = "off",
      .help = "light that mirrors and glass send on, by paths from the lights that serve all frames of a group: caustics, lamps "
              "behind glass; auto: of lamps without size and of small emitters alone, where it pays" },
    { .name = "kernel-normalization",
      .in_file = true,
      .type = RF_OPTION_CHOICE,
      .value = &render_parse.options.kernel_normalization,
      .choices = rf_kernel_normalization_words,
      .default_text = "exact",
      .help = "of --light-paths: how connections are divided by their probability; disc is faster and biased, density is photon "
              "mapping "
              "by the same footprints, both for comparison" },
    { .name = "weights",
      .in_file = true,
      .type = RF_OPTION_CHOICE,
      .value = &render_parse.options.weights,
      .choices = rf_weights_words,
      .default_text = "exact",
      .help = "how reused paths are weighted; the others are biased, for comparison" },
    { .name = "normalize",
      .in_file = true,
      .type = RF_OPTION_CHOICE,
      .value = &render_parse.options.normalize,
      .choices = rf_normalize_words,
      .default_text = "crossfit",
      .help = "how the sum of weights is divided out" },
    { .name = "reconstruction",
      .in_file = true,
      .type = RF_OPTION_CHOICE,
      .value = &render_parse.options.reconstruction,
      .choices = rf_reconstruction_words,
      .default_text = "weighted",
      .help =
          "of --estimator gradient: least squares weighted by the other half's variances, or by constants; l1 is biased; none: "
          "the pixels without their differences" },
    RF_FILTER_OPTIONS( render_parse.options, true ),
    { .name = "max-depth",
      .in_file = true,
      .type = RF_OPTION_INT,
      .value = &render_parse.options.settings.max_depth,
      .min = 1,
      .max = 1000,
      .meta = "D",
      .default_text = "12",
      .help = "path vertices after the eye" },
    { .name = "light-samples",
      .in_file = true,
      .type = RF_OPTION_INT,
      .value = &render_parse.options.settings.light_samples,
      .min = 1,
      .max = 64,
      .meta = "K",
      .default_text = "1",
      .help = "light samples per vertex; with tiles first hits have two at least" },
    { .name = "seed",
      .in_file = true,
      .type = RF_OPTION_UINT64,
      .value = &render_parse.options.settings.seed,
      .meta = "S",
      .default_text = "1",
      .help = "of the random numbers" },
    { .name = "memory",
      .type = RF_OPTION_MEMORY,
      .value = &render_parse.options.settings.memory,
      .min = 1048576,
      .meta = "SIZE",
      .default_text = "half of what is free",
      .help = "budget beyond the scene and its BVH: 512M, 4G" },
    { .name = "threads",
      .type = RF_OPTION_INT,
      .value = &render_parse.options.settings.threads,
      .min = 1,
      .max = 1024,
      .meta = "T",
      .default_text = "all cores",
      .help = "threads; the pictures do not depend on them" },
    RF_AOV_OPTION( render_parse.options, "further channels of each frame:" ),
    { .name = "alpha",
      .in_file = true,
      .type = RF_OPTION_BOOL,
      .value = &render_parse.options.alpha,
      .default_text = "no",
      .help = "RGBA: coverage of each pixel by what is not sky; the colour is premultiplied, without the sky behind things" },
    { .name = "compression",
      .type = RF_OPTION_CHOICE,
      .value = &render_parse.compression,
      .choices = s_compressions,
      .default_text = "zip",
      .help = "of the EXR files" },
    { .name = "half",
      .type = RF_OPTION_BOOL,
      .value = &render_parse.options.settings.files.half,
      .given = &render_parse.is_half_given,
      .default_text = "yes",
      .help = "16-bit floats for the colour and the AOVs that need no more" },
    { .name = "float",
      .type = RF_OPTION_BOOL,
      .value = &render_parse.is_float,
      .given = &render_parse.is_float_given,
      .default_text = "no",
      .help = "32-bit floats for all channels" },
    { .name = "resume",
      .type = RF_OPTION_BOOL,
      .value = &render_parse.options.resume,
      .help = "keep the frames that are there and of this very render; others are an error, or replaced with --overwrite" },
    { .name = "overwrite",
      .type = RF_OPTION_BOOL,
      .value = &render_parse.options.overwrite,
      .help = "replace the frames that are there, with --resume only those of another render" },
    { .name = "check",
      .type = RF_OPTION_BOOL,
      .value = &render_parse.options.check,
      .help = "render nothing: tell which frames are there, whole and of this very render; exit status 1 unless all are" },
    RF_NODES_OPTION( render_parse.options, "with --check: the ranges for N machines that the other frames are cut into" ),
    { .name = "json",
      .writes = ".json",
      .type = RF_OPTION_STRING,
      .value = &render_parse.options.json,
      .meta = "FILE",
      .help = "the result for programs, also of an interrupted render; - is standard output" },
    { .name = "quiet", .type = RF_OPTION_BOOL, .value = &render_parse.options.quiet, .help = "no progress" },
};

static const RfCommandTable render_table = { .command = "render",
                                             .summary =
                                                 "Renders a camera's path to a sequence of EXR files. SCENE is a .glb, a .gltf "
                                                 "or a scene file (.json), which may hold defaults of these options.",
                                             .files = s_files,
                                             .file_count = 1,
                                             .options = s_options,
                                             .option_count = sizeof s_options / sizeof s_options[0] };

#define WRITE_QUEUE 2                  // frames: one being written, one waiting
#define MOST_SPP_FOR_NOISE ( 1 << 16 ) // noise that has not come down by then will not

int rf_default_most_spp( double noise, double flicker )
{
    return isgreater( noise, 0.0 ) || isgreater( flicker, 0.0 ) ? MOST_SPP_FOR_NOISE : RF_MAX_SPP;
}

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
    if ( render_parse.is_half_given && render_parse.is_float_given && options->settings.files.half == render_parse.is_float )
        return rf_fail( error, RF_ERROR_USAGE, "--half and --float: only one of the two" );
    if ( options->nodes > 0 && !options->check )
        return rf_fail( error, RF_ERROR_USAGE, "--nodes: is of --check here; reframe plan has it, too" );
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
    render_parse.options = rf_default_render_options();
    render_parse.is_float = render_parse.is_float_given = render_parse.is_half_given = false;
    render_parse.compression = render_parse.options.settings.files.compression;
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
        result = parse_effect_options( options, error );
    if ( ( settings->noise > 0.0 || settings->flicker > 0.0 || settings->time > 0.0 ) && !options->spp_given )
        settings->spp = rf_default_most_spp( settings->noise, settings->flicker );
    return result;
}

// Parses on top of the current values.
static RfResult parse( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error )
{
    RfResult result = rf_parse_options( &render_table, argc, argv, &render_parse.options.scene, help, error );
    if ( result != RF_OK || *help )
        return result;
    result = check( &render_parse.options, error );
    render_parse.options.settings.files.compression = (RfExrCompression)render_parse.compression;
    if ( render_parse.is_float_given )
        render_parse.options.settings.files.half = !render_parse.is_float;
    *options = render_parse.options;
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
    RfResult result = rf_take_file_options( &render_table, defaults );
    if ( result == RF_OK && rf_parse_estimator_option( &render_parse.options, &error ) != RF_OK )
        result = rf_fail_file_option( &estimator, &error );
    if ( result == RF_OK && rf_parse_tile_option( &render_parse.options, &error ) != RF_OK )
        result = rf_fail_file_option( &tile, &error );
    if ( result == RF_OK && rf_parse_aov_option( &render_parse.options, &error ) != RF_OK )
        result = rf_fail_file_option( &aov, &error );
    if ( result == RF_OK && parse_effect_options( &render_parse.options, &error ) != RF_OK )
        result = rf_fail_file_option( &no_effect, &error );
    take_words( &render_parse.options );
    *options = render_parse.options;
    return result;
}

RfResult rf_parse_render_options_over( const RfField* defaults, int argc, char** argv, RfRenderOptions* options, RfError* error )
{
    bool help;
    RfResult result = rf_read_render_defaults( defaults, options );
    return result == RF_OK ? parse( argc, argv, options, &help, error ) : result;
}

void rf_print_render_help( void ) { rf_print_help( &render_table, stdout ); }
