// Points of surfaces, one at a time, for the plain tracers of the tests.
#ifndef REFRAME_TESTS_REFERENCE_TRACER_H
#define REFRAME_TESTS_REFERENCE_TRACER_H

#include "base/random.h"
#include "bsdf/bsdf.h"
#include "reframe/render_settings.h"
#include "scene/eye.h"
#include "trace/trace.h"

#include <stdint.h>

// A surface point, seen along −wo.
typedef struct Point
{
    RfVec3 p, ng, n, wo;
    RfVec3 coat_n;
    RfVec3 tangent;      // of anisotropic materials
    RfMaterial material; // as it is here
    bool inside;         // seen from behind
    float ior;           // relative, for glass
    RfVec3 emission;
    float offset;
    uint32_t light;  // its number, or RF_NO_LIGHT
    float light_pdf; // of a light sample at the ray's origin choosing this point, once the light is picked
} Point;

// The thin panes on a straight way: the probability of passing, and the colour over it.
typedef struct Panes
{
    float probability;
    RfVec3 weight;
} Panes;

// The random numbers of a path.
typedef struct Numbers
{
    RfRandomKey key;
    uint32_t block; // dimensions of a vertex; 0: all are random, else those where it begins are of a lattice
    uint64_t seed;
    uint32_t pass, frame, x, y;
} Numbers;

// Parameters of a point as one lane.
typedef struct Lane
{
    float param[RF_PARAM_COUNT];
    RfBsdfLanes lanes;
} Lane;

// Where a path goes on from a point: direction, f |cos| / density, density,
// and where the ray starts; side 0 where it ends.
typedef struct Onward
{
    RfVec3 wi, weight, f;
    float pdf, cos_x, side;
} Onward;

// What a ray meets first; `panes`: those on the way; NULL: they are found like other surfaces.
bool find_point( const RfTracer* tracer, RfVec3 o, RfVec3 d, Point* out, Panes* panes );

void fill_point_lane( const Point* x, Lane* lane );

// Of mirrors and glass.
bool is_native_point( const Point* x );

// f and density of the lobes that can be asked, for light from wi.
RfVec3 evaluate_point( const Point* x, RfVec3 wi, float* pdf );

// Samples by three random numbers from this dimension on.
Onward scatter_at( const Point* x, Numbers key, uint32_t dimension );

RfVec3 onward_start( const Point* x, const Onward* onward );

// Of the light from x to o, which is inside of the body if x is seen from there.
RfVec3 part_left_at( const Point* x, RfVec3 o );

// ---- reference tracer ----

// A plain path tracer, one path at a time, that knows nothing of wavefronts,
// groups, records or weights over eyes: the independent reference of the
// statistical tests, and what `--group 0` must equal bit for bit.

typedef struct ReferenceSettings
{
    int spp;
    int max_depth;
    int light_samples;
    uint64_t seed;
    int frame; // of the path: it goes into the random numbers
    RfLightSampling light_sampling;
    bool panes_are_vertices; // thin panes scatter by their delta lobes and stop light samples, as other glass does
    bool stratified;         // takes the numbers that the renderer has; else random ones, whatever the renderer does
    bool without_caustics;   // light that mirrors, glass and smooth metals throw on other surfaces does not count
} ReferenceSettings;

// For a frame of a render of single pixels and frames, with its numbers.
ReferenceSettings reference_settings_of( const RfRenderSettings* settings, int frame );

// Mean radiance of one path through a pixel of one pass: frame, pass and pixel
// choose the random numbers as the renderer does without groups.
RfVec3 reference_sample( const RfTracer* tracer, const RfEye* eye, const ReferenceSettings* settings, int pass, int x, int y );

// The whole image, 3 floats per pixel: passes summed in two halves (even and
// odd ones), as the film does.
void reference_image( const RfTracer* tracer, const RfEye* eye, const ReferenceSettings* settings, float* rgb );

#endif
