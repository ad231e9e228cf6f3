// What is to be rendered, and how: samples, groups, tiles, filters, estimators, when to stop.
#ifndef REFRAME_REFRAME_RENDER_SETTINGS_H
#define REFRAME_REFRAME_RENDER_SETTINGS_H

#include "reframe/aov.h"
#include "reframe/error.h"
#include "reframe/image.h"
#include "reframe/types.h"

RF_API_BEGIN

// How reused samples are weighted.
typedef enum RfWeights
{
    RF_WEIGHTS_EXACT,      // the balance heuristic over all cameras: unbiased
    RF_WEIGHTS_EQ15,       // (15) of Reusing Frames in Camera Animation: biased, for comparison
    RF_WEIGHTS_UNWEIGHTED, // all hits of a pixel averaged: biased, for comparison
} RfWeights;

// How the sum A of weighted samples is divided by the sum B of weights.
typedef enum RfNormalize
{
    RF_NORMALIZE_CROSSFIT, // by a B that does not depend on the samples: unbiased
    RF_NORMALIZE_RATIO,    // A/B: small bias
    RF_NORMALIZE_NONE,     // A: unbiased, noisy
} RfNormalize;

// How samples count in the pixels around them. The width w of each is Blender's.
typedef enum RfFilter
{
    RF_FILTER_BOX,             // evenly over a square of w pixels: with w = 1 in their own pixel, which is fastest
    RF_FILTER_TENT,            // falls linearly to 0 at w pixels
    RF_FILTER_GAUSSIAN,        // a standard deviation of w/4, cut off at w pixels
    RF_FILTER_BLACKMAN_HARRIS, // a window that reaches w pixels to each side
} RfFilter;

#define RF_MIN_FILTER_WIDTH 0.5 // pixels
#define RF_MAX_FILTER_WIDTH 4.0

// "box", "tent", "gaussian", "blackman-harris".
const char* rf_filter_name( RfFilter filter );

// 1 pixel for box and tent, 1.5 for the others.
double rf_default_filter_width( RfFilter filter );

// "exact", "eq15", "unweighted".
const char* rf_weights_name( RfWeights weights );

// "crossfit", "ratio", "none".
const char* rf_normalize_name( RfNormalize normalize );

// How the estimator "gradient" makes a picture of pixels and differences of neighbours.
typedef enum RfReconstruction
{
    RF_RECONSTRUCTION_WEIGHTED, // least squares, weighted by variances estimated from the other half of the samples: unbiased
    RF_RECONSTRUCTION_L2,       // least squares with constant weights: unbiased
    RF_RECONSTRUCTION_L1,       // least absolute differences: robust, but biased
    RF_RECONSTRUCTION_NONE,     // the pixels alone, for comparison: unbiased
} RfReconstruction;

// "weighted", "l2", "l1", "none".
const char* rf_reconstruction_name( RfReconstruction reconstruction );

typedef struct RfGuide RfGuide;

// Whether scattering draws directions by where light comes from, as a pilot has learned. Any guide leaves the picture's mean as it is.
typedef enum RfGuiding
{
    RF_GUIDE_AUTO, // where the pilot finds that it pays; off where it cannot be had
    RF_GUIDE_ON,   // wherever anything is learned; an error where it cannot be had
    RF_GUIDE_OFF,
} RfGuiding;

// "auto", "on", "off".
const char* rf_guiding_name( RfGuiding guiding );

// Extra own-frame samples for pixels that few other frames help.
typedef enum RfAdaptive
{
    RF_ADAPTIVE_AUTO, // in frames where a coarse look finds that they pay; off where they cannot be had
    RF_ADAPTIVE_ON,   // wherever they pay; an error where they cannot be had
    RF_ADAPTIVE_OFF,
} RfAdaptive;

// "auto", "on", "off".
const char* rf_adaptive_name( RfAdaptive adaptive );

// Light paths through mirrors and glass, connected to what the cameras see by manifold walks (src/light_paths/README.md).
typedef enum RfLightPathsUse
{
    RF_LIGHT_PATHS_ON,
    RF_LIGHT_PATHS_OFF,
} RfLightPathsUse;

// "on", "off".
const char* rf_light_paths_name( RfLightPathsUse use );

