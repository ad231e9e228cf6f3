// Finds the threshold of the clamp.
#include "render/clamp.h"

#include "render/renderer.h"

#include <math.h>
#include <stdlib.h>

RfResult rf_find_clamps( RfRenderer* r, RfError* error )
{
    double value = r->setup->settings.clamp;
    int frames = r->setup->shot.eye_count;
    if ( value == 0.0 )
        return RF_OK;
    r->clamps = malloc( (size_t)frames * sizeof *r->clamps );
    if ( r->clamps == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for the thresholds of %d frames", frames );
    for ( int frame = 0; frame < frames; ++frame )
        r->clamps[frame] = value == RF_CLAMP_AUTO ? INFINITY : (float)value;
    return RF_OK;
}
