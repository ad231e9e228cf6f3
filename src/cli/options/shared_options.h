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
    { .name = "camera",                                                                                                          \
      .type = RF_OPTION_STRING,                                                                                                  \
      .value = &( o ).camera,                                                                                                    \
      .reads = true,                                                                                                             \
      .meta = "NAME|FILE",                                                                                                       \
      .default_text = "the scene file's, else the first animated one, else the first",                                           \
      .help = "camera of the scene, or camera-path file (.json)" },                                                              \
        { .name = "frames",                                                                                                      \
          .in_file = true,                                                                                                       \
          .type = RF_OPTION_STRING,                                                                                              \
          .value = &( o ).frames,                                                                                                \
          .meta = "[@]A-B[xSTEP][,...]",                                                                                         \
          .default_text = "all",                                                                                                 \
          .help = ( frames_help ) },                                                                                             \
        { .name = "fps",                                                                                                         \
          .in_file = true,                                                                                                       \
          .type = RF_OPTION_FPS,                                                                                                 \
          .value = &( o ).fps,                                                                                                   \
          .meta = "R",                                                                                                           \
          .default_text = "the scene's, else 24",                                                                                \
          .help = "frames per second of the camera animation: 24, 30000/1001; 23.976, 29.97, 59.94 stand for such fractions" },  \
        { .name = "size",                                                                                                        \
          .in_file = true,                                                                                                       \
          .type = RF_OPTION_SIZE,                                                                                                \
          .value = &( o ).size,                                                                                                  \
          .min = 1,                                                                                                              \
          .max = RF_MAX_IMAGE_SIDE,                                                                                              \
          .meta = "WxH",                                                                                                         \
          .default_text = "the scene's, else the pixels of 960x540 in the camera's aspect ratio",                                \
          .help = "resolution in pixels; also 720p, 1080p, 1440p, 2160p or 4k" },                                                \
    {                                                                                                                            \
        .name = "overscan", .in_file = true, .type = RF_OPTION_STRING, .value = &( o ).overscan, .meta = "N|N%",                 \
        .default_text = "none", .help = "render pixels beyond the picture as well, N on each side or N% of its width and height" \
    }

// What of the file is rendered: which materials, and what moves besides the camera.
#define RF_MOVEMENT_OPTIONS( o )                                                                                                 \
    { .name = "animation",                                                                                                       \
      .in_file = true,                                                                                                           \
      .type = RF_OPTION_STRING,                                                                                                  \
      .value = &( o ).movement.animation,                                                                                        \
      .meta = "NAME",                                                                                                            \
      .default_text = "the first",                                                                                               \
      .help = "animation of the glTF that is rendered, where several move the same" },                                           \
        { .name = "variant",                                                                                                     \
          .in_file = true,                                                                                                       \
          .type = RF_OPTION_STRING,                                                                                              \
          .value = &( o ).movement.variant,                                                                                      \
          .meta = "NAME",                                                                                                        \
          .default_text = "the meshes' own materials",                                                                           \
          .help = "variant of the glTF, as reframe info lists them: other materials for its meshes" },                           \
    {                                                                                                                            \
        .name = "freeze", .in_file = true, .type = RF_OPTION_BOOL, .value = &( o ).movement.freeze,                              \
        .help = "move only the camera: all else stands still as in the first frame of the scene's own camera"                    \
    }

// A lens and a shutter in the place of the camera's own.
#define RF_LENS_OPTIONS( o )                                                                                                     \
    { .name = "shutter",                                                                                                         \
      .in_file = true,                                                                                                           \
      .type = RF_OPTION_STRING,                                                                                                  \
      .value = &( o ).shutter,                                                                                                   \
      .meta = "LENGTH|OPEN,CLOSE",                                                                                               \
      .default_text = "the camera's",                                                                                            \
      .help = "shutter time in frames, centred on the frame, or opening and closing time; 0: no motion blur" },                  \
        { .name = "blur-steps",                                                                                                  \
          .in_file = true,                                                                                                       \
          .type = RF_OPTION_INT,                                                                                                 \
          .value = &( o ).blur_steps,                                                                                            \
          .min = 1,                                                                                                              \
          .max = RF_MAX_BLUR_STEPS,                                                                                              \
          .meta = "N",                                                                                                           \
          .help = "straight steps in which what moves is blurred while the shutter is open; what turns by 30 degrees in one "    \
                  "shrinks by 3 % on the way" },                                                                                 \
        { .name = "fstop",                                                                                                       \
          .in_file = true,                                                                                                       \
          .type = RF_OPTION_REAL,                                                                                                \
          .value = &( o ).fstop,                                                                                                 \
          .given = &( o ).fstop_given,                                                                                           \
          .min = 0,                                                                                                              \
          .max = RF_MAX_FSTOP,                                                                                                   \
          .meta = "N",                                                                                                           \
          .default_text = "the camera's",                                                                                        \
          .help = "f-number of the lens; 0: pinhole, no depth of field" },                                                       \
    {                                                                                                                            \
        .name = "focus", .in_file = true, .type = RF_OPTION_STRING, .value = &( o ).focus, .meta = "METRES|NODE",                \
        .default_text = "the camera's", .help = "focus distance in metres, or scene node to focus on"                            \
    }

