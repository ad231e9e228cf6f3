// Rows that the option tables of render, tune and cost share. `o` is the
// RfRenderOptions that they fill; help texts that differ are arguments.
#ifndef REFRAME_CLI_OPTIONS_SHARED_OPTIONS_H
#define REFRAME_CLI_OPTIONS_SHARED_OPTIONS_H

#include "cli/options/render_options.h"
#include "estimators/estimators.h"
#include "film/pixel_filter.h"
#include "output/names.h"
#include "reframe/camera.h"

#define RF_MIN_BUDGET 1048576 // bytes of --memory: below, a unit was forgotten
#define RF_MAX_NODES 10000

// The defaults of these are printed from what rf_default_render_options and the library say.
typedef struct RfDefaultTexts
{
    char spp[80], tile[80], filter[80], filter_width[80];
} RfDefaultTexts;
extern RfDefaultTexts rf_default_texts;

// Where the camera is: `frames_help` says what is done with the frames.
#define RF_PATH_OPTIONS( o, frames_help )                                                                                        \
    RF_TEXT_OPTION( "camera", &( o ).camera, "NAME|FILE", "camera of the scene, or camera-path file (.json)", .reads = true,     \
                    .default_text = "the scene file's, else the first animated one, else the first" ),                           \
        RF_TEXT_OPTION( "frames", &( o ).frames, "[@]A-B[xSTEP][,...]", ( frames_help ), .in_file = true,                        \
                        .default_text = "all" ),                                                                                 \
        RF_FPS_OPTION(                                                                                                           \
            "fps", &( o ).fps, "R",                                                                                              \
            "frames per second of the camera animation: 24, 30000/1001; 23.976, 29.97, 59.94 stand for such fractions",          \
            .in_file = true, .default_text = "the scene's, else 24" ),                                                           \
        RF_SIZE_OPTION( "size", &( o ).size, 1, RF_MAX_IMAGE_SIDE, "WxH",                                                        \
                        "resolution in pixels; also 720p, 1080p, 1440p, 2160p or 4k", .in_file = true,                           \
                        .default_text = "the scene's, else the pixels of 960x540 in the camera's aspect ratio" ),                \
        RF_TEXT_OPTION( "overscan", &( o ).overscan, "N|N%",                                                                     \
                        "render pixels beyond the picture as well, N on each side or N% of its width and height",                \
                        .in_file = true, .default_text = "none" )

// What of the file is rendered: which materials, and what moves besides the camera.
#define RF_MOVEMENT_OPTIONS( o )                                                                                                 \
    RF_TEXT_OPTION( "animation", &( o ).movement.animation, "NAME",                                                              \
                    "animation of the glTF that is rendered, where several move the same", .in_file = true,                      \
                    .default_text = "the first" ),                                                                               \
        RF_TEXT_OPTION( "variant", &( o ).movement.variant, "NAME",                                                              \
                        "variant of the glTF, as reframe info lists them: other materials for its meshes", .in_file = true,      \
                        .default_text = "the meshes' own materials" ),                                                           \
        RF_FLAG_OPTION( "accept-losses", &( o ).movement.accept_losses,                                                          \
                        "leave textures out that cannot be read, with a warning; else they are an error" ),                      \
        RF_FLAG_OPTION( "freeze", &( o ).movement.freeze,                                                                        \
                        "move only the camera: all else stands still as in the first frame of the scene's own camera",           \
                        .in_file = true )

// A lens and a shutter in the place of the camera's own.
#define RF_LENS_OPTIONS( o )                                                                                                     \
    RF_TEXT_OPTION( "shutter", &( o ).shutter, "LENGTH|OPEN,CLOSE",                                                              \
                    "shutter time in frames, centred on the frame, or opening and closing time; 0: no motion blur",              \
                    .in_file = true, .default_text = "the camera's" ),                                                           \
        RF_INT_OPTION(                                                                                                           \
            "blur-steps", &( o ).blur_steps, 1, RF_MAX_BLUR_STEPS, "N",                                                          \
            "straight steps in which what moves is blurred while the shutter is open; what turns by 30 degrees in one "          \
            "shrinks by 3 % on the way",                                                                                         \
            .in_file = true ),                                                                                                   \
        RF_REAL_OPTION( "fstop", &( o ).fstop, 0, RF_MAX_FSTOP, "N", "f-number of the lens; 0: pinhole, no depth of field",      \
                        .in_file = true, .given = &( o ).fstop_given, .default_text = "the camera's" ),                          \
        RF_TEXT_OPTION( "focus", &( o ).focus, "METRES|NODE", "focus distance in metres, or scene node to focus on",             \
                        .in_file = true, .default_text = "the camera's" )

#define RF_SPP_HELP                                                                                                              \
    "samples traced per pixel and frame; effective samples are all that land in a pixel, with those reused from other frames"

