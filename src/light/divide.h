// Which emitters are found through mirrors and glass by connections, and which by chance: a large one is hit often by what scatters,
// a small one hardly ever, a lamp without size never. src/reuse/estimators.md, section 16.
#ifndef REFRAME_LIGHT_DIVIDE_H
#define REFRAME_LIGHT_DIVIDE_H

#include "scene/scene.h"

// Emission whose image in mirrors and glass covers more than this is left to chance, sr.
#define RF_LARGE_EMITTER 0.02

typedef struct RfDivision
{
    uint32_t connected, all; // emitters: materials, punctual lights, the sky
} RfDivision;

// Divides the emitters of a scene. `connected`: a flag for each material and one for the sky; NULL: not asked for.
RfDivision rf_divide_emitters( const RfScene* scene, bool* connected );

#endif
