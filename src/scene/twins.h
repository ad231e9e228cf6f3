// Emitters in one place: a ray finds one of them there, light samples both, so the picture depends on how these are weighted.
#ifndef REFRAME_SCENE_TWINS_H
#define REFRAME_SCENE_TWINS_H

#include "scene/scene.h"

// Of emitting triangles that stand still, takes out those that have the corners of an earlier one and shine to the same sides,
// where both are opaque: they have no area from now on. Says which objects these are of, and which overlap in one plane otherwise
// and face the same way. Fails with RF_ERROR_MEMORY only.
RfResult rf_take_out_twins( RfScene* scene, RfLog* log, RfError* error );

#endif
