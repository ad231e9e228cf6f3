// Denoises frames with Open Image Denoise, and tells the error that is left, its bias included.
//
//     RfDenoiser* denoiser;
//     if ( rf_open_denoiser( NULL, 0, &denoiser, &error ) == RF_OK )
//         result = rf_denoise( denoiser, &frame, rgb, &info, NULL, &error );
//     rf_close_denoiser( denoiser );
#ifndef REFRAME_DENOISE_H
#define REFRAME_DENOISE_H

#include "reframe/error.h"
#include "reframe/types.h"

RF_API_BEGIN

typedef struct RfDenoiser RfDenoiser;

// Loads the library: the file `library`, or with NULL that of the environment variable REFRAME_OIDN, else the one that the system has,
// that scripts/install-packages --denoiser has put into the cache, or that is part of an installed Blender or Python package. It is
// used on the CPU, by so many threads (0: all cores); callers on several threads take turns. Fails with RF_ERROR_UNSUPPORTED where there is none, or one before 2.0.
RfResult rf_open_denoiser( const char* library, int threads, RfDenoiser** denoiser, RfError* error );

// NULL is ignored.
void rf_close_denoiser( RfDenoiser* denoiser );

// "Open Image Denoise 2.5.1".
const char* rf_denoiser_name( const RfDenoiser* denoiser );

// A layer of a picture, such as the light of a light group. Layers of one set add up to the picture.
typedef struct RfNoisyLayer
{
    int set;     // from 0 on
    float* rgb;  // 3 per pixel; replaced
    bool is_raw; // false: it has been denoised before, and is only made to add up
} RfNoisyLayer;

#define RF_LEAST_DENOISED_PASSES 4 // two in each half: with less, the error is not known

// The halves of a frame, each denoised by itself.
typedef struct RfDenoisedHalves
{
    float* half[2]; // 3 per pixel; without halves of the samples both are of the whole picture
} RfDenoisedHalves;

// A frame beside one, of the same size and scene, and how to find it.
typedef struct RfFrameBeside
{
    const RfDenoisedHalves* halves; // NULL: there is none
    const float *albedo, *normal;   // RF_AOV_DENOISE_ALBEDO, RF_AOV_DENOISE_NORMAL
} RfFrameBeside;

// What is known of a frame; NULL: not known.
typedef struct RfNoisyFrame
{
    int width, height;
    const float* rgb;    // 3 per pixel, as all others but `half`
    const float* half;   // RF_AOV_HALF, 4 per pixel
    const float* albedo; // RF_AOV_DENOISE_ALBEDO
    const float* normal; // RF_AOV_DENOISE_NORMAL
    const float* motion; // RF_AOV_MOTION, 4 per pixel
    int layer_count;
    const RfNoisyLayer* layers;
    const RfDenoisedHalves* halves; // its own, from rf_denoise_halves
    RfFrameBeside beside[2];        // the frames before and after, which need motion, albedo and normal
    double passes;                  // of the frame: with less than RF_LEAST_DENOISED_PASSES, or no half, the error is not known
} RfNoisyFrame;

// Estimated relMSE (reframe/measure.h) of a picture, and its 95 % interval; NaN: not known. The estimate is unbiased, and may be
// negative where the error is small.
typedef struct RfErrorEstimate
{
    double relmse, low, high;
    bool is_vague; // it hangs on a few parts of the picture: `high` may be exceeded
} RfErrorEstimate;

typedef struct RfDenoised
{
    double noisy;             // relMSE of the picture before, by the same estimate
    RfErrorEstimate denoised; // of the picture after
    double exponent;          // the error of the picture after falls as the samples to the power of -exponent; NaN: not known
    double share;             // of the denoised picture in it, mean over the pixels, 0 to 1: the rest is the noisy one
    double along;             // of the mean with the frames beside it, within that share
} RfDenoised;

// Sums of errors over the frames of a shot, for the error of its mean; start from zeros.
typedef struct RfDenoisedSums
{
    int frames, count; // frames; parts of the picture
    double* of_part;
} RfDenoisedSums;

// Denoises the halves of a frame for rf_denoise, which does so itself where they are not given. Free with rf_free_denoised_halves, also
// after a failure. Fails as rf_denoise.
RfResult rf_denoise_halves( RfDenoiser* denoiser, const RfNoisyFrame* frame, RfDenoisedHalves* halves, RfError* error );
void rf_free_denoised_halves( RfDenoisedHalves* halves );

// Denoises a frame into `rgb`, which may be frame->rgb, and its layers. Each half of the samples is denoised by itself. Their mean is
// blended with the noisy picture, and with the frames beside it along the motion, as far as that lowers the error, which is known
// from the halves (src/denoise/README.md). Pixels that are not finite are kept, and the error of a frame with such is not known.
// `sums` may be NULL. Fails with RF_ERROR_MEMORY, or RF_ERROR_UNSUPPORTED where the library fails.
RfResult rf_denoise( RfDenoiser* denoiser, const RfNoisyFrame* frame, float* rgb, RfDenoised* denoised, RfDenoisedSums* sums,
                     RfError* error );

// The error of the mean over frames.
RfErrorEstimate rf_denoised_error( const RfDenoisedSums* sums );
void rf_free_denoised_sums( RfDenoisedSums* sums );

RF_API_END

#endif
