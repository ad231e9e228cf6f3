// AOVs: images of a frame besides its colour. Albedo, normal, depth and motion are means
// over the frame's own samples, uniform in the pixel as for the colour. They have hardly any
// noise, so they need no samples of other frames.
#ifndef REFRAME_FILM_AOV_H
#define REFRAME_FILM_AOV_H

#include "reframe/error.h"

#include <stdbool.h>

typedef enum RfAov
{
    RF_AOV_ALBEDO,   // R G B: reflectance for light along the normal; 0 where nothing is hit
    RF_AOV_NORMAL,   // X Y Z: shading normal in world space, on the side that is seen; 0 where nothing is hit
    RF_AOV_DEPTH,    // Z: metres along the viewing direction (not distance to the eye), mean over the hits;
                     // RF_DEPTH_OF_NOTHING where no sample hits anything
    RF_AOV_MOTION,   // X Y: film position in the path's previous frame minus that in this frame, pixels,
                     // +x right, +y up; Z W: the same for the next frame (Blender 3.4 has X and Y like
                     // this, Z and W with the opposite sign). 0 at the ends of the path, and where the
                     // point is behind the other eye
    RF_AOV_VARIANCE, // R G B: estimated variance of the colour (rf_estimate_variance)
    RF_AOV_SAMPLES,  // Y: samples that landed in the pixel, own-frame and reused, each counted once
    RF_AOV_COUNT
} RfAov;

#define RF_AOV_BIT( aov ) ( 1u << ( aov ) )
#define RF_ALL_AOVS ( RF_AOV_BIT( RF_AOV_COUNT ) - 1u )

#define RF_DEPTH_OF_NOTHING 1e10f // as Blender has it

// "albedo", and the letters of its channels, "RGB": the channel albedo.R and so on.
const char* rf_aov_name( RfAov aov );
const char* rf_aov_letters( RfAov aov );

// Floats per pixel: as many as letters.
int rf_aov_channels( RfAov aov );

// True where 16 bits are enough in a file: AOVs like colours. The others need the range or precision of 32.
bool rf_aov_is_half( RfAov aov );

#endif
