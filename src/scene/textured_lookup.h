// Internal to scene/textured.h: shared lookups at the barycentrics (u, v) of a triangle.
#ifndef REFRAME_SCENE_TEXTURED_LOOKUP_H
#define REFRAME_SCENE_TEXTURED_LOOKUP_H

#include "scene/textured.h"

// Interpolates a vertex attribute of `components` numbers.
void rf_interpolate_corners( const float* values, int components, const uint32_t* corners, float u, float v, float* out );

// The texture coordinates u', v' of the point.
void rf_texture_coordinates( const RfScene* scene, const RfTextureRef* ref, uint32_t triangle, float u, float v, float at[2] );

// Looks up a texture slot; false if it has no texture.
bool rf_look_up_slot( const RfScene* scene, const RfMaterial* material, RfTextureSlot slot, uint32_t triangle, float u, float v,
                      float rgba[4] );

#endif
