// Small scenes made in memory for tests.
#ifndef REFRAME_TESTS_SCENE_BUILDER_H
#define REFRAME_TESTS_SCENE_BUILDER_H

#include "scene/eye.h"
#include "scene/scene.h"

typedef struct SceneBuilder
{
    RfScene scene;
    uint32_t vertex_room, triangle_room;
} SceneBuilder;

RfMaterial make_lambert( float r, float g, float b );
RfMaterial make_phong( float diffuse, float specular, float exponent );
RfMaterial make_metal( float reflectance, float roughness );
RfMaterial make_plastic( float diffuse, float roughness );
RfMaterial make_light( float radiance, bool double_sided );

// Index of the material added.
uint32_t add_material( SceneBuilder* builder, RfMaterial material );

// Two triangles a b c, a c d; front where they run counter-clockwise.
void add_quad( SceneBuilder* builder, uint32_t material, RfVec3 a, RfVec3 b, RfVec3 c, RfVec3 d );

// The inside (facing in) or outside of a box.
void add_box( SceneBuilder* builder, uint32_t material, RfVec3 low, RfVec3 high, bool inside );

// A sphere of 2 × n × n triangles with smooth normals, facing out.
void add_sphere( SceneBuilder* builder, uint32_t material, RfVec3 center, float radius, int n );

// The scene, owned by the caller; the builder is empty afterwards.
RfScene finish_scene( SceneBuilder* builder );

// x to scale x + shift: triangles, lamps at places, bounds.
void move_scene( RfScene* scene, float scale, RfVec3 shift );

typedef enum RoomKind
{
    ROOM_DIFFUSE,
    ROOM_PHONG,
    ROOM_GGX,
} RoomKind;

#define ROOM_OBJECT_MATERIAL 3 // of the sphere

// A closed 4 × 3 × 4 room (x ±2, y 0…3, z ±2) with a ceiling light, a sphere
// and a block of the given kind.
RfScene make_room( RoomKind kind );

// A floor, a metal sphere and a plastic block (under a clear coat in
// LIT_BY_MAP), without walls.
typedef enum OpenLight
{
    LIT_BY_SKY,   // constant
    LIT_BY_MAP,   // a sky of 16 × 8 pixels with a bright spot
    LIT_BY_LAMPS, // a point light, a spot and a sun
    LIT_BY_ALL,   // a small area light besides
} OpenLight;

RfScene make_open_scene( OpenLight light );

// The room with a sphere of absorbing glass, a rough pane, a thin wall of
// tinted glass and a mirror.
RfScene make_glass_room( void );

RfMaterial make_glass( float ior, float roughness, bool thin );
RfMaterial make_mirror( float reflectance );
RfPunctual make_point_light( RfVec3 position, float intensity );

// One that shines along `direction` by a profile, up to 80 degrees from it, and brighter on one side.
RfPunctual make_beam( RfVec3 position, RfVec3 direction, float intensity );

// Adds a lamp to a scene.
void add_punctual( RfScene* scene, RfPunctual lamp );

// All that shines gets a tag of light groups in turn ("key", "fill" and so on, at most 8); every `tags` + 1-th thing gets none.
void tag_lights( RfScene* scene, int tags );

// A closed box whose inside has this albedo and emits this radiance.
RfScene make_furnace( float albedo, float emission );

// `count` eyes around the sphere of the room, `degrees` apart.
void orbit_eyes( RfEye* eyes, int count, float degrees, int width, int height );

#endif
