// A slit-scan: one column of every frame, side by side, so that time runs to the
// right. What stands still makes level lines, flicker stripes and grain.
#ifndef REFRAME_MEASURE_SLIT_SCAN_H
#define REFRAME_MEASURE_SLIT_SCAN_H

#include "reframe/image.h"

#define RF_SLIT_WIDTH 480 // frames are repeated to fill at least about this, each alike

typedef struct RfSlitScan
{
    RfImage image;
    int repeat; // columns of each frame
    int height; // of a frame
} RfSlitScan;

// For `frames` frames of `height` pixels, `parts` of them below each other.
RfResult rf_create_slit_scan( int frames, int height, int parts, RfSlitScan* scan, RfError* error );
void rf_destroy_slit_scan( RfSlitScan* scan );

// Puts a column of the image into the place of a frame (from 0), in a part (from 0, on top).
void rf_add_slit( RfSlitScan* scan, int frame, int part, const RfImage* image, int column );

#endif
