// The file of a frame: its header, its channels, and how it differs from what is asked for.
#ifndef REFRAME_OUTPUT_FRAME_FILE_H
#define REFRAME_OUTPUT_FRAME_FILE_H

#include "reframe/output.h"
#include "reframe/render.h"

// What the header of a frame's file says of it and of the render it belongs to.

// In the order of the file. Each is there at most once.
#define RF_KEY_LIST( X )                                                                                                         \
    X( VERSION, "reframe/version" )                                                                                              \
    X( SCENE, "reframe/scene" )                                                                                                  \
    X( CAMERA, "reframe/camera" )                                                                                                \
    X( FRAME, "reframe/frame" )                                                                                                  \
    X( FRAMES, "reframe/frames" )                                                                                                \
    X( SHOT, "reframe/shot" )                                                                                                    \
    X( STEP, "reframe/step" )                                                                                                    \
    X( OVERSCAN, "reframe/overscan" )                                                                                            \
    X( NAMES, "reframe/names" )                                                                                                  \
    X( TIMECODE, "reframe/timecode" )                                                                                            \
    X( COMPRESSION, "reframe/compression" )                                                                                      \
    X( PARTS, "reframe/parts" )                                                                                                  \
    X( FLOAT, "reframe/float" )                                                                                                  \
    X( COLORSPACE, "reframe/colorspace" )                                                                                        \
    X( BLUR_STEPS, "reframe/blur-steps" )                                                                                        \
    X( GROUP, "reframe/group" )                                                                                                  \
    X( SPP, "reframe/spp" )                                                                                                      \
    X( TILE, "reframe/tile" )                                                                                                    \
    X( WEIGHTS, "reframe/weights" )                                                                                              \
    X( NORMALIZE, "reframe/normalize" )                                                                                          \
    X( SEED, "reframe/seed" )                                                                                                    \
    X( MAX_DEPTH, "reframe/max-depth" )                                                                                          \
    X( BEYOND_DEPTH_SHARE, "reframe/beyond-depth-share" )                                                                        \
    X( LIGHT_SAMPLES, "reframe/light-samples" )                                                                                  \
    X( FILTER, "reframe/filter" )                                                                                                \
    X( FILTER_WIDTH, "reframe/filter-width" )                                                                                    \
    X( ADAPTIVE, "reframe/adaptive" )                                                                                            \
    X( NOISE, "reframe/noise" )                                                                                                  \
    X( CLAMP, "reframe/clamp" )                                                                                                  \
    X( CLAMP_CHAINS, "reframe/clamp-chains" )                                                                                    \
    X( CLAMP_THRESHOLD, "reframe/clamp-threshold" )                                                                              \
    X( CLAMP_THRESHOLD_CHAINS, "reframe/clamp-threshold-chains" )                                                                \
    X( REMOVED_SHARE, "reframe/removed-share" )                                                                                  \
    X( FLICKER, "reframe/flicker" )                                                                                              \
    X( TIME, "reframe/time" )                                                                                                    \
    X( RELMSE_ESTIMATE, "reframe/relmse-estimate" )                                                                              \
    X( RELMSE_IS_LOWER_BOUND, "reframe/relmse-is-lower-bound" )                                                                  \
    X( RELMSE_LIKELY, "reframe/relmse-likely" )                                                                                  \
    X( WORST_TEN_SHARE, "reframe/worst-ten-share" )                                                                              \
    X( FLICKER_ESTIMATE, "reframe/flicker-estimate" )                                                                            \
    X( FLICKER_IS_LOWER_BOUND, "reframe/flicker-is-lower-bound" )                                                                \
    X( FLICKER_LIKELY, "reframe/flicker-likely" )                                                                                \
    X( FLICKER_WORST_TEN_SHARE, "reframe/flicker-worst-ten-share" )                                                              \
    X( REACHED, "reframe/reached" )                                                                                              \
    X( NATIVE_SPP, "reframe/native-spp" )                                                                                        \
    X( EFFECTIVE_SPP, "reframe/effective-spp" )                                                                                  \
    X( AOV, "reframe/aov" )                                                                                                      \
    X( CRYPTOMATTE, "reframe/cryptomatte" )                                                                                      \
    X( LIGHT_GROUPS, "reframe/light-groups" )                                                                                    \
    X( ESTIMATOR, "reframe/estimator" )                                                                                          \
    X( RECONSTRUCTION, "reframe/reconstruction" )                                                                                \
    X( LIGHT_PATHS, "reframe/light-paths" )                                                                                      \
    X( KERNEL_NORMALIZATION, "reframe/kernel-normalization" )                                                                    \
    X( EFFECTS, "reframe/effects" )                                                                                              \
    X( NO_EFFECT, "reframe/no-effect" )                                                                                          \
    X( CALLS_FOR, "reframe/calls-for" )                                                                                          \
    X( VIEW, "reframe/view" )                                                                                                    \
    X( LOOK, "reframe/look" )                                                                                                    \
    X( EXPOSURE, "reframe/exposure" )                                                                                            \
    X( GAMMA, "reframe/gamma" )                                                                                                  \
    X( CLIPPED_PIXELS, "reframe/clipped-pixels" )                                                                                \
    X( CLIPPED_LAYERS, "reframe/clipped-layers" )                                                                                \
    X( DEVICE, "reframe/device" )                                                                                                \
    X( FINGERPRINT, "reframe/fingerprint" )

// RF_KEY_VERSION and so on.
typedef enum RfKey
{
#define RF_KEY_CONSTANT( constant, name ) RF_KEY_##constant,
    RF_KEY_LIST( RF_KEY_CONSTANT )
#undef RF_KEY_CONSTANT
        RF_KEY_COUNT
} RfKey;

// The name of an attribute, such as "reframe/spp".
const char* rf_key_name( RfKey key );

#define RF_COLOUR_LAYER "colour" // in RF_KEY_CLIPPED_LAYERS: R, G and B, whatever they are called

// What a frame that is there was rendered with, where that is not what is asked for.

#define RF_MAX_DIFFERENCES 38
#define RF_DIFFERENCE_SIZE 256

typedef struct RfFrameDifference
{
    const char* name; // of the setting, "spp"; or "version", "frame", "frames" (of the path)
    char there[RF_DIFFERENCE_SIZE];
    char here[RF_DIFFERENCE_SIZE];
} RfFrameDifference;

// Lists the settings in which the file of frame `frame` (from 0) differs from `output`, as far as its
// header holds them; returns their number. 0: it is the scene or the camera path that differs.
int rf_list_frame_differences( const RfOutput* output, int frame, RfFrameDifference list[RF_MAX_DIFFERENCES] );

#endif
