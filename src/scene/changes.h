// What changes in a scene besides the objects that move: lamps, materials, the sky and cameras' lenses, by name.
#ifndef REFRAME_SCENE_CHANGES_H
#define REFRAME_SCENE_CHANGES_H

#include "scene/scene.h"

typedef enum RfChangingKind
{
    RF_CHANGING_LIGHT,    // punctual
    RF_CHANGING_MATERIAL, // it changes, or shines and is on something that moves
    RF_CHANGING_SKY,
    RF_CHANGING_LENS, // of a camera
} RfChangingKind;

#define RF_MOST_CHANGES 16

typedef struct RfChanging
{
    RfChangingKind kind;
    int number;                        // of the scene's lights, materials or cameras; the sky: 0
    const char* name;                  // the scene's
    const char* what[RF_MOST_CHANGES]; // literals, such as "intensity"
    int what_count;
    bool moves;  // or what has it: at no two times is it known to be the same light
    bool shines; // its light is lit by nothing else: a light, the sky, or a material that emits
} RfChanging;

// "light", "material", "sky", "lens".
const char* rf_changing_kind( RfChangingKind kind );

// All that changes, in the order of the kinds and numbers; free( *list ). 0 where nothing does, as where it is frozen. −1: no memory.
int rf_list_changing( const RfScene* scene, RfChanging** list );

#endif
