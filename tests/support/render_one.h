// Frames of a scene, rendered into memory with all that the driver hands over, for tests that look at more than the picture.
//
//     Stage s;
//     open_stage( &s, make_room( ROOM_GGX ), 5, 3.0f, 24, 18 );
//     const RfFrameResult *one = render_one( &s, 2, &settings ), *other = render_one( &s, 2, &others );
//     expect_sum( "room", "direct", &one->aovs[RF_AOV_DIRECT], 1, other->aovs[RF_AOV_DIRECT], values, 1e-5, bright );
//     close_stage( &s );
#ifndef REFRAME_TESTS_RENDER_ONE_H
#define REFRAME_TESTS_RENDER_ONE_H

#include "reframe/render.h"
#include "support/moving_rooms.h"
#include "support/scene_builder.h"

#define STAGE_EYES 16

// A scene and the eyes of a path, and what was rendered of them. It must stay where it is, since the tracer points to the scene.
typedef struct Stage
{
    RfScene scene;
    RfTracer* tracer; // made by the first render: until then the scene may be changed
    RfEye eyes[STAGE_EYES];
    int eye_count;
    RfRenderStats stats; // of the last render
    int handed_over;     // frames that it did
    int previews;        // that it showed of the first frame asked for
    struct Held* held;
} Stage;

// Takes the scene over, with that many eyes of orbit_eyes.
void open_stage( Stage* stage, RfScene scene, int eye_count, float degrees, int width, int height );
// Takes the scene and the eyes over.
void open_stage_before( Stage* stage, RfScene scene, const RfEye* eyes, int eye_count );
// A room of moving_rooms.h, or the still room of one of its frames.
void open_moving_stage( Stage* stage, const char* room, int width, int height );
void open_still_stage( Stage* stage, const char* room, int frame, int width, int height );
// The tracer, made if there is none.
const RfTracer* stage_tracer( Stage* stage );
// Frees all of it, results too.
void close_stage( Stage* stage );

// Render one frame, some from `first` on, or any shot; results are copies, valid until the stage is closed. They fail the test with the
// error's line where the render fails.
const RfFrameResult* render_one( Stage* stage, int frame, const RfRenderSettings* settings );
const RfFrameResult* render_some( Stage* stage, int first, int count, const RfRenderSettings* settings );
const RfFrameResult* render_shot( Stage* stage, const RfShot* shot, const RfRenderSettings* settings );
const RfFrameResult* render_stage( Stage* stage, const RfRenderSettings* settings ); // all frames

// A shot of all eyes of the stage.
RfShot stage_shot( Stage* stage, const int* frames, int frame_count );

// Fails the test unless a render of all frames ends with this error, and words.
void expect_failure( Stage* stage, const RfRenderSettings* settings, RfResult wanted, const char* words );

// Fails the test unless a render of frame 0 is RF_ERROR_USAGE with these words; NULL: unless it succeeds.
void expect_refused( Stage* stage, const RfRenderSettings* settings, const char* words );

// A copy of a result, valid until the stage is closed.
RfFrameResult hold_result( Stage* stage, const RfFrameResult* result );

// The smallest budget of frames from `first` on, by which each has a sweep of its own.
size_t least_memory( Stage* stage, int first, int count, const RfRenderSettings* settings );

// Opens lens and shutter: 0 leaves either as it is. While it is open the camera rises by 10 cm, and what moves does in `steps`.
void blur_eyes( RfEye* eyes, int count, float lens, float focus, int steps );

// The settings of small_settings (render_support.h) with this tile, by its name.
RfRenderSettings tiled_settings( int group, int spp, const char* tile );

// Combinations of group, tile and filter that split light in ways of their own, at 5 spp; at the odd ones chains are followed anyway.
#define REUSE_MODES 4
RfRenderSettings reuse_mode( int mode );

// ---- values ----

// Mean, and mean of the absolute values.
double mean_value( const float* values, int count );
double brightness( const float* values, int count );

// Fails unless the sum of the parts is what is wanted, to within `tolerance` of it and of `bright`.
void expect_sum( const char* what, const char* of, const float* const* parts, int part_count, const float* wanted, int count,
                 double tolerance, double bright );

// Fails if in an AOV that the first has a larger share of the values differs by more than a hundredth.
void expect_like_aovs( const char* what, const RfFrameResult* a, const RfFrameResult* b, double most );

// Fails unless picture, weights, AOVs and layers are the same to the bit.
void expect_same_bits( const RfFrameResult* a, const RfFrameResult* b );

#endif
