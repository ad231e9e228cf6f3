// Rooms with mirrors and glass, for the tests of chains: what the eye sees through delta
// vertices before the first one that can be evaluated.
#ifndef REFRAME_TESTS_ROOMS_H
#define REFRAME_TESTS_ROOMS_H

#include "scene/textured.h"
#include "support/scene_builder.h"

typedef enum MirrorRoom
{
    FLAT_MIRROR,      // a tinted mirror on the back wall
    FACING_MIRRORS,   // and another on the front wall, behind the eyes
    CORNER_MIRRORS,   // and another at right angles to it
    L_SHAPED_MIRROR,  // many coplanar triangles in an oblique plane
    COPLANAR_MIRRORS, // two mirrors of different tints in one plane
    NARROW_MIRROR,    // on the right of the back wall: at the border of film of sweep_eyes
    STANDING_MIRROR,  // a sheet in the middle of the room that mirrors on both sides, in the plane z = 0
    BUMPY_MIRROR,     // with a normal map
    TEXTURED_MIRROR,  // with a textured reflectance
    MASKED_MIRROR,    // likewise, with holes
    BLENDED_MIRROR,   // lets part of the light straight through
    MASKED_SCREENS,   // sheets with holes before the mirror, and behind the eyes where it alone shows them
    BLENDED_SCREENS,  // the same, half transparent
    MIRROR_BY_SIGN,   // a lamp behind the eyes, seen in the mirror
    MIRROR_BEHIND_PANE,
    MIRROR_BALL,
    GLASS_BALL,
    ABSORBING_BALL,
    GLASS_SLAB,
    ABSORBING_SLAB,
    ROUGH_SLAB,
    LAYERED_SLAB,       // glass over a diffuse base that shines a little
    PANES_IN_A_ROW,     // three tinted thin walls
    LAMP_IN_GLASS,      // a lamp within an absorbing ball
    GLASS_TANK,         // eyes within an absorbing body
    SHARP_METAL,        // GGX of roughness 0.05: a ball, a panel on the wall
    SMOOTH_PLASTIC,     // the smoothest dielectric over a diffuse base, likewise
    SHARP_PLASTIC,      // roughness 0.05
    CLEAR_COAT,         // the smoothest clear coat
    MIRROR_BEHIND_BULB, // of thin glass, which the mirror shows too; both show a lamp behind the eyes
    FROSTED_SHEETS,     // panes in a row, two of them rough, and a mirror
    MIRROR_ROOM_COUNT
} MirrorRoom;

// A closed 4 × 3 × 4 room (x ±2, y 0…3, z ±2) with a ceiling light, panels of colour, a block,
// a ball, and what the kind says. Eyes of orbit_eyes see most of it.
RfScene make_mirror_room( MirrorRoom kind );

// The open scene with a mirror behind its ball.
RfScene make_mirror_in_the_open( OpenLight light );

// The open scene under a constant sky, with absorbing slabs: one above the ground, which lights through it, and one that lies 2 mm
// over it.
RfScene make_glass_in_the_open( void );

// Eyes that see the ground below these slabs, past them and through them.
void low_eyes( RfEye* eyes, int count, int width, int height );

// Eyes that turn by 8 degrees a frame, so that NARROW_MIRROR leaves the film.
void sweep_eyes( RfEye* eyes, int count, int width, int height );

// Eyes that pass through the plane of STANDING_MIRROR: in front of it, the middle one exactly
// in it, and behind it.
void crossing_eyes( RfEye* eyes, int count, int width, int height );

// ---- pane room ----

// A room with thin panes of all kinds.

typedef enum PaneLight
{
    PANES_AND_AREA_LIGHT,
    PANES_AND_LAMP, // a point light
    PANES_AND_SUN,
    PANES_AND_SKY,
    PANES_AND_ALL,
} PaneLight;

// The GGX room of scene_builder.h, lit through a ceiling of clear panes, two in a row. Inside stand coloured
// panes, one with a base, one whose transmission and roughness vary, one with bumps, one that is alpha-blended,
// a ball of thin glass and a blended curtain.
RfScene make_pane_room( PaneLight light );

// The GGX room with small curved gloss of this kind, which a lamp without size shines at: a ball, and a block around it.
RfScene make_glint_room( RfBsdfKind kind );

// A smooth thin wall with this tint over a Lambert base.
RfMaterial make_thin_pane( RfVec3 tint, float base );

// F of a dielectric, by Fresnel's equations.
double fresnel( double cos_theta, double ior );

// ---- curtain room ----

typedef enum CurtainRoom
{
    CURTAIN,
    CURTAIN_CROSSED,   // and a sheet in the plane z = 0, which crossing_eyes pass through
    CURTAIN_AND_GLASS, // and a ball of glass
} CurtainRoom;

// A room of the size of make_room behind a curtain that lets the light of a lamp through, with a textured sheet and a lamp shade:
// all of these scatter light to both of their sides.
RfScene make_curtain_room( CurtainRoom kind );

// ---- textured room ----

// A room where everything that textures can change is changed.

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
