// Sliding groups (estimators.md section 7): windows of `eyes` consecutive
// frames that move by one frame, and how many passes each is given.
//
// Every window is full: a sample then always serves as many frames as it can.
// The first and the last frame lie in one window only; its passes are raised
// so that they get as many samples as a frame in the middle.
#ifndef REFRAME_REUSE_GROUP_H
#define REFRAME_REUSE_GROUP_H

typedef struct RfGroupPlan
{
    int frames;  // in the whole path
    int eyes;    // in a window: 2n+1, or all frames of a shorter path
    int windows; // first frames 0 … windows−1
    int passes;  // of a window in the middle, one native sample per pixel each
    int end_passes; // of the first and the last window
    int spp;     // native samples per pixel of a frame in the middle
} RfGroupPlan;

// For a path of `frames` frames, half-width n and at least `spp` native
// samples per pixel and frame.
RfGroupPlan rf_plan_groups( int frames, int half_width, int spp );

int rf_window_passes( const RfGroupPlan* plan, int window );

// First and last window that hold a frame.
void rf_windows_of_frame( const RfGroupPlan* plan, int frame, int* first, int* last );

// Native samples per pixel of a frame, over all windows that hold it.
int rf_frame_passes( const RfGroupPlan* plan, int frame );

// Which half of the film a pass goes to (E2): alternates with the passes of a
// window and starts at the other half in the next window, so that both halves
// see all windows, and with one pass a window alternate with the windows.
static inline int rf_half_of_pass( int window, int pass ) { return ( window + pass ) & 1; }

#endif
