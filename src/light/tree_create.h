// The tree over the lights of a scene.
#ifndef REFRAME_LIGHT_TREE_CREATE_H
#define REFRAME_LIGHT_TREE_CREATE_H

#include "light/light.h"

// Fills lights->tree and sky_scale, of lights that are collected else; of the
// sky alone there is no tree. Fails with RF_ERROR_MEMORY only.
RfResult rf_create_light_tree( RfLights* lights, RfError* error );

#endif
