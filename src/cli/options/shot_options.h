// Rows that the option tables of render, plan, tune and cost share. `o` is the
// RfRenderOptions that they fill; help texts that differ are arguments.
#ifndef REFRAME_CLI_OPTIONS_SHOT_OPTIONS_H
#define REFRAME_CLI_OPTIONS_SHOT_OPTIONS_H

#include "cli/options/render_options.h"
#include "output/names.h"

#define RF_PATH_OPTIONS( o, frames_help )                                                                                        \
    { .name = "camera",                                                                                                          \
      .reads = true,                                                                                                             \
      .type = RF_OPTION_STRING,                                                                                                  \
      .value = &( o ).camera,                                                                                                    \
      .meta = "NAME|FILE",                                                                                                       \
      .default_text = "the scene file's, else the first animated one, else the first",                                           \
      .help = "a camera of the scene, or a camera-path file (.json)" },                                                          \
        { .name = "frames",                                                                                                      \
          .type = RF_OPTION_STRING,                                                                                              \
          .value = &( o ).frames,                                                                                                \
          .meta = "A-B[xSTEP][,...]",                                                                                            \
          .default_text = "all",                                                                                                 \
          .help = ( frames_help ) },                                                                                             \
        { .name = "fps",                                                                                                         \
          .type = RF_OPTION_FPS,                                                                                                 \
          .value = &( o ).fps,                                                                                                   \
          .meta = "R",                                                                                                           \
          .default_text = "the scene's, else 24",                                                                                \
          .help = "frames per second of the camera's path, 24 or 24000/1001" },                                                  \
    {                                                                                                                            \
        .name = "size", .type = RF_OPTION_SIZE, .value = &( o ).size, .min = 1, .max = RF_MAX_IMAGE_SIDE, .meta = "WxH",         \
        .default_text = "the scene's, else 960x540", .help = "pixels; also 720p, 1080p, 1440p, 2160p or 4k"                      \
    }

// A lens and a shutter in the place of the camera's own. `file`: a scene file's defaults may have them.
#define RF_LENS_OPTIONS( o, file )                                                                                               \
    { .name = "shutter",                                                                                                         \
      .in_file = ( file ),                                                                                                       \
      .type = RF_OPTION_STRING,                                                                                                  \
      .value = &( o ).shutter,                                                                                                   \
      .meta = "LENGTH|OPEN,CLOSE",                                                                                               \
      .default_text = "the camera's",                                                                                            \
      .help = "frames that the shutter is open, about each frame's time: the camera's motion blurs the picture; 0: no blur" },   \
        { .name = "fstop",                                                                                                       \
          .in_file = ( file ),                                                                                                   \
          .type = RF_OPTION_REAL,                                                                                                \
          .value = &( o ).fstop,                                                                                                 \
          .given = &( o ).fstop_given,                                                                                           \
          .min = 0,                                                                                                              \
          .max = 1000000,                                                                                                        \
          .meta = "N",                                                                                                           \
          .default_text = "the camera's",                                                                                        \
          .help = "f-number of the lens; 0: a pinhole, all is sharp" },                                                          \
    {                                                                                                                            \
        .name = "focus", .in_file = ( file ), .type = RF_OPTION_STRING, .value = &( o ).focus, .meta = "METRES|NODE",            \
        .default_text = "the camera's", .help = "what is sharp: what lies this far along the view, or at a node of the scene"    \
    }

// Effects that are forced or left out. `file`: a scene file's defaults may have them.
#define RF_EFFECT_OPTIONS( o, file )                                                                                             \
    { .name = "effects",                                                                                                         \
      .in_file = ( file ),                                                                                                       \
      .type = RF_OPTION_CHOICE,                                                                                                  \
      .value = &( o ).effects,                                                                                                   \
      .choices = rf_effects_words,                                                                                               \
      .default_text = "auto",                                                                                                    \
      .help = "auto: code runs for effects that the scene calls for; all: for the others, too, where that is possible, for the " \
              "same picture to rounding" },                                                                                      \
    {                                                                                                                            \
        .name = "no-effect", .in_file = ( file ), .type = RF_OPTION_STRING, .value = &( o ).no_effect, .meta = "NAME[,...]",     \
        .default_text = "none", .help = "leaves effects out, by their names in reframe info: the picture may be another then"    \
    }

#define RF_SPP_OPTION( o )                                                                                                       \
    {                                                                                                                            \
        .name = "spp", .type = RF_OPTION_INT, .value = &( o ).settings.spp, .min = 1, .max = RF_MAX_SPP, .meta = "S",            \
        .default_text = "28", .help = "samples traced per pixel and frame in all, over the groups that hold the frame"           \
    }

#define RF_ESTIMATOR_OPTION( o )                                                                                                 \
    {                                                                                                                            \
        .name = "estimator", .type = RF_OPTION_STRING, .value = &( o ).estimator, .meta = "reuse|gradient",                      \
        .default_text = "reuse", .help = "how pixels are estimated: reuse of frames and tiles, or gradient-domain path reusing"  \
    }

