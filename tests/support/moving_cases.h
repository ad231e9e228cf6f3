// Frames of the rooms of moving_rooms.h against path tracing of the still room of each.
#ifndef REFRAME_TESTS_MOVING_CASES_H
#define REFRAME_TESTS_MOVING_CASES_H

#include "support/moving_rooms.h"
#include "support/unbiased.h"

#define MOVING_WIDTH 24
#define MOVING_HEIGHT 16
#define MOVING_MOST_FRAMES 3

typedef struct MovingSetting
{
    const char* tile;
    int group, spp; // four times as many with REFRAME_LONG
    bool adaptive;
    bool connected;    // light paths
    int light_samples; // 0: 1
} MovingSetting;

extern const MovingSetting g_moving_frames, g_moving_tiles, g_moving_rooks, g_moving_adaptive, g_moving_two_lights,
    g_moving_connected;

// A room, and all that is tried in it; ends with NULL.
typedef struct MovingCase
{
    const char* room;
    int max_depth;
    int frames[MOVING_MOST_FRAMES], frame_count;
    const MovingSetting* settings[5];
} MovingCase;

bool is_moving_long( void );

RfRenderSettings moving_settings( const MovingSetting* setting, int max_depth );

// Fails unless every frame by every setting has the mean of path tracing of its still room.
void check_moving( const MovingCase* c );

// Fails unless the mean of B over the picture in the middle of the path is 1.
void assert_mean_weight_is_1( const char* room );

#endif
