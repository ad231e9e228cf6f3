// Layers: what a frame shows besides its colour. Albedo, normal, depth and
// motion are means over the native samples of the frame itself, uniform in the
// pixel like those of the colour; they hardly have noise, so no sample of
// another frame is needed for them.
#ifndef REFRAME_FILM_AOV_H
#define REFRAME_FILM_AOV_H

#include "reframe/error.h"

#include <stdbool.h>

typedef enum RfAov
{
    RF_AOV_ALBEDO,   // R G B: what the surface reflects of light from straight above; nothing there: 0
    RF_AOV_NORMAL,   // X Y Z: shading normal in world space, on the side that is seen; nothing there: 0
    RF_AOV_DEPTH,    // Z: metres along the viewing direction (not to the eye), the mean over what is
                     // there; RF_DEPTH_OF_NOTHING where the whole pixel is empty
    RF_AOV_MOTION,   // X Y: where the point is on the film of the path's previous frame minus where it is
                     // on this, pixels, +x right, +y up; Z W: the same to the next frame (Blender 3.4
                     // has X and Y like this, Z and W with the opposite sign). 0 at
                     // the ends of the path, and where the point is behind the other eye
    RF_AOV_VARIANCE, // R G B: estimated variance of the colour (rf_estimate_variance)
    RF_AOV_SAMPLES,  // Y: samples that landed in the pixel, native and reused, each counted once
    RF_AOV_COUNT
} RfAov;

#define RF_AOV_BIT( layer ) ( 1u << ( layer ) )
#define RF_ALL_AOVS ( RF_AOV_BIT( RF_AOV_COUNT ) - 1u )

#define RF_DEPTH_OF_NOTHING 1e10f // as Blender has it

// "albedo", and the letters of its channels, "RGB": the channel albedo.R and so on.
const char* rf_aov_name( RfAov layer );
const char* rf_aov_letters( RfAov layer );

// Floats per pixel: as many as letters.
int rf_aov_channels( RfAov layer );

// Is 16 bits enough for its file? Those like colour; all others need the range or the precision of 32.
bool rf_aov_is_half( RfAov layer );

#endif
