// What bounds a set of lights: a box, a cone of orientations, the sum of their
// intensities (Conty Estevez, Kulla 2018, section 4). Shared by the light tree's files.
#ifndef REFRAME_LIGHT_TREE_BOUNDS_H
#define REFRAME_LIGHT_TREE_BOUNDS_H

#include "light/tree.h"

// An RfTreeLight is one as well, of a single light; of a set the box may be
// empty, low > high.
typedef RfTreeLight RfLightBounds;

RfLightBounds rf_no_lights( void );
void rf_bound_both( RfLightBounds* bounds, const RfLightBounds* more );
// Their orientation heuristic without the surface area: intensity times the
// measure of the directions lit times the squared diagonal of the box, which
// unlike its area is above 0 for lights along a line.
double rf_bounds_cost( const RfLightBounds* bounds );

#endif
