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

#endif
