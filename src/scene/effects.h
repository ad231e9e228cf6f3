// Lists the effects of light, material and camera that a scene requires, and why: what a
// renderer must support and what it may leave out.
#ifndef REFRAME_SCENE_EFFECTS_H
#define REFRAME_SCENE_EFFECTS_H

#include "scene/scene.h"

#define RF_MAX_EFFECTS 32

typedef struct RfEffect
{
    const char* name; // a stable word, such as "phong"
    bool on;
    char why[160]; // the material or camera that requires it, or why it is not required
} RfEffect;

// Fills `effects` in a fixed order and returns their number.
int rf_list_effects( const RfScene* scene, RfEffect effects[RF_MAX_EFFECTS] );

#endif
