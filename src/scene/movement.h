// What moves in a scene, and by which nodes: the reader fills it, scene/pose.h evaluates it at a time.
#ifndef REFRAME_SCENE_MOVEMENT_H
#define REFRAME_SCENE_MOVEMENT_H

#include "scene/scene.h"

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
    RF_CHANGED_SKY_ROTATION, // radians
    // of a camera that moves with its node
    RF_CHANGED_YFOV,
    RF_CHANGED_YMAG,
} RfChangedValue;

typedef struct RfChange
{
    RfChangedValue value;
    int of;            // number of the light, material or camera; the sky: 0
    int slot;          // of a texture: RfTextureSlot
    RfChannel channel; // owned; its node is −1, its path RF_VALUE
} RfChange;

// A punctual light that changes.
typedef struct RfMovingLamp
{
    int punctual;
    int node;        // moving node that places, shows and hides it; −1: it stands still
    double color[3]; // as in the file, where no change has them
    double intensity, cone[2];
} RfMovingLamp;

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
    int change_count;
    RfChange* changes; // owned
    double start, end; // seconds: first and last key of all that moves or changes
} RfMovement;

// The scene's movement, which is made where there is none. NULL: there is no memory.
RfMovement* rf_open_movement( RfScene* scene );

// Gives the scene a change, with its keys, and widens the span of its movement. False: there is no memory, and the keys are freed.
bool rf_add_change( RfScene* scene, RfChange* change );

// Destroys the movement where nothing moves or changes.
void rf_drop_empty_movement( RfScene* scene );

// NULL is allowed.
void rf_destroy_movement( RfMovement* movement );

#endif
