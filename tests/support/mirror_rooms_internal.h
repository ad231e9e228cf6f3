// Between mirror_rooms.c and glass_rooms.c.
#ifndef REFRAME_TESTS_MIRROR_ROOMS_INTERNAL_H
#define REFRAME_TESTS_MIRROR_ROOMS_INTERNAL_H

#include "support/mirror_rooms.h"

// Materials of every room; further ones follow.
enum
{
    WALL,
    RED,
    BLUE,
    LAMP,
    BLOCK,
    BALL,
    FIRST_OWN, // of the kind of room
};

#define BACK ( -1.9f ) // z of mirrors on the back wall

// A rectangle that faces +z.
void add_upright( SceneBuilder* b, uint32_t material, float x0, float y0, float x1, float y1, float z );

// Most of the back wall in this material.
void add_wall_mirror( SceneBuilder* b, uint32_t material );

// A smooth thin wall of glass.
RfMaterial make_pane( float r, float g, float b );

// What the kinds from MIRROR_BALL on have.
void add_glass( SceneBuilder* b, MirrorRoom kind );

#endif
