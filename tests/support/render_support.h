// Renders into memory, for tests.
#ifndef REFRAME_TESTS_RENDER_SUPPORT_H
#define REFRAME_TESTS_RENDER_SUPPORT_H

#include "reframe/render.h"

// Frames as they come, one after another: 3 floats (and 1 weight) per pixel.
typedef struct Rendered
{
    int count;
    size_t pixels;
    float* rgb;
    float* weight;
    RfRenderStats stats;
    double relmse_estimate[64];
    double relmse_likely[64];
    bool relmse_is_lower_bound[64];
    double native_spp[64];
    double effective_spp[64];
} Rendered;

// Aborts the test with the error's line where the render fails.
Rendered render_frames( const RfTracer* tracer, const RfEye* eyes, int eye_count, const int* frames, int frame_count,
                        const RfRenderSettings* settings );
// All frames of the path.
Rendered render_all( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings );
void free_rendered( Rendered* rendered );

// The defaults without tiles.
RfRenderSettings plain_settings( void );

RfTracer* make_tracer( const RfScene* scene );

static inline const float* frame_rgb( const Rendered* r, int i ) { return r->rgb + 3 * r->pixels * (size_t)i; }
static inline const float* frame_weight( const Rendered* r, int i ) { return r->weight + r->pixels * (size_t)i; }

#endif
