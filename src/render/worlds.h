// The scene at the frames of a group, where something moves: each frame is posed and has a tracer of its own, made when a group
// reaches the frame and freed when it is left.
#ifndef REFRAME_RENDER_WORLDS_H
#define REFRAME_RENDER_WORLDS_H

#include "reframe/render.h"
#include "scene/moments.h"
#include "trace/trace.h"

// One frame of the path.
typedef struct RfWorld
{
    int frame;           // −1: free
    int moments;         // that it is posed at
    RfPosedScene* poses; // of these; where there are several the middle one has them all (scene/moments.h)
    RfMoments* joined;   // NULL: there is a single one
    RfVec3* emission;    // of materials that dim, in the middle one; NULL: no light changes
    RfTracer* tracer;
} RfWorld;

typedef struct RfWorlds
{
    const RfTracer* still; // of the scene as it was loaded
    const RfEye* eyes;     // of the whole path: their times and the moments of their shutters count
    int frames;            // of it
    bool neighbours;       // the frames before and after those of a group are wanted as well
    int count;             // worlds that are held at once; 0: nothing moves
    RfWorld* worlds;
    const RfTracer** tracers; // by frame; NULL: it is not open
    RfSwept* swept;           // of swept_count frames from first_swept on
    int first_swept, swept_count;
    bool lights_change;
    struct RfGroupLights* lights; // of the frames opened last; NULL: none changes
    int first_lit, lit_count;
    RfResult result; // of the first failure, after which all frames have the scene as it was loaded
    RfError error;
} RfWorlds;

// How many are held at once for groups of up to `eyes` of the path's frames; 0 where nothing moves. `neighbours`: with the
// frames before and after a group; `ahead`: with half a group after it, for groups around its last frame.
int rf_worlds_held( const RfScene* scene, int frames, int eyes, bool neighbours, bool ahead );

// Bytes that so many need, with the swept geometry and the lights of a group of them. `steps`: the most of the path's eyes
// (RfEye.blur_steps).
size_t rf_worlds_bytes( const RfScene* scene, int count, int steps );

// `count`: as rf_worlds_held has it for the groups that will be opened. Fails with RF_ERROR_MEMORY.
RfResult rf_create_worlds( const RfShot* shot, int count, bool neighbours, RfWorlds* worlds, RfError* error );
void rf_destroy_worlds( RfWorlds* worlds );

// Opens frames [first, first + count); returns their tracers, which have swept geometry where they are several, or NULL where nothing moves.
// They are valid until other frames are opened; those among them stay. Not to be called by several threads at once.
const RfTracer* const* rf_open_worlds( RfWorlds* worlds, int first, int count );

// The failure of opening frames, if one has failed.
static inline RfResult rf_check_worlds( const RfWorlds* worlds, RfError* error )
{
    return worlds->result == RF_OK ? RF_OK : rf_fail( error, worlds->result, "%s", worlds->error.text );
}

// The tracer of a frame; NULL where nothing moves, or it is not open or not in the path.
static inline const RfTracer* rf_world_tracer( const RfWorlds* worlds, int frame )
{
    return worlds->count > 0 && frame >= 0 && frame < worlds->frames ? worlds->tracers[frame] : NULL;
}

#endif
