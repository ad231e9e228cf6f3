// Backward reprojection: where the surface seen in a pixel was in the previous frame, by the
// motion layer, and whether it was visible there, by depth.
//
// A point at (x, y), in pixels from the centre of the first pixel of the data window with +y
// down, was at (x + motion.X, y − motion.Y) in the previous frame (the layer has +y up).
// Motion, depth and colour are interpolated bilinearly.
//
// The point was visible if the depth found there is within 2 % of its expected depth, or if
// both show no surface. The expected depth differs from the current one because the camera
// moves: if both frames have the attribute worldToNDC (ours do), the point is reprojected
// through both cameras as part of a static scene; otherwise the depth is taken as unchanged.
// Points outside the frame, or with undefined motion or depth, were not visible. There is no
// layer of primitive ids yet to compare as well.
#ifndef REFRAME_MEASURE_FOLLOW_H
#define REFRAME_MEASURE_FOLLOW_H

#include "image/image.h"

#define RF_FOLLOW_DEPTH_TOLERANCE 0.02
#define RF_FOLLOW_NO_SURFACE 1e9 // depths from here on, infinite, or not above 0 mean: no surface

// A frame as input to the flicker measures.
typedef struct RfFlickerFrame
{
    int number;
    RfImage signal;   // e = v − r with a reference, else the image v
    RfImage variance; // of v; rgb NULL: unknown
    float* motion;    // 2 per pixel, or NULL
    float* depth;     // 1 per pixel, or NULL
    bool has_camera;
    double camera[3][4]; // maps a world point (P, 1) to x·z, y·z and the depth z
    bool is_finite;      // no NaN or infinity in v and r
} RfFlickerFrame;

// Frees the arrays of a frame and clears it.
void rf_destroy_flicker_frame( RfFlickerFrame* frame );

// The reprojection from a frame to the previous one.
typedef struct RfFollow
{
    const RfFlickerFrame* now;
    const RfFlickerFrame* before;
    bool compensate;  // else pixels are compared in place
    double expect[4]; // depth before = z (expect[0] x + expect[1] y + expect[2]) + expect[3]
} RfFollow;

// Prepares the reprojection from `now` to `before`.
RfFollow rf_follow( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate );

// Bilinear interpolation: pixels and their weights, which sum to 1; none is 0.
typedef struct RfTaps
{
    int count;
    size_t pixel[4];
    double weight[4];
} RfTaps;

// The taps at a point; false outside the frame (with a tolerance of a thousandth of a pixel).
bool rf_find_taps( int width, int height, double x, double y, RfTaps* taps );

// Moves the point to its position in the previous frame and finds the taps there; false if it
// was not visible.
bool rf_follow_point( const RfFollow* follow, double* x, double* y, RfTaps* taps );

#endif
