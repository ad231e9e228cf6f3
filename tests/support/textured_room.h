// A room where everything that textures can change is changed.
#ifndef REFRAME_TESTS_TEXTURED_ROOM_H
#define REFRAME_TESTS_TEXTURED_ROOM_H

#include "support/scene_builder.h"

#include "scene/textured.h"

// The GGX room of scene_builder.h with a textured light (part of it black), a
// wall that is cut out by its alpha, walls with a texture of colour, a sphere
// with vertex colours and bumps, a block whose roughness and metal vary.
RfScene make_textured_room( void );

// The GGX room with a wall, a sphere and a light that let part of the light
// straight through, the wall by a texture's alpha.
RfScene make_blended_room( void );

// The GGX room with a ball whose parts are glass, metal and paint, a block under
// a coat that comes and goes, with bumps of its own, and a lacquered wall.
RfScene make_varied_room( void );

// The textures of these rooms, by number.
#define COLOR_TEXTURE 0 // with alpha
#define BUMP_TEXTURE 2

// Adds these textures and texture coordinates to a scene that has none, and vertex colours.
void add_test_textures( RfScene* scene );

// Makes a material of the scene textured, without any texture yet.
RfTextured* texture_material( RfScene* scene, uint32_t material, RfFactors factors );

// Puts a texture into a slot, looked up by the first (0) or second (1) set of coordinates.
void use_texture( RfTextured* textured, RfTextureSlot slot, int texture, int set );

// `textured` of a material without textures, of malloc.
RfTextured* make_textured( const RfFactors* factors );

// A texture of these bytes, which are copied; srgb: the curve undone for colour.
RfTexture make_texture( int width, int height, int channels, const uint8_t* bytes, bool srgb );

#endif
