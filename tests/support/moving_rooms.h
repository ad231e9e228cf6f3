// The rooms of moving_rooms.py: scenes in which something moves, and the still scene of each of their frames, which know of no
// movement.
#ifndef REFRAME_TESTS_MOVING_ROOMS_H
#define REFRAME_TESTS_MOVING_ROOMS_H

#include "scene/eye.h"
#include "scene/scene.h"

#define MOVING_EYES 7 // at most; all paths but a shorter one have as many

// A scene and the eyes of its path.
typedef struct MovingRoom
{
    RfScene scene;
    RfEye eyes[MOVING_EYES];
    int eye_count;
} MovingRoom;

// Both abort the program where a file does not load.
MovingRoom load_moving_room( const char* name, int width, int height );
MovingRoom load_still_room( const char* name, int frame, int width, int height );

#endif
