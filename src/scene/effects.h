// The effects of light and camera that a scene calls for, and why: what a
// renderer of this scene must do, and what it may leave out.
#ifndef REFRAME_SCENE_EFFECTS_H
#define REFRAME_SCENE_EFFECTS_H

#include "scene/scene.h"

#define RF_MAX_EFFECTS 32

typedef struct RfEffect
{
    const char* name; // a stable word, such as "phong"
    bool on;
    char why[160]; // which material, which camera; or why not
} RfEffect;

// Fills `effects` in a fixed order and returns how many there are.
int rf_list_effects( const RfScene* scene, RfEffect effects[RF_MAX_EFFECTS] );

#endif
