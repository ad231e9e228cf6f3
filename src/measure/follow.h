// Where what a pixel shows was in the frame before: the motion layer says it,
// and depth tells whether it was seen there at all.
//
// A point at (x, y), pixels from the middle of the first pixel of the data
// window, +y down, was at (x + motion.X, y − motion.Y) in the frame before (the
// layer has +y up). What lies between pixels is had bilinearly from the four
// about it, of motion, depth and colour alike.
//
// It was seen where the depth found there is within 2 % of the depth that the
// point should have, or where both show nothing. The camera moves, so that the
// depth it should have is not the one it has now: where both frames have the
// attribute worldToNDC (as ours have) the point of a scene that stands still is
// taken through the two cameras, else depth is taken to be the same. What was
// outside of the frame, and what has no number for motion or depth, was not
// seen. There is no layer of primitives yet to be held to as well.
#ifndef REFRAME_MEASURE_FOLLOW_H
#define REFRAME_MEASURE_FOLLOW_H

#include "reframe/image.h"

#define RF_FOLLOW_DEPTH_TOLERANCE 0.02
#define RF_FOLLOW_NOTHING 1e9 // depths from here on, infinite ones and those not above 0 are of nothing

// A frame as flicker sees it.
typedef struct RfFlickerFrame
{
    int number;
    RfImage signal;   // e = v − r with a reference, else the picture v
    RfImage variance; // of v; rgb NULL: not known
    float* motion;    // 2 of each pixel, or NULL
    float* depth;     // of each pixel, or NULL
    bool has_camera;
    double camera[3][4]; // of a point (P, 1) of the world: x·z, y·z and the depth z
    bool is_finite;      // no NaN, no infinity in v and r
} RfFlickerFrame;

void rf_destroy_flicker_frame( RfFlickerFrame* frame );

// From a frame to the one before.
typedef struct RfFollow
{
    const RfFlickerFrame* now;
    const RfFlickerFrame* before;
    bool compensate;  // else a pixel is where it is
    double expect[4]; // depth before = z (expect[0] x + expect[1] y + expect[2]) + expect[3]
} RfFollow;

RfFollow rf_follow( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate );

// The pixels about a point and how much each counts, 1 in all; none counts 0.
typedef struct RfTaps
{
    int count;
    size_t pixel[4];
    double weight[4];
} RfTaps;

// False outside of the frame (a thousandth of a pixel is forgiven).
bool rf_find_taps( int width, int height, double x, double y, RfTaps* taps );

// Moves the point to where it was in the frame before, whose pixels there are
// `taps`; false where it was not seen.
bool rf_follow_point( const RfFollow* follow, double* x, double* y, RfTaps* taps );

#endif
