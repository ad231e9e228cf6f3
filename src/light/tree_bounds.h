// The bounds of a set of lights: a box, an orientation cone, and the sum of their
// intensities (Conty Estevez, Kulla 2018, section 4). Internal to the light tree.
#ifndef REFRAME_LIGHT_TREE_BOUNDS_H
#define REFRAME_LIGHT_TREE_BOUNDS_H

#include "light/tree.h"

// An RfTreeLight is the bounds of a single light. The box of an empty set has
// low > high.
typedef RfTreeLight RfLightBounds;

// The bounds of no lights.
RfLightBounds rf_no_lights( void );

// Extends the bounds to include `more`.
void rf_bound_both( RfLightBounds* bounds, const RfLightBounds* more );

// The surface area orientation heuristic: intensity times the measure of the lit
// directions times the squared diagonal of the box, which takes the place of the
// area since it is above 0 for lights along a line.
double rf_bounds_cost( const RfLightBounds* bounds );

#endif