#define RF_SPP_HELP                                                                                                              \
    "samples traced per pixel and frame; effective samples are all that land in a pixel, with those reused from other frames"

#define RF_SPP_OPTION( o )                                                                                                       \
    {                                                                                                                            \
        .name = "spp", .in_file = true, .type = RF_OPTION_INT, .value = &( o ).settings.spp, .min = 1, .max = RF_MAX_SPP,        \
        .meta = "S", .heading = RF_HEADING_QUALITY, .help = RF_SPP_HELP                                                          \
    }

// Of a render that may stop at an error or after a time.
#define RF_STOP_OPTIONS( o, noise_help, flicker_help, time_help )                                                                \
    { .name = "spp",                                                                                                             \
      .in_file = true,                                                                                                           \
      .type = RF_OPTION_INT,                                                                                                     \
      .value = &( o ).settings.spp,                                                                                              \
      .given = &( o ).spp_given,                                                                                                 \
      .min = 1,                                                                                                                  \
      .max = RF_MAX_SPP,                                                                                                         \
      .meta = "S",                                                                                                               \
      .default_text = rf_default_texts.spp,                                                                                      \
      .heading = RF_HEADING_QUALITY,                                                                                             \
      .help = RF_SPP_HELP "; the limit with --noise, --flicker and --time" },                                                    \
        { .name = "noise",                                                                                                       \
          .in_file = true,                                                                                                       \
          .type = RF_OPTION_NOISE,                                                                                               \
          .value = &( o ).settings.noise,                                                                                        \
          .min = 0,                                                                                                              \
          .max = RF_MAX_NOISE,                                                                                                   \
          .meta = "E",                                                                                                           \
          .default_text = "off",                                                                                                 \
          .heading = RF_HEADING_QUALITY,                                                                                         \
          .help = ( noise_help ) },                                                                                              \
        { .name = "flicker",                                                                                                     \
          .in_file = true,                                                                                                       \
          .type = RF_OPTION_REAL,                                                                                                \
          .value = &( o ).settings.flicker,                                                                                      \
          .min = 0,                                                                                                              \
          .max = RF_MAX_FLICKER,                                                                                                 \
          .meta = "F",                                                                                                           \
          .default_text = "off",                                                                                                 \
          .heading = RF_HEADING_QUALITY,                                                                                         \
          .help = ( flicker_help ) },                                                                                            \
    {                                                                                                                            \
        .name = "time", .in_file = true, .type = RF_OPTION_TIME, .value = &( o ).settings.time, .min = 0, .max = RF_MAX_TIME,    \
        .meta = "T", .default_text = "off", .heading = RF_HEADING_QUALITY, .help = ( time_help )                                 \
    }

#define RF_ADAPTIVE_OPTION( o, adaptive_help )                                                                                   \
    {                                                                                                                            \
        .name = "adaptive", .in_file = true, .type = RF_OPTION_CHOICE, .value = &( o ).adaptive, .choices = rf_adaptive_words,   \
        .bare = "on", .negated = "off", .heading = RF_HEADING_QUALITY, .help = ( adaptive_help )                                 \
    }

#define RF_CLAMP_OPTION( o, clamp_help )                                                                                         \
    { .name = "clamp",                                                                                                           \
      .in_file = true,                                                                                                           \
      .type = RF_OPTION_REAL,                                                                                                    \
      .value = &( o ).settings.clamp,                                                                                            \
      .min = 0,                                                                                                                  \
      .max = RF_MAX_CLAMP,                                                                                                       \
      .keyword = "auto",                                                                                                         \
      .keyword_value = (int)RF_CLAMP_AUTO,                                                                                       \
      .negated = "off",                                                                                                          \
      .meta = "off|auto|VALUE",                                                                                                  \
      .default_text = "off",                                                                                                     \
      .heading = RF_HEADING_QUALITY,                                                                                             \
      .help = ( clamp_help ) },                                                                                                  \
    {                                                                                                                            \
        .name = "clamp-chains", .in_file = true, .type = RF_OPTION_REAL, .value = &( o ).settings.clamp_chains, .min = 0,        \
        .max = RF_MAX_CLAMP, .meta = "VALUE", .default_text = "as --clamp", .heading = RF_HEADING_QUALITY,                       \
        .help = "with --clamp: the limit of a light that is seen by mirrors and glass"                                           \
    }

