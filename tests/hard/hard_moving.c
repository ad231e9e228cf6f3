// Hard cases of what moves: rooms of support/moving_rooms.py, whose pictures are those of the still room of the frame.
#include "hard/hard.h"
#include "support/moving_rooms.h"

#include <string.h>

static void load( HardScene* h, const char* name )
{
    MovingRoom room = load_moving_room( name, HARD_WIDTH, HARD_HEIGHT );
    h->scene = room.scene;
    h->eye_count = room.eye_count;
    memcpy( h->eyes, room.eyes, sizeof room.eyes );
    h->still = load_still_room( name, h->eye_count / 2, HARD_WIDTH, HARD_HEIGHT ).scene;
}

static void sweep( HardScene* h ) { load( h, "sweep" ); }
static void lid( HardScene* h ) { load( h, "shown" ); }
static void around_eye( HardScene* h ) { load( h, "around-eye" ); }
static void flat( HardScene* h ) { load( h, "flat" ); }
static void singular( HardScene* h ) { load( h, "singular" ); }
static void late( HardScene* h ) { load( h, "late" ); }
static void no_area( HardScene* h ) { load( h, "no-area" ); }

// The lenses would be as large as the scene.
static void far_out( HardScene* h )
{
    load( h, "far-out" );
    h->sharp = true;
}

static void plate( HardScene* h ) { load( h, "plate" ); }

static void short_path( HardScene* h )
{
    load( h, "short-path" );
    h->group = 1 << 20;
}

const HardCase g_hard_moving[] = {
    { "moves-sweep", "a panel passes between lamp, wall and eye", "hits that its frame alone sees", HARD_PLAIN, 3.0, sweep,
      NULL },
    { "moves-lid", "a lid covers the lamp in some frames", "light of other frames", HARD_PLAIN, 3.0, lid, NULL },
    { "moves-around-eye", "a box is around the eye in one frame", "hits of frames that see past it", HARD_PLAIN, 1.5, around_eye,
      NULL },
    { "moves-flat", "scales of 0 along one axis and all", "matrices without an inverse", HARD_PLAIN, 1.5, flat, NULL },
    { "moves-singular", "a skin whose joints have scales of 0", "normals of length 0", HARD_PLAIN, 1.5, singular, NULL },
    { "moves-late", "nothing stands still, nor is there in the first frame", "a scene without triangles or bounds", HARD_PLAIN,
      1.5, late, NULL },
    { "moves-no-area", "triangles without an area move", "normals of length 0", HARD_PLAIN, 1.5, no_area, NULL },
    { "moves-far-out", "things go 1e6 m away and come back", "bounds, offsets", HARD_PLAIN, 1.5, far_out, NULL },
    { "moves-short-path", "a group of 2097153 in a path of 3 frames", "worlds of frames that are not", HARD_PLAIN, 1.5,
      short_path, NULL },
    { "moves-plate", "a plate covers the sun from 9 km above, for a moment", "rays to the sun that end before", HARD_PLAIN, 1.5,
      plate, NULL },
    { 0 },
};
