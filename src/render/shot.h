// What is rendered: some frames of a camera's path through a scene.
#ifndef REFRAME_RENDER_SHOT_H
#define REFRAME_RENDER_SHOT_H

#include "reframe/camera.h"
#include "reframe/scene.h"

typedef struct RfShot
{
    const RfTracer* tracer;
    const RfEye* eyes; // the cameras of the whole path, all with one film size
    int eye_count;
    const int* frames; // those asked for: indices into the eyes, ascending
    int frame_count;
} RfShot;

#endif
