// Internal to adaptive sampling: from the sums of a pilot to extra samples for each pixel.
#ifndef REFRAME_RENDER_ADAPTIVE_NEED_H
#define REFRAME_RENDER_ADAPTIVE_NEED_H

#include <stdbool.h>
#include <stddef.h>

// What a pilot found, per pixel.
typedef struct RfPilotSums
{
    float* share; // sums of ρ over the passes
    const float*
        noise; // four per pixel: sums of the two variances of its hits' classes, of the hits, and of costs; NULL: all alike
    const float* samples; // camera rays of the pixel; NULL: one in each pass
    size_t pixels;
    float passes;
    int eyes;     // of the group
    bool wary;    // extra samples must pay by a margin (RF_ADAPTIVE_AUTO), where materials differ in noise
    double worth; // of an extra sample beside one of a pass: 1 without a pixel filter (film/pixel_filter.h)
} RfPilotSums;

// Do enough pixels of a coarse look lack samples for a pilot to be worth it?
bool rf_extra_may_pay( const RfPilotSums* sums );

// Replaces sums->share by the extra samples of each pixel in a pass, and returns the most.
float rf_set_need( const RfPilotSums* sums );

// θ for pixels of which counts[b] have ρ = (b + 1) / bins. counts[] leaves out pixels
// that see nothing, `all` has them; `eyes`: cameras of the group. 1: no extra samples pay.
double rf_extra_threshold( const double* counts, int bins, double all, int eyes );

#endif
