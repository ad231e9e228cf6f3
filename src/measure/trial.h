// A trial: what a group and a tile cost and yield, from a few passes of a few
// frames, without a reference.
//
// A path of 2n+1 frames is rendered as one window (reuse/group.h): handed to
// rf_render with group n, such a piece of the path is what a long path consists
// of. A frame of the long path is the mean over the 2n+1 windows that hold it, in
// each of which it has another place. So the mean of the error over the places
// of one window, v with P passes, stands for the frame in the middle of a long
// path, which has v·P/S with S native samples per pixel, and a sample costs the
// same in both. What the ends of the path, several sweeps or a choice of frames
// cost besides is no matter of trials: RfPlanRow.samples has it.
//
// The window is rendered twice, with independent seeds. The difference d of the
// two has twice the error's variance, without bias, whatever the tiles and frames
// share (the halves of one film share c of (E2)). F1 and φ come from it as well:
// the signal is gone, so nothing need be moved. Bias is not in it: exact weights
// have none.
//
// relMSE divides by the picture. Each render's own would make its dark pixels too
// heavy and its fireflies too light, the more the noisier it is; so all settings
// are weighed by the same picture, that of the site, which is independent of them.
#ifndef REFRAME_MEASURE_TRIAL_H
#define REFRAME_MEASURE_TRIAL_H

#include "reframe/render.h"

// Return false to stop: RF_ERROR_INTERRUPTED.
typedef bool RfTrialGoOn( void* user );

typedef struct RfTrialWatch
{
    RfTrialGoOn* go_on; // may be NULL; called often, by the thread that runs the trial
    void* user;
} RfTrialWatch;

// A piece of the path where settings are tried, at a size of its own.
typedef struct RfTestRegion
{
    RfEye* eyes; // `frames` of them
    int first;   // of the path, from 0
    int frames;
    bool whole;     // they are the whole path
    float* weight;  // 1 / (r̄² + 0.001) of each pixel, frame after frame
    double seconds; // that making it took, of the CPU
    double samples; // and traced
} RfTestRegion;

// An eye with a film of another size, for the same view.
RfEye rf_resize_eye( const RfEye* eye, int width, int height );

// A site of up to `frames` frames around `centre`, with films of width × height,
// its picture by settings' threads, memory, seed, depth and light samples. Free
// with rf_destroy_test_region, on failure too.
RfResult rf_create_test_region( const RfTracer* tracer, const RfEye* eyes, int eye_count, int centre, int frames, int width,
                                int height, const RfRenderSettings* settings, const RfTrialWatch* watch, RfTestRegion* site,
                                RfError* error );
void rf_destroy_test_region( RfTestRegion* site );

// What trials found, as sums that add up (rf_add_trial). The errors are of a
// single pass, P times those of P passes, times `weight`.
typedef struct RfTrial
{
    int windows;          // rendered, each twice
    double weight;        // pixels of their frames
    double samples;       // native ones traced
    double timed_samples; // those among them whose time is in the next two: without setting up
    double cpu_seconds;   // of all threads
    double wall_seconds;
    double finish_seconds, finish_pixels; // CPU seconds of finishing frames, and their pixels
    double relmse;                        // from the two renders
    double mse;                           // mean square of the error, over channels
    double change;                        // ½ mean square of its change from frame to frame of a long path
} RfTrial;

// Tries settings (group, tile, passes of a window in `passes`, at least 2) on
// `windows` windows beside each other in the middle of the site, as far as they
// fit in. The group must: RF_ERROR_USAGE else. With settings->threads 1 the CPU
// seconds are those of the calling thread, so that trials may run side by side;
// else those of the process, in which threads that wait for others may count. The
// seeds of the windows and their twins are made of settings->seed.
RfResult rf_run_trial( const RfTracer* tracer, const RfTestRegion* site, int windows, int passes,
                       const RfRenderSettings* settings, const RfTrialWatch* watch, RfTrial* trial, RfError* error );

void rf_add_trial( RfTrial* sum, const RfTrial* trial );

// Of a frame in the middle of a long path with `spp` native samples per pixel.
double rf_trial_relmse( const RfTrial* trial, double spp );
double rf_trial_f1( const RfTrial* trial, double spp );
double rf_trial_phi( const RfTrial* trial );

// CPU seconds of a native sample.
double rf_trial_sample_seconds( const RfTrial* trial );

// 1 / (relMSE · CPU seconds) of a frame of so many pixels: whatever its samples.
double rf_trial_efficiency( const RfTrial* trial, double pixels );

// Bytes that a site of `frames` frames of so many pixels holds, and a trial of
// groups of `eyes` frames besides what rf_render takes.
size_t rf_test_region_bytes( int frames, size_t pixels );
size_t rf_trial_bytes( int eyes, size_t pixels );

#endif
