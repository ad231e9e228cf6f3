// The file of a frame: its header, its channels, and how it differs from what is asked for.
#ifndef REFRAME_OUTPUT_FRAME_FILE_H
#define REFRAME_OUTPUT_FRAME_FILE_H

#include "reframe/output.h"
#include "reframe/render.h"

// What the header of a frame's file says of it and of the render it belongs to.

// In the order of the file. Each is there at most once. The last column is what stands for a setting that is not there, "" for one
// that always is, and NULL for what may differ between frames of one render.
#define RF_KEY_LIST( X )                                                                                                         \
    X( VERSION, "reframe/version", "" )                                                                                          \
    X( PICTURES, "reframe/pictures", "0" )                                                                                       \
    X( SCENE, "reframe/scene", NULL )                                                                                            \
    X( CAMERA, "reframe/camera", "" )                                                                                            \
    X( FRAME, "reframe/frame", "" )                                                                                              \
    X( FRAMES, "reframe/frames", "" )                                                                                            \
    X( LOSSES, "reframe/losses", NULL )                                                                                          \
    X( SHOT, "reframe/shot", NULL )                                                                                              \
    X( STEP, "reframe/step", NULL )                                                                                              \
    X( OVERSCAN, "reframe/overscan", "none" )                                                                                    \
    X( NAMES, "reframe/names", "reframe" )                                                                                       \
    X( TIMECODE, "reframe/timecode", "none" )                                                                                    \
    X( COMPRESSION, "reframe/compression", "zip" )                                                                               \
    X( PARTS, "reframe/parts", "one" )                                                                                           \
    X( FLOAT, "reframe/float", "no" )                                                                                            \
    X( COLORSPACE, "reframe/colorspace", "rec709" )                                                                              \
    X( BLUR_STEPS, "reframe/blur-steps", "" )                                                                                    \
    X( GROUP, "reframe/group", "" )                                                                                              \
    X( SPP, "reframe/spp", "" )                                                                                                  \
    X( TILE, "reframe/tile", "" )                                                                                                \
    X( WEIGHTS, "reframe/weights", "" )                                                                                          \
    X( NORMALIZE, "reframe/normalize", "" )                                                                                      \
    X( SEED, "reframe/seed", "" )                                                                                                \
    X( MAX_DEPTH, "reframe/max-depth", "none" )                                                                                  \
    X( BEYOND_DEPTH_SHARE, "reframe/beyond-depth-share", NULL )                                                                  \
    X( LIGHT_SAMPLES, "reframe/light-samples", "" )                                                                              \
    X( FILTER, "reframe/filter", "box" )                                                                                         \
    X( FILTER_WIDTH, "reframe/filter-width", "1" )                                                                               \
    X( ADAPTIVE, "reframe/adaptive", "off" )                                                                                     \
    X( NOISE, "reframe/noise", "0" )                                                                                             \
    X( GUIDE, "reframe/guide", "auto" )                                                                                          \
    X( CLAMP, "reframe/clamp", "off" )                                                                                           \
    X( CLAMP_CHAINS, "reframe/clamp-chains", "none" )                                                                            \
    X( CLAMP_THRESHOLD, "reframe/clamp-threshold", NULL )                                                                        \
    X( CLAMP_THRESHOLD_CHAINS, "reframe/clamp-threshold-chains", NULL )                                                          \
    X( REMOVED_SHARE, "reframe/removed-share", NULL )                                                                            \
    X( FLICKER, "reframe/flicker", "0" )                                                                                         \
    X( TIME, "reframe/time", "0" )                                                                                               \
    X( RELMSE_ESTIMATE, "reframe/relmse-estimate", NULL )                                                                        \
    X( RELMSE_IS_LOWER_BOUND, "reframe/relmse-is-lower-bound", NULL )                                                            \
    X( RELMSE_LIKELY, "reframe/relmse-likely", NULL )                                                                            \
    X( WORST_TEN_SHARE, "reframe/worst-ten-share", NULL )                                                                        \
    X( FLICKER_ESTIMATE, "reframe/flicker-estimate", NULL )                                                                      \
    X( FLICKER_IS_LOWER_BOUND, "reframe/flicker-is-lower-bound", NULL )                                                          \
    X( FLICKER_LIKELY, "reframe/flicker-likely", NULL )                                                                          \
    X( FLICKER_WORST_TEN_SHARE, "reframe/flicker-worst-ten-share", NULL )                                                        \
    X( REACHED, "reframe/reached", NULL )                                                                                        \
    X( NATIVE_SPP, "reframe/native-spp", NULL )                                                                                  \
    X( EFFECTIVE_SPP, "reframe/effective-spp", NULL )                                                                            \
    X( AOV, "reframe/aov", "none" )                                                                                              \
    X( CRYPTOMATTE, "reframe/cryptomatte", "none" )                                                                              \
    X( LIGHT_GROUPS, "reframe/light-groups", "none" )                                                                            \
    X( ESTIMATOR, "reframe/estimator", "" )                                                                                      \
    X( RECONSTRUCTION, "reframe/reconstruction", "weighted" )                                                                    \
    X( LIGHT_PATHS, "reframe/light-paths", "off" )                                                                               \
    X( KERNEL_NORMALIZATION, "reframe/kernel-normalization", "exact" )                                                           \
    X( EFFECTS, "reframe/effects", "auto" )                                                                                      \
    X( NO_EFFECT, "reframe/no-effect", "none" )                                                                                  \
    X( CALLS_FOR, "reframe/calls-for", NULL )                                                                                    \
    X( VIEW, "reframe/view", NULL )                                                                                              \
    X( LOOK, "reframe/look", NULL )                                                                                              \
    X( EXPOSURE, "reframe/exposure", NULL )                                                                                      \
    X( GAMMA, "reframe/gamma", NULL )                                                                                            \
    X( CLIPPED_PIXELS, "reframe/clipped-pixels", NULL )                                                                          \
    X( CLIPPED_LAYERS, "reframe/clipped-layers", NULL )                                                                          \
    X( DENOISER, "reframe/denoiser", "none" )                                                                                    \
    X( DENOISED_RELMSE, "reframe/denoised-relmse", NULL )                                                                        \
    X( DENOISED_LOW, "reframe/denoised-relmse-low", NULL )                                                                       \
    X( DENOISED_HIGH, "reframe/denoised-relmse-high", NULL )                                                                     \
    X( DEVICE, "reframe/device", NULL )                                                                                          \
    X( FINGERPRINT, "reframe/fingerprint", NULL )

