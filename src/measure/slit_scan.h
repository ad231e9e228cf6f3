// A slit-scan: one column of every frame side by side, with time to the right. A static image
// gives horizontal lines, flicker gives stripes and grain.
#ifndef REFRAME_MEASURE_SLIT_SCAN_H
#define REFRAME_MEASURE_SLIT_SCAN_H

#include "image/image.h"

#define RF_SLIT_WIDTH 480 // frames are repeated equally often to fill at least about this many pixels

typedef struct RfSlitScan
{
    RfImage image;
    int repeat; // columns per frame
    int height; // of a frame
} RfSlitScan;

// Allocates a scan of `frames` frames of `height` pixels, with `parts` of them stacked
// vertically.
RfResult rf_create_slit_scan( int frames, int height, int parts, RfSlitScan* scan, RfError* error );

// Frees the image of a scan.
void rf_destroy_slit_scan( RfSlitScan* scan );

// Copies a column of the image into a frame (from 0) and a part (from 0, at the top).
void rf_add_slit( RfSlitScan* scan, int frame, int part, const RfImage* image, int column );

#endif