// Of a render that may stop at an error or after a time.
#define RF_STOP_OPTIONS( o, noise_help, flicker_help, time_help )                                                                \
    RF_INT_OPTION( "spp", &( o ).settings.spp, 1, RF_MAX_SPP, "S", RF_SPP_HELP "; the limit with --noise, --flicker and --time", \
                   .in_file = true, .given = &( o ).spp_given, .default_text = rf_default_texts.spp,                             \
                   .heading = RF_HEADING_QUALITY ),                                                                              \
        RF_NOISE_OPTION( "noise", &( o ).settings.noise, 0, RF_MAX_NOISE, "E", ( noise_help ), .in_file = true,                  \
                         .default_text = "off", .heading = RF_HEADING_QUALITY ),                                                 \
        RF_FLICKER_OPTION( "flicker", &( o ).settings.flicker, 0, RF_MAX_FLICKER, "F", ( flicker_help ), .in_file = true,        \
                           .default_text = "off", .heading = RF_HEADING_QUALITY ),                                               \
        RF_TIME_OPTION( "time", &( o ).settings.time, 0, RF_MAX_TIME, "T", ( time_help ), .in_file = true,                       \
                        .default_text = "off", .heading = RF_HEADING_QUALITY )

#define RF_ADAPTIVE_OPTION( o, adaptive_help )                                                                                   \
    RF_CHOICE_OPTION( "adaptive", RF_ENUM( &( o ).settings.adaptive ), rf_adaptive_words, ( adaptive_help ), .in_file = true,    \
                      .bare = "on", .negated = "off", .heading = RF_HEADING_QUALITY )

#define RF_CLAMP_OPTION( o, clamp_help )                                                                                         \
    RF_REAL_OPTION( "clamp", &( o ).settings.clamp, 0, RF_MAX_CLAMP, "off|auto|VALUE", ( clamp_help ), .in_file = true,          \
                    .keyword = "auto", .keyword_value = (int)RF_CLAMP_AUTO, .negated = "off", .default_text = "off",             \
                    .heading = RF_HEADING_QUALITY ),                                                                             \
        RF_REAL_OPTION( "clamp-chains", &( o ).settings.clamp_chains, 0, RF_MAX_CLAMP, "VALUE",                                  \
                        "with --clamp: the limit of a light that is seen by mirrors and glass", .in_file = true,                 \
                        .default_text = "as --clamp", .heading = RF_HEADING_QUALITY )

#define RF_FILTER_OPTIONS( o )                                                                                                   \
    RF_CHOICE_OPTION( "filter", &( o ).filter, rf_filter_words,                                                                  \
                      "reconstruction filter; depth and motion always use a box of one pixel", .in_file = true,                  \
                      .default_text = rf_default_texts.filter, .heading = RF_HEADING_QUALITY ),                                  \
        RF_REAL_OPTION( "filter-width", &( o ).settings.filter_width, RF_MIN_FILTER_WIDTH, RF_MAX_FILTER_WIDTH, "PIXELS",        \
                        "filter width as in Blender: full width of the box, radius of the others", .in_file = true,              \
                        .default_text = rf_default_texts.filter_width, .heading = RF_HEADING_QUALITY )

#define RF_PATH_TRACING_OPTIONS( o )                                                                                             \
    RF_INT_OPTION( "max-depth", &( o ).settings.max_depth, 1, RF_MAX_DEPTH, "D|none",                                            \
                   "maximum number of path vertices after the camera; the light beyond is missing", .in_file = true,             \
                   .keyword = "none", .keyword_value = RF_MAX_DEPTH, .default_text = "the glTF's, else none",                    \
                   .heading = RF_HEADING_QUALITY ),                                                                              \
        RF_INT_OPTION( "light-samples", &( o ).settings.light_samples, 1, RF_MAX_LIGHT_SAMPLES, "K",                             \
                       "light samples per path vertex; with tiles, at least two at first hits", .in_file = true,                 \
                       .heading = RF_HEADING_QUALITY ),                                                                          \
        RF_CHOICE_OPTION( "guide", RF_ENUM( &( o ).settings.guide ), rf_guiding_words,                                           \
                          "guide paths to where light comes from, as a pilot over the whole camera path learns it, in rooms "    \
                          "lit through gaps and doors; auto: where the pilot finds that it pays off",                            \
                          .in_file = true, .heading = RF_HEADING_QUALITY )

#define RF_SEED_OPTION( o )                                                                                                      \
    RF_UINT64_OPTION( "seed", &( o ).settings.seed, "S", "random seed", .in_file = true, .heading = RF_HEADING_QUALITY )

#define RF_GROUP_OPTION( o, group_help )                                                                                         \
    RF_INT_OPTION( "group", &( o ).settings.group, 0, RF_MAX_GROUP, "N|auto", ( group_help ), .in_file = true,                   \
                   .keyword = "auto", .keyword_value = RF_GROUP_AUTO, .heading = RF_HEADING_PERFORMANCE )

#define RF_TILE_OPTION( o )                                                                                                      \
    RF_TEXT_OPTION(                                                                                                              \
        "tile", &( o ).tile, "auto|WxH|rooksN|1",                                                                                \
        "pixels of a frame that share paths: a block, an N-rooks pattern, or 1 for none; auto: what pays for this path",         \
        .in_file = true, .default_text = rf_default_texts.tile, .heading = RF_HEADING_PERFORMANCE )