#define RF_FILTER_OPTIONS( o )                                                                                                   \
    { .name = "filter",                                                                                                          \
      .in_file = true,                                                                                                           \
      .type = RF_OPTION_CHOICE,                                                                                                  \
      .value = &( o ).filter,                                                                                                    \
      .choices = rf_filter_words,                                                                                                \
      .default_text = rf_default_texts.filter,                                                                                   \
      .heading = RF_HEADING_QUALITY,                                                                                             \
      .help = "reconstruction filter; depth and motion always use a box of one pixel" },                                         \
    {                                                                                                                            \
        .name = "filter-width", .in_file = true, .type = RF_OPTION_REAL, .value = &( o ).settings.filter_width,                  \
        .min = RF_MIN_FILTER_WIDTH, .max = RF_MAX_FILTER_WIDTH, .meta = "PIXELS", .default_text = rf_default_texts.filter_width, \
        .heading = RF_HEADING_QUALITY, .help = "filter width as in Blender: full width of the box, radius of the others"         \
    }

#define RF_PATH_TRACING_OPTIONS( o )                                                                                             \
    { .name = "max-depth",                                                                                                       \
      .in_file = true,                                                                                                           \
      .type = RF_OPTION_INT,                                                                                                     \
      .value = &( o ).settings.max_depth,                                                                                        \
      .min = 1,                                                                                                                  \
      .max = RF_MAX_DEPTH,                                                                                                       \
      .keyword = "none",                                                                                                         \
      .keyword_value = RF_MAX_DEPTH,                                                                                             \
      .meta = "D|none",                                                                                                          \
      .heading = RF_HEADING_QUALITY,                                                                                             \
      .help = "maximum number of path vertices after the camera; the light beyond is missing" },                                 \
    {                                                                                                                            \
        .name = "light-samples", .in_file = true, .type = RF_OPTION_INT, .value = &( o ).settings.light_samples, .min = 1,       \
        .max = RF_MAX_LIGHT_SAMPLES, .meta = "K", .heading = RF_HEADING_QUALITY,                                                 \
        .help = "light samples per path vertex; with tiles, at least two at first hits"                                          \
    }

#define RF_SEED_OPTION( o )                                                                                                      \
    {                                                                                                                            \
        .name = "seed", .in_file = true, .type = RF_OPTION_UINT64, .value = &( o ).settings.seed, .meta = "S",                   \
        .heading = RF_HEADING_QUALITY, .help = "random seed"                                                                     \
    }

#define RF_GROUP_OPTION( o, group_help )                                                                                         \
    {                                                                                                                            \
        .name = "group", .in_file = true, .type = RF_OPTION_INT, .value = &( o ).settings.group, .min = 0, .max = RF_MAX_GROUP,  \
        .keyword = "auto", .keyword_value = RF_GROUP_AUTO, .meta = "N|auto", .heading = RF_HEADING_PERFORMANCE,                  \
        .help = ( group_help )                                                                                                   \
    }

#define RF_TILE_OPTION( o )                                                                                                      \
    {                                                                                                                            \
        .name = "tile", .in_file = true, .type = RF_OPTION_STRING, .value = &( o ).tile, .meta = "WxH|rooksN|1",                 \
        .default_text = rf_default_texts.tile, .heading = RF_HEADING_PERFORMANCE,                                                \
        .help = "pixels of a frame that share paths: a block, an N-rooks pattern, or 1 for none"                                 \
    }

#define RF_MACHINE_OPTIONS( o, threads_help )                                                                                    \
    { .name = "memory",                                                                                                          \
      .type = RF_OPTION_MEMORY,                                                                                                  \
      .value = &( o ).settings.memory,                                                                                           \
      .min = RF_MIN_BUDGET,                                                                                                      \
      .meta = "SIZE",                                                                                                            \
      .default_text = "half of free memory",                                                                                     \
      .heading = RF_HEADING_PERFORMANCE,                                                                                         \
      .help = "memory budget beyond the scene and its BVH: 512M, 4G" },                                                          \
    {                                                                                                                            \
        .name = "threads", .type = RF_OPTION_INT, .value = &( o ).settings.threads, .min = 1, .max = RF_MAX_THREADS,             \
        .meta = "T", .default_text = "all cores", .heading = RF_HEADING_PERFORMANCE, .help = ( threads_help )                    \
    }

#define RF_NODES_OPTION( o, nodes_help )                                                                                         \
    {                                                                                                                            \
        .name = "nodes", .type = RF_OPTION_INT, .value = &( o ).nodes, .min = 1, .max = RF_MAX_NODES, .meta = "N",               \
        .heading = RF_HEADING_PERFORMANCE, .help = ( nodes_help )                                                                \
    }