// How a connection to a light path is divided by the probability of finding it.
typedef enum RfKernelNormalization
{
    RF_KERNEL_EXACT,   // by repeated trials: unbiased
    RF_KERNEL_DISC,    // as if every light path near enough were found: biased, for comparison
    RF_KERNEL_DENSITY, // no connections: density estimation by the same footprints, as in photon mapping; blurred, for comparison
} RfKernelNormalization;

// "exact", "disc", "density".
const char* rf_kernel_normalization_name( RfKernelNormalization normalization );

// How the lights of a vertex are sampled.
typedef enum RfLightSampling
{
    RF_LIGHTS_BY_TREE,  // in proportion to what they may send to the vertex; by power where there are few
    RF_LIGHTS_BY_POWER, // wherever the vertex is: for comparison
} RfLightSampling;

typedef enum RfTileKind
{
    RF_TILE_NONE,  // no reuse between pixels
    RF_TILE_BLOCK, // width × height neighbours
    RF_TILE_ROOKS, // N pixels of an N × N grid, each row and column used once; N tiles make up the grid
    RF_TILE_AUTO,  // what the plan chooses (reframe/plan.h), or where there is no choice the estimator's own
} RfTileKind;

// A set of pixels of one frame that reuse each other's paths.
typedef struct RfTile
{
    RfTileKind kind;
    int width, height; // of a block, pixels; both N with rooks; not used without tiles
} RfTile;

#define RF_MAX_TILE_PIXELS 64
#define RF_TILE_NAME_SIZE 24

// "auto", "1", "WxH" or "rooksN" with at most RF_MAX_TILE_PIXELS pixels to a tile; false where it is none of
// them. Tiles of one pixel are RF_TILE_NONE.
bool rf_parse_tile( const char* text, RfTile* tile );

// The name that parses to it.
void rf_tile_name( const RfTile* tile, char text[RF_TILE_NAME_SIZE] );

// What the channels of a file are called, and the conventions that go with it (src/output/names.h).
typedef enum RfPassNames
{
    RF_NAMES_REFRAME,   // R, depth.Z, motion.X
    RF_NAMES_BLENDER,   // ViewLayer.Combined.R, ViewLayer.Depth.Z, ViewLayer.Vector.X
    RF_NAMES_BLENDER_5, // the same, with the names that passes have from Blender 5.0 on: ViewLayer.Object Index.X
    RF_NAMES_NUKE,      // R, depth.Z, backward.u
} RfPassNames;

typedef enum RfFileParts
{
    RF_PARTS_ONE,  // all channels in one part
    RF_PARTS_EACH, // a part for each pass, that of the colour first
} RfFileParts;

// The files that callbacks->frame writes: their format. The memory for writing one is part of the
// budget.
typedef struct RfFrameFiles
{
    bool written; // else the rest does not matter
    bool half;    // 16-bit floats for colour, albedo and normal; else 32 bits for all
    RfExrCompression compression;
    float dwa_level;            // of DWAA and DWAB
    RfColourSpace colour_space; // of colours, variances too
    RfPassNames names;
    RfFileParts parts;
    const char* denoiser;  // by which frames are denoised before they are written (rf_denoiser_name); NULL: they are not
    const char* time_code; // of the path's first frame, "01:00:00:00" (rf_check_time_code); NULL: 0 is that of number 0
} RfFrameFiles;

// Files of 16-bit floats, ZIP, as rf_write_frame writes them for the settings' `files`.
RfFrameFiles rf_default_frame_files( void );

// How the pixels of a frame are estimated.
typedef struct RfEstimator RfEstimator;

// The estimator called `name`; NULL where there is none. "reuse" is the one of frames and tiles, "gradient" that of
// gradient-domain path reusing.
const RfEstimator* rf_find_estimator( const char* name );

// The estimators by number from 0 on; NULL beyond the last.
const RfEstimator* rf_estimator_at( int index );

// The name that finds it.
const char* rf_estimator_name( const RfEstimator* estimator );

// The tile that it has where none is asked for.
RfTile rf_default_tile( const RfEstimator* estimator );

// Its pixel filter: Blackman-Harris, which has the least noise and flicker at equal CPU time, or the box of one pixel where
// the estimator ("gradient") gains nothing by another.
RfFilter rf_default_filter( const RfEstimator* estimator );

// The parts of the frames that alone are traced (render/pieces.h).
typedef struct RfPieces RfPieces;

