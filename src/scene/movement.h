// What moves and changes in a scene, and by which nodes and keys: the reader fills it, scene/pose.h evaluates it at a time.
#ifndef REFRAME_SCENE_MOVEMENT_H
#define REFRAME_SCENE_MOVEMENT_H

#include "scene/textured.h"

// A node that movers or joints hang on.
typedef struct RfMovingNode
{
    int node;   // of the scene
    int parent; // of this list, where it comes before; −1: a root
    int shows;  // channel that shows and hides it, or −1
} RfMovingNode;

typedef struct RfSkin
{
    int joint_count;
    int* joints;           // moving nodes
    RfMat4* inverse_binds; // from the mesh's space into that of the joint
} RfSkin;

// What one placement follows. Surfaces of a material that changes are placements that move, wherever they are.
typedef struct RfMover
{
    int node;          // moving node that shows and hides it, and places it unless a skin does
    RfMat4 local;      // within the node: of its instance
    int skin;          // −1: none
    int target_count;  // morph targets of its mesh
    double* weights;   // owned: of these where no channel animates them; NULL without targets
    int weights_moved; // channel that does, or −1
    bool flattens;     // its matrix may lose a dimension, and is then applied to a copy of the mesh
    bool settles;      // it is applied at all times: for what stands still, while it is read
} RfMover;

// A value that changes by keys, but is not of a node.
typedef enum RfChangedValue
{
    // of a punctual light, as in KHR_lights_punctual
    RF_CHANGED_INTENSITY,
    RF_CHANGED_COLOR, // 3 numbers
    RF_CHANGED_RANGE,
    RF_CHANGED_INNER_CONE, // radians
    RF_CHANGED_OUTER_CONE,
    // of a material: factors of glTF
    RF_CHANGED_BASE_COLOR, // 4
    RF_CHANGED_METALLIC,
    RF_CHANGED_ROUGHNESS,
    RF_CHANGED_EMISSIVE, // 3
    RF_CHANGED_EMISSIVE_STRENGTH,
    // of one of its textures: KHR_texture_transform
    RF_CHANGED_TEXTURE_OFFSET, // 2
    RF_CHANGED_TEXTURE_ROTATION,
    RF_CHANGED_TEXTURE_SCALE, // 2
    // of the sky
    RF_CHANGED_SKY_STRENGTH, // a factor on its radiance
    RF_CHANGED_SKY_RADIANCE, // 3 numbers: likewise
    RF_CHANGED_SKY_ROTATION, // radians
    // of the lens of a camera that moves with its node, which has the keys itself (scene/scene.h)
    RF_CHANGED_YFOV,
    RF_CHANGED_YMAG,
    RF_CHANGED_COUNT
} RfChangedValue;

#define RF_CHANGED_LAMP_VALUES ( RF_CHANGED_OUTER_CONE + 1 )

static inline bool rf_is_of_sky( RfChangedValue value )
{
    return value >= RF_CHANGED_SKY_STRENGTH && value <= RF_CHANGED_SKY_ROTATION;
}

static inline bool rf_is_of_material( RfChangedValue value )
{
    return value >= RF_CHANGED_LAMP_VALUES && value < RF_CHANGED_SKY_STRENGTH;
}

// What may be its values: from `low` to `high`, both included, and above `low` where that is 0 and `positive`.
typedef struct RfChangedTraits
{
    const char* name; // in glTF
    int components;
    double low, high;
    bool positive;
    bool limited; // `high` is a limit of this program
} RfChangedTraits;

const RfChangedTraits* rf_changed_traits( RfChangedValue value );

typedef struct RfChange
{
    RfChangedValue value;
    int of;            // number of the material; of a light: the first that has it; of the sky: 0
    int slot;          // of a texture: RfTextureSlot
    RfChannel channel; // owned; its node is −1, its path RF_VALUE
} RfChange;

// A change at `time` seconds. A spline that leaves the range between its keys is held at the end of the range.
void rf_sample_change( const RfChange* change, double time, double value[4] );

// The most of each component at any time.
void rf_most_of_change( const RfChange* change, double most[4] );

// A punctual light that moves, is switched or changes.
typedef struct RfMovingLamp
{
    int punctual;
    int node;                            // moving node that places, shows and hides it; −1: it stands still
    int changes[RF_CHANGED_LAMP_VALUES]; // of the movement, by value; −1: none
    double color[3];                     // as in the file, where no change has them
    double intensity, cone[2];
} RfMovingLamp;

// A material that dims or changes.
typedef struct RfMovingMaterial
{
    int material;
    int first_change, change_count; // of the movement
    double base[4];                 // as in the file, where no change has them
    double metallic, roughness;
    double emissive[3], strength;
    double transform[RF_TEXTURE_SLOT_COUNT][5]; // of its textures: offset, rotation, scale
} RfMovingMaterial;

typedef struct RfMovement
{
    int node_count;
    RfMovingNode* nodes; // parents first
    int skin_count;
    RfSkin* skins;
    int mover_count;
    RfMover* movers; // of the placements that move, in their order
    int lamp_count;
    RfMovingLamp* lamps;
    int material_count;
    RfMovingMaterial* materials;
    int change_count;
    RfChange* changes; // owned; those of a material one after the other
    int sequence_count;
    struct RfImageSequence* sequences; // owned: what textures show one after the other
    double start, end;                 // seconds: first and last key of all that moves or changes
} RfMovement;

// The scene's movement, which is made where there is none. NULL: there is no memory.
RfMovement* rf_open_movement( RfScene* scene );

// Gives the scene a change, with its keys, and widens the span of its movement. False: there is no memory, and the keys are freed.
bool rf_add_change( RfScene* scene, RfChange* change );

// Likewise a sequence, which the scene then owns.
bool rf_add_sequence( RfScene* scene, struct RfImageSequence* sequence );

// Destroys the movement where nothing moves or changes.
void rf_drop_empty_movement( RfScene* scene );

// NULL is allowed.
void rf_destroy_movement( RfMovement* movement );

#endif
