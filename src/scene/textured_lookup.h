// Inside of scene/textured.h: look-ups that its files share, at the barycentrics
// (u, v) of a triangle.
#ifndef REFRAME_SCENE_TEXTURED_LOOKUP_H
#define REFRAME_SCENE_TEXTURED_LOOKUP_H

#include "scene/textured.h"

// `components` numbers of each vertex, weighted.
void rf_interpolate_corners( const float* values, int components, const uint32_t* corners, float u, float v, float* out );

// Where on its texture the point lies: u', v'.
void rf_place_texture( const RfScene* scene, const RfTextureRef* ref, uint32_t triangle, float u, float v, float at[2] );

// False where the slot has no texture.
bool rf_look_up_slot( const RfScene* scene, const RfMaterial* material, RfTextureSlot slot, uint32_t triangle, float u, float v,
                      float rgba[4] );

#endif