// What is to be rendered, and how. From rf_default_render_settings.
typedef struct RfRenderSettings
{
    const RfEstimator* estimator; // by default "reuse"
    int spp;                      // samples that a frame traces per pixel; with noise, flicker or time the most
    double noise;                 // each frame stops when its estimated relMSE is at most this; 0: spp are rendered
    double flicker;               // and each pair of neighbouring frames when its estimated f1_relative (reframe/measure.h) is
    double time;                  // seconds for each frame asked for, on average; 0: as long as it takes
    int group;                    // half-width n, cut to the path; RF_GROUP_AUTO: chosen by the plan
    RfTile tile;                  // pixels of a frame that reuse each other's paths
    double clamp;                 // what one path may bring to a hit, luminance; RF_CLAMP_AUTO: found by a pilot; 0: any light
    double clamp_chains;          // likewise a light that camera rays find by mirrors and glass; 0: as `clamp`
    RfGuiding guide;              // of paths, by what a pilot over the whole path of the camera has learned
    const RfGuide* learned; // and what it has learned (rf_learn_guide_of), unless RF_GUIDE_OFF; NULL: each render has a pilot
    RfAdaptive adaptive;    // extra samples for pixels that few other frames help; RF_WEIGHTS_EXACT only
    RfWeights weights;
    RfNormalize normalize;
    RfReconstruction reconstruction; // of "gradient"
    int max_depth;                   // path vertices after the camera; RF_MAX_DEPTH: Russian roulette alone ends paths
    int light_samples;               // per vertex
    RfFilter filter;                 // of the pixels; depth and motion have the box of one pixel whatever it is
    double filter_width;             // pixels; 0: the filter's default
    RfLightSampling light_sampling;
    RfLightPathsUse light_paths; // RF_WEIGHTS_EXACT only
    RfKernelNormalization kernel_normalization;
    uint64_t seed;
    int threads;          // 0: all cores
    size_t memory;        // budget in bytes, beyond scene and BVH; 0: half of what is free
    int queue;            // finished frames, at most, that callbacks->frame is given in a thread of its own
                          // while rendering goes on; fewer where memory is short. 0: it is called in between
    unsigned aovs;        // RF_AOV_BIT of the AOVs that are wanted besides the colour, which they do not change; with
                          // tiles of one pixel RF_PASS_AOVS change its noise
    unsigned cryptomatte; // a set of RF_CRYPTOMATTE_OBJECT and so on (reframe/aov.h); 0: none
    // By which the picture is split as well, each a layer of the frame: "all" that the scene names, "lamps": each lamp and each
    // material that emits, or names by comma; NULL: it is not split. Kept by the caller
    const char* light_groups;
    RfFrameFiles files;     // rf_default_frame_files where callbacks->frame writes files
    const RfPieces* pieces; // NULL: whole frames; else not with noise, flicker, time or extra samples
} RfRenderSettings;

#define RF_GROUP_AUTO ( -1 )
#define RF_CLAMP_AUTO ( -1.0 )
// Limits, of the program's options and of scene files too.
#define RF_MAX_SPP ( 1 << 20 )
#define RF_MAX_NOISE 1e6
#define RF_MAX_FLICKER 1e6
#define RF_MAX_TIME 1e9
#define RF_MAX_CLAMP 1e30
#define RF_MAX_GROUP ( 1 << 20 )
#define RF_MAX_DEPTH ( 1 << 15 )
#define RF_MAX_LIGHT_SAMPLES 64
#define RF_MAX_QUEUE 64
#define RF_MAX_THREADS 1024
#define RF_MAX_IMAGE_SIDE ( 1 << 15 ) // pixels

// The defaults, which are the program's too: 28 samples, the group that the plan chooses, tiles of 3×3, extra samples where
// they pay, exact weights, the estimator's filter, paths of any length, seed 1, all cores, half of the free memory, no AOVs, no files, no
// light paths, no clamp.
RfRenderSettings rf_default_render_settings( void );

// Sets the estimator, with its own tile and filter.
void rf_use_estimator( RfRenderSettings* settings, const RfEstimator* estimator );

// The program's limit of samples per pixel where a relMSE or an F1 is to be reached, and where both are 0: for a time.
int rf_default_most_spp( double noise, double flicker );

RF_API_END

#endif
