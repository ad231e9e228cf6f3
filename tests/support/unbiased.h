// Is an estimator unbiased? Welch tests per block and per pixel between
// independent renders and independent references (src/reuse/estimators.md, section 9).
#ifndef REFRAME_TESTS_UNBIASED_H
#define REFRAME_TESTS_UNBIASED_H

#include "support/render_support.h"

#define SEEDS 16

typedef struct Images
{
    int width, height;
    int count;         // of images
    float* rgb[SEEDS]; // one per seed
} Images;

// `frame` of the path by the plain path tracer of the tests, one image per
// seed, from seeds that no render uses.
Images reference_images( const RfTracer* tracer, const RfEye* eyes, int frame, int spp, const RfRenderSettings* settings );
// The same without caustics, whether or not they are left out of the scene.
Images caustic_free_images( const RfTracer* tracer, const RfEye* eyes, int frame, int spp, const RfRenderSettings* settings );
// The same by a path tracer for which thin panes are vertices like other glass. It finds no punctual lights
// through them.
Images pane_vertex_images( const RfTracer* tracer, const RfEye* eyes, int frame, int spp, const RfRenderSettings* settings );
// `frame` by the renderer, seeds 1 to SEEDS.
Images rendered_images( const RfTracer* tracer, const RfEye* eyes, int eye_count, int frame, RfRenderSettings settings );
void free_images( Images* images );

typedef struct Verdict
{
    double whole_off; // relative difference of the image means, and its standard error
    double whole_error;
    double whole_p;    // of the image means
    double smallest_p; // of all blocks (place_p), times their number (Šidák)
    double uniform_p;  // that Welch's p-values of the blocks are uniform
} Verdict;

// Compares luminance in blocks of block × block pixels. Prints each block of more than a pixel whose own p is below FIRST_LEVEL,
// under a name; NULL: none.
Verdict compare_images( const char* what, const Images* a, const Images* b, int block );

// Fails unless the means agree: of the images, of blocks of block × block pixels and of pixels; prints the p-values under a name.
// Four comparisons (support/statistics.h).
void assert_unbiased( const char* what, const Images* rendered, const Images* reference, int block );

// ---- chain checks ----

// Welch tests of scenes with mirrors and glass: the whole picture as assert_unbiased does,
// and the pixels that see a delta or nearly specular surface taken together, over three frames.

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