// RF_KEY_VERSION and so on.
typedef enum RfKey
{
#define RF_KEY_CONSTANT( constant, name, absent ) RF_KEY_##constant,
    RF_KEY_LIST( RF_KEY_CONSTANT )
#undef RF_KEY_CONSTANT
        RF_KEY_COUNT
} RfKey;

// The name of an attribute, such as "reframe/spp".
const char* rf_key_name( RfKey key );

// Whether a file's picture has been denoised: then the estimates of relMSE and variance in it are those of the layer `noisy`.
bool rf_is_denoised( const char* path );

#define RF_NOISY_LAYER "noisy"   // of a frame that has been denoised: the picture before
#define RF_COLOUR_LAYER "colour" // in RF_KEY_CLIPPED_LAYERS: R, G and B, whatever they are called

// What a frame that is there was rendered with, where that is not what is asked for.

#define RF_MAX_DIFFERENCES 40
#define RF_DIFFERENCE_SIZE 256

typedef struct RfFrameDifference
{
    const char* name; // of the setting, "spp"; or "version", "pictures", "frame", "frames" (of the path)
    char there[RF_DIFFERENCE_SIZE];
    char here[RF_DIFFERENCE_SIZE];
} RfFrameDifference;

// Lists the settings in which the file of frame `frame` (from 0) differs from `output`, as far as its
// header holds them; returns their number. 0: it is the scene or the camera path that differs.
int rf_list_frame_differences( const RfOutput* output, int frame, RfFrameDifference list[RF_MAX_DIFFERENCES] );

#endif
