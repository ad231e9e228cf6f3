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

// `textured` of a material without textures, of malloc.
RfTextured* make_textured( const RfFactors* factors );

// A texture of these bytes, which are copied; srgb: the curve undone for colour.
RfTexture make_texture( int width, int height, int channels, const uint8_t* bytes, bool srgb );

#endif
