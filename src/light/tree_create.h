// The light tree of a scene.
#ifndef REFRAME_LIGHT_TREE_CREATE_H
#define REFRAME_LIGHT_TREE_CREATE_H

#include "light/light.h"

// Fills lights->tree and sky_scale; the rest must have been collected. There must be
// a light besides the sky. Fails with RF_ERROR_MEMORY only.
RfResult rf_create_light_tree( RfLights* lights, RfError* error );

#endif
