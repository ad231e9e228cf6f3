// Welch tests of scenes with mirrors and glass: the whole picture as assert_unbiased does,
// and the pixels that see a delta or nearly specular surface taken together, over three frames.
#ifndef REFRAME_TESTS_CHAIN_CHECKS_H
#define REFRAME_TESTS_CHAIN_CHECKS_H

#include "support/render_support.h"

#define CHAIN_EYES 7
#define CHAIN_WIDTH 32
#define CHAIN_HEIGHT 24

typedef struct ChainSetting
{
    int group;
    const char* tile;
    int spp;        // four times as many with REFRAME_LONG
    bool adaptive;  // extra samples
    bool connected; // light paths
} ChainSetting;

typedef struct ChainCase
{
    const char* what;
    RfEye eyes[CHAIN_EYES];
    bool every_frame; // frames 1, 3 and 5 are tested by block and pixel, else only frame 3
    int max_depth;
    const ChainSetting* settings; // each is tested; with REFRAME_LONG those of g_all_reuse too
    int setting_count;
} ChainCase;

// Settings for a case: tiles, groups of 1 and of 3, groups of 3 with tiles.
extern const ChainSetting g_all_reuse[4];
// Tiles, groups of 3 with tiles: what takes half the time.
extern const ChainSetting g_tiles_and_both[2];

// Groups of 3 with tiles, adaptive.
extern const ChainSetting g_adaptive[1];

// Path tracing, and groups of 1 with tiles, both with light paths.
extern const ChainSetting g_connected[2];

// An orbit with g_tiles_and_both.
ChainCase chain_case( const char* what, int max_depth );

// Fails unless every setting renders the case without bias. Destroys the scene.
void check_chains( const ChainCase* tested, RfScene scene );

#endif
