// Renders into memory, for tests.
#ifndef REFRAME_TESTS_RENDER_SUPPORT_H
#define REFRAME_TESTS_RENDER_SUPPORT_H

#include "light_paths/light_paths.h"
#include "measure/tune.h"
#include "path/wavefront.h"
#include "reframe/render.h"
#include "support/scene_builder.h"

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
    double clamp[64], removed[64];
} Rendered;

// Aborts the test with the error's line where the render fails.
Rendered render_frames( const RfTracer* tracer, const RfEye* eyes, int eye_count, const int* frames, int frame_count,
                        const RfRenderSettings* settings );
// All frames of the path.
Rendered render_all( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings );
void free_rendered( Rendered* rendered );

// The share of values that differ by more than a hundredth.
double share_of_others( const float* a, const float* b, int count );

float* copy_floats( const float* from, size_t count );

// The defaults without tiles.
RfRenderSettings plain_settings( void );

RfTracer* make_tracer( const RfScene* scene );

static inline const float* frame_rgb( const Rendered* r, int i ) { return r->rgb + 3 * r->pixels * (size_t)i; }
static inline const float* frame_weight( const Rendered* r, int i ) { return r->weight + r->pixels * (size_t)i; }

// ---- light path set ----

// A set of light paths of a scene, without a render around it.

typedef struct LightPathSet
{
    RfTracer* tracer;
    RfRenderSettings settings;
    RfEstimatorGroup group; // points to `settings`
    RfPathSettings path;
    RfLightPaths* paths;
} LightPathSet;

// Draws the set of the first pass of a group of one eye, whose film has this many pixels; all emitters are connected. It must stay where
// it is.
void draw_light_path_set( const RfScene* scene, int width, int height, LightPathSet* set );

void free_light_path_set( LightPathSet* set );

// ---- hard cases ----

// What the tests of hard cases share: renders in many modes, and a check that the result
// is a picture.

RfRenderSettings small_settings( int group, int spp );

// Renders the path with groups of one and of several frames, all weightings
// and normalisations. Fails where a pixel is NaN or infinite, or negative
// where the estimator cannot be (E2 can: it subtracts what the other half
// found, so it may only be negative where reuse is on). The scene is the
// caller's. Returns the mean radiance of plain path tracing.
double check_sane( const char* what, const RfScene* scene, const RfEye* eyes, int eye_count );

// The same with these settings, once.
double check_sane_settings( const char* what, const RfTracer* tracer, const RfEye* eyes, int eye_count,
                            const RfRenderSettings* settings );

// ---- tune setup ----

// What the tests of tuning share: a room, a short path, a job.

#define TUNE_EYES 48
#define TUNE_WIDTH 16
#define TUNE_HEIGHT 12

typedef struct TuneSetup
{
    RfScene scene;
    RfTracer* tracer;
    RfEye eyes[TUNE_EYES];
    int frames[TUNE_EYES];
    RfRenderSettings settings;
    RfTuneJob job;
} TuneSetup;

// A job of the first `eyes` frames, with 256 MiB and 2 threads; to be ended.
void begin_tune_setup( TuneSetup* s, int eyes, int spp );
void end_tune_setup( TuneSetup* s );

// Rows that are not left out.
int tune_rows_tried( const RfTune* tune );

#endif