#define RF_MACHINE_OPTIONS( o, threads_help )                                                                                    \
    RF_MEMORY_OPTION( "memory", &( o ).settings.memory, RF_MIN_BUDGET, "SIZE",                                                   \
                      "memory budget beyond the scene and its BVH: 512M, 4G", .default_text = "half of free memory",             \
                      .heading = RF_HEADING_PERFORMANCE ),                                                                       \
        RF_INT_OPTION( "threads", &( o ).settings.threads, 1, RF_MAX_THREADS, "T", ( threads_help ),                             \
                       .default_text = "all cores", .heading = RF_HEADING_PERFORMANCE )

#define RF_DENOISER_OPTION( to )                                                                                                 \
    RF_TEXT_OPTION( "denoiser", &( to ), "FILE", "library of Open Image Denoise 2, libOpenImageDenoise.so.2", .reads = true,     \
                    .default_text = "$REFRAME_OIDN, else the system's, the cache's, Blender's or Python's",                      \
                    .heading = RF_HEADING_OUTPUT )

#define RF_NODES_OPTION( o, nodes_help )                                                                                         \
    RF_INT_OPTION( "nodes", &( o ).nodes, 1, RF_MAX_NODES, "N", ( nodes_help ), .heading = RF_HEADING_PERFORMANCE )

#define RF_ESTIMATOR_WHAT( name, what ) "; " #name ": " what
#define RF_ESTIMATOR_OPTION( o )                                                                                                 \
    RF_CHOICE_OPTION( "estimator", &( o ).estimator, rf_estimator_words,                                                         \
                      "how pixels are estimated" RF_ESTIMATOR_LIST( RF_ESTIMATOR_WHAT ), .in_file = true,                        \
                      .heading = RF_HEADING_RESEARCH )

#define RF_WEIGHT_OPTIONS( o )                                                                                                   \
    RF_CHOICE_OPTION( "weights", RF_ENUM( &( o ).settings.weights ), rf_weights_words,                                           \
                      "weights of reused paths; eq15 and unweighted are biased, for comparison", .in_file = true,                \
                      .heading = RF_HEADING_RESEARCH ),                                                                          \
        RF_CHOICE_OPTION( "normalize", RF_ENUM( &( o ).settings.normalize ), rf_normalize_words,                                 \
                          "normalisation of the weights: crossfit and none are unbiased, none is noisy", .in_file = true,        \
                          .heading = RF_HEADING_RESEARCH )

// Effects that are forced or left out.
#define RF_EFFECT_OPTIONS( o )                                                                                                   \
    RF_CHOICE_OPTION(                                                                                                            \
        "effects", &( o ).effects, rf_effects_words,                                                                             \
        "auto: run code only for effects that the scene uses; all: for the others too where possible, with the same picture "    \
        "up to rounding",                                                                                                        \
        .in_file = true, .heading = RF_HEADING_RESEARCH ),                                                                       \
        RF_TEXT_OPTION( "no-effect", &( o ).no_effect, "NAME[,...]",                                                             \
                        "leave out effects, named as in reframe info; the picture may change", .in_file = true,                  \
                        .heading = RF_HEADING_RESEARCH )

#define RF_AOV_NAME( constant, name, letters, half, source, what ) " " name
#define RF_AOV_OPTION( o, intro )                                                                                                \
    RF_TEXT_OPTION( "aov", &( o ).aov, "AOV[,...]",                                                                              \
                    intro RF_AOV_LIST( RF_AOV_NAME ) "; emission to transmission add up to the picture; " RF_GRADIENT_AOVS_NAME  \
                                                     " stands for the last three",                                               \
                    .in_file = true, .heading = RF_HEADING_PASSES )

#define RF_CRYPTOMATTE_OPTION( o, intro )                                                                                        \
    RF_TEXT_OPTION( "cryptomatte", &( o ).cryptomatte, "KIND[,...]",                                                             \
                    intro                                                                                                        \
                    " object, material, asset (the topmost object above an object); by names, of which compositors make mattes", \
                    .in_file = true, .default_text = "none", .heading = RF_HEADING_PASSES )

#define RF_LIGHT_GROUPS_OPTION( o, intro )                                                                                       \
    RF_TEXT_OPTION( "light-groups", &( o ).settings.light_groups, "all|lamps|NAME[,...]",                                        \
                    intro                                                                                                        \
                    " all that the scene names (reframe info lists them), every lamp and emitting material by its name, or "     \
                    "groups and lights by name; the light of no group is \"rest\"",                                              \
                    .in_file = true, .default_text = "none", .heading = RF_HEADING_PASSES )

#define RF_RESULT_OPTIONS( o, json_help, quiet_help )                                                                            \
    RF_TEXT_OPTION( "json", &( o ).json, "FILE", ( json_help ), .writes = ".json", .heading = RF_HEADING_OUTPUT ),               \
        RF_FLAG_OPTION( "quiet", &( o ).quiet, ( quiet_help ), .heading = RF_HEADING_OUTPUT )

#endif