#define RF_ESTIMATOR_WHAT( name, what ) "; " #name ": " what
#define RF_ESTIMATOR_OPTION( o )                                                                                                 \
    {                                                                                                                            \
        .name = "estimator", .in_file = true, .type = RF_OPTION_CHOICE, .value = &( o ).estimator,                               \
        .choices = rf_estimator_words, .heading = RF_HEADING_RESEARCH,                                                           \
        .help = "how pixels are estimated" RF_ESTIMATOR_LIST( RF_ESTIMATOR_WHAT )                                                \
    }

#define RF_WEIGHT_OPTIONS( o )                                                                                                   \
    { .name = "weights",                                                                                                         \
      .in_file = true,                                                                                                           \
      .type = RF_OPTION_CHOICE,                                                                                                  \
      .value = &( o ).weights,                                                                                                   \
      .choices = rf_weights_words,                                                                                               \
      .heading = RF_HEADING_RESEARCH,                                                                                            \
      .help = "weights of reused paths; eq15 and unweighted are biased, for comparison" },                                       \
    {                                                                                                                            \
        .name = "normalize", .in_file = true, .type = RF_OPTION_CHOICE, .value = &( o ).normalize,                               \
        .choices = rf_normalize_words, .heading = RF_HEADING_RESEARCH,                                                           \
        .help = "normalisation of the weights: crossfit and none are unbiased, none is noisy"                                    \
    }

// Effects that are forced or left out.
#define RF_EFFECT_OPTIONS( o )                                                                                                   \
    { .name = "effects",                                                                                                         \
      .in_file = true,                                                                                                           \
      .type = RF_OPTION_CHOICE,                                                                                                  \
      .value = &( o ).effects,                                                                                                   \
      .choices = rf_effects_words,                                                                                               \
      .heading = RF_HEADING_RESEARCH,                                                                                            \
      .help =                                                                                                                    \
          "auto: run code only for effects that the scene uses; all: for the others too where possible, with the same picture "  \
          "up to rounding" },                                                                                                    \
    {                                                                                                                            \
        .name = "no-effect", .in_file = true, .type = RF_OPTION_STRING, .value = &( o ).no_effect, .meta = "NAME[,...]",         \
        .heading = RF_HEADING_RESEARCH, .help = "leave out effects, named as in reframe info; the picture may change"            \
    }

#define RF_AOV_NAME( constant, name, letters, half, source, what ) " " name
#define RF_AOV_OPTION( o, intro )                                                                                                \
    {                                                                                                                            \
        .name = "aov", .in_file = true, .type = RF_OPTION_STRING, .value = &( o ).aov, .meta = "AOV[,...]",                      \
        .heading = RF_HEADING_PASSES,                                                                                            \
        .help = intro RF_AOV_LIST( RF_AOV_NAME ) "; emission to transmission add up to the picture; " RF_GRADIENT_AOVS_NAME      \
                                                 " stands for the last three"                                                    \
    }

#define RF_CRYPTOMATTE_OPTION( o, intro )                                                                                        \
    {                                                                                                                            \
        .name = "cryptomatte", .in_file = true, .type = RF_OPTION_STRING, .value = &( o ).cryptomatte, .meta = "KIND[,...]",     \
        .default_text = "none", .heading = RF_HEADING_PASSES,                                                                    \
        .help =                                                                                                                  \
            intro " object, material, asset (the topmost object above an object); by names, of which compositors make mattes"    \
    }

#define RF_LIGHT_GROUPS_OPTION( o, intro )                                                                                       \
    {                                                                                                                            \
        .name = "light-groups", .in_file = true, .type = RF_OPTION_STRING, .value = &( o ).settings.light_groups,                \
        .meta = "all|lamps|NAME[,...]", .default_text = "none", .heading = RF_HEADING_PASSES,                                    \
        .help = intro " all that the scene names (reframe info lists them), every lamp and emitting material by its name, or "   \
                      "groups and lights by name; the light of no group is \"rest\""                                             \
    }

#define RF_RESULT_OPTIONS( o, json_help, quiet_help )                                                                            \
    { .name = "json",                                                                                                            \
      .type = RF_OPTION_STRING,                                                                                                  \
      .value = &( o ).json,                                                                                                      \
      .writes = ".json",                                                                                                         \
      .meta = "FILE",                                                                                                            \
      .heading = RF_HEADING_OUTPUT,                                                                                              \
      .help = ( json_help ) },                                                                                                   \
    {                                                                                                                            \
        .name = "quiet", .type = RF_OPTION_BOOL, .value = &( o ).quiet, .heading = RF_HEADING_OUTPUT, .help = ( quiet_help )     \
    }

#endif