#define RF_TILE_OPTION( o )                                                                                                      \
    {                                                                                                                            \
        .name = "tile", .type = RF_OPTION_STRING, .value = &( o ).tile, .meta = "WxH|rooksN|1",                                  \
        .default_text = "3x3; with --estimator gradient 4x4",                                                                    \
        .help = "pixels of a frame that share their paths: blocks, N of an NxN grid, or none"                                    \
    }

#define RF_LIGHT_OPTIONS( o )                                                                                                    \
    { .name = "max-depth",                                                                                                       \
      .type = RF_OPTION_INT,                                                                                                     \
      .value = &( o ).settings.max_depth,                                                                                        \
      .min = 1,                                                                                                                  \
      .max = 1000,                                                                                                               \
      .meta = "D",                                                                                                               \
      .default_text = "12",                                                                                                      \
      .help = "path vertices after the eye" },                                                                                   \
    {                                                                                                                            \
        .name = "light-samples", .type = RF_OPTION_INT, .value = &( o ).settings.light_samples, .min = 1,                        \
        .max = RF_MAX_LIGHT_SAMPLES, .meta = "K", .default_text = "1",                                                           \
        .help = "light samples per vertex; with tiles first hits have two at least"                                              \
    }

// `file`: a scene file's defaults may have them.
#define RF_FILTER_OPTIONS( o, file )                                                                                             \
    { .name = "filter",                                                                                                          \
      .in_file = ( file ),                                                                                                       \
      .type = RF_OPTION_CHOICE,                                                                                                  \
      .value = &( o ).filter,                                                                                                    \
      .choices = rf_filter_words,                                                                                                \
      .default_text = "blackman-harris, of --estimator gradient box",                                                            \
      .help = "how samples count in the pixels around them; depth and motion always have the box of one pixel" },                \
    {                                                                                                                            \
        .name = "filter-width", .in_file = ( file ), .type = RF_OPTION_REAL, .value = &( o ).settings.filter_width,              \
        .min = RF_MIN_FILTER_WIDTH, .max = RF_MAX_FILTER_WIDTH, .meta = "PIXELS",                                                \
        .default_text = "1; gaussian and blackman-harris 1.5",                                                                   \
        .help = "as in Blender: of a box, from side to side; the others reach so far to each side"                               \
    }

#define RF_MAX_NODES 10000

#define RF_NODES_OPTION( o, nodes_help )                                                                                         \
    {                                                                                                                            \
        .name = "nodes", .type = RF_OPTION_INT, .value = &( o ).nodes, .min = 1, .max = RF_MAX_NODES, .meta = "N",               \
        .default_text = "none", .help = ( nodes_help )                                                                           \
    }

#define RF_SEED_OPTION( o )                                                                                                      \
    {                                                                                                                            \
        .name = "seed", .type = RF_OPTION_UINT64, .value = &( o ).settings.seed, .meta = "S", .default_text = "1",               \
        .help = "of the random numbers"                                                                                          \
    }

#define RF_MACHINE_OPTIONS( o, threads_help )                                                                                    \
    { .name = "memory",                                                                                                          \
      .type = RF_OPTION_MEMORY,                                                                                                  \
      .value = &( o ).settings.memory,                                                                                           \
      .min = 1048576,                                                                                                            \
      .meta = "SIZE",                                                                                                            \
      .default_text = "half of what is free",                                                                                    \
      .help = "budget beyond the scene and its BVH: 512M, 4G" },                                                                 \
    {                                                                                                                            \
        .name = "threads", .type = RF_OPTION_INT, .value = &( o ).settings.threads, .min = 1, .max = 1024, .meta = "T",          \
        .default_text = "all cores", .help = ( threads_help )                                                                    \
    }

#define RF_AOV_NAME( constant, name, letters, half, source, what ) " " name
#define RF_AOV_OPTION( o, intro )                                                                                                \
    {                                                                                                                            \
        .name = "aov", .in_file = true, .type = RF_OPTION_STRING, .value = &( o ).aov, .meta = "AOV[,...]",                      \
        .default_text = "none", .help = intro RF_AOV_LIST( RF_AOV_NAME ) "; " RF_GRADIENT_AOVS_NAME " are the last three"        \
    }

#define RF_RESULT_OPTIONS( o, quiet_help )                                                                                       \
    { .name = "json",                                                                                                            \
      .writes = ".json",                                                                                                         \
      .type = RF_OPTION_STRING,                                                                                                  \
      .value = &( o ).json,                                                                                                      \
      .meta = "FILE",                                                                                                            \
      .help = "the result for programs; - is standard output" },                                                                 \
    {                                                                                                                            \
        .name = "quiet", .type = RF_OPTION_BOOL, .value = &( o ).quiet, .help = ( quiet_help )                                   \
    }

#endif
