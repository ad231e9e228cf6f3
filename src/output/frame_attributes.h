// What the header of a frame's file says of it and of the render it belongs to.
#ifndef REFRAME_OUTPUT_FRAME_ATTRIBUTES_H
#define REFRAME_OUTPUT_FRAME_ATTRIBUTES_H

#include "reframe/output.h"

#define RF_ATTRIBUTE_SIZE RF_EFFECTS_TEXT_SIZE // the longest text that is made here

// In the order of the file. Each is there at most once.
#define RF_KEY_LIST( X )                                                                                                         \
    X( VERSION, "reframe/version" )                                                                                              \
    X( SCENE, "reframe/scene" )                                                                                                  \
    X( CAMERA, "reframe/camera" )                                                                                                \
    X( FRAME, "reframe/frame" )                                                                                                  \
    X( FRAMES, "reframe/frames" )                                                                                                \
    X( STEP, "reframe/step" )                                                                                                    \
    X( GROUP, "reframe/group" )                                                                                                  \
    X( SPP, "reframe/spp" )                                                                                                      \
    X( TILE, "reframe/tile" )                                                                                                    \
    X( WEIGHTS, "reframe/weights" )                                                                                              \
    X( NORMALIZE, "reframe/normalize" )                                                                                          \
    X( SEED, "reframe/seed" )                                                                                                    \
    X( MAX_DEPTH, "reframe/max-depth" )                                                                                          \
    X( LIGHT_SAMPLES, "reframe/light-samples" )                                                                                  \
    X( FILTER, "reframe/filter" )                                                                                                \
    X( FILTER_WIDTH, "reframe/filter-width" )                                                                                    \
    X( ADAPTIVE, "reframe/adaptive" )                                                                                            \
    X( NOISE, "reframe/noise" )                                                                                                  \
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
    X( ESTIMATOR, "reframe/estimator" )                                                                                          \
    X( RECONSTRUCTION, "reframe/reconstruction" )                                                                                \
    X( LIGHT_PATHS, "reframe/light-paths" )                                                                                      \
    X( KERNEL_NORMALIZATION, "reframe/kernel-normalization" )                                                                    \
    X( EFFECTS, "reframe/effects" )                                                                                              \
    X( NO_EFFECT, "reframe/no-effect" )                                                                                          \
    X( CALLS_FOR, "reframe/calls-for" )                                                                                          \
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

typedef struct RfAttributes
{
    const char* values[RF_KEY_COUNT]; // NULL: not there
    char texts[RF_KEY_COUNT][RF_ATTRIBUTE_SIZE];
    RfExrString strings[RF_KEY_COUNT]; // those that are there
    int count;
} RfAttributes;

// The name of an attribute, such as "reframe/spp".
const char* rf_key_name( RfKey key );

// Fills `attributes` for the file of a frame. They point into `output`.
void rf_list_attributes( const RfOutput* output, const RfFrameResult* frame, RfAttributes* attributes );

#endif
