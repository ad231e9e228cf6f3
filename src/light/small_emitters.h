// How many emitters chance finds badly through mirrors and glass: a large one is hit often by what scatters, a small one hardly
// ever, a lamp without size never (src/light_paths/estimators.md).
#ifndef REFRAME_LIGHT_SMALL_EMITTERS_H
#define REFRAME_LIGHT_SMALL_EMITTERS_H

#include "scene/scene.h"

// Emission whose image in mirrors and glass covers more than this is found by chance, sr.
#define RF_LARGE_EMITTER 0.02

// Punctual lights, materials that emit, and the sky, as far as they are small.
uint32_t rf_count_small_emitters( const RfScene* scene );

#endif
