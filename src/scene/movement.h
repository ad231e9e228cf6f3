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

// What one placement follows.
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

typedef struct RfMovement
{
    int node_count;
    RfMovingNode* nodes; // parents first
    int skin_count;
    RfSkin* skins;
    int mover_count;
    RfMover* movers;   // of the placements that move, in their order
    double start, end; // seconds: first and last key of all that moves them
} RfMovement;

// NULL is allowed.
void rf_destroy_movement( RfMovement* movement );

#endif
