// Walks of bidirectional path tracing, from the camera and from lights, with what the weights of all ways to make a path need.
#ifndef REFRAME_TESTS_BIDIRECTIONAL_H
#define REFRAME_TESTS_BIDIRECTIONAL_H

#include "scene/eye.h"
#include "support/reference_tracer.h"
#include "trace/trace.h"

#include <stdint.h>

// The weights of all ways to make a path follow from two sums that a walk carries along (Georgiev, Implementing Vertex
// Connection and Merging, 2012, with one way to merge less): `vcm` and `vc`, quotients of the densities of the ways that
// start at the other end and of the way taken.
typedef struct Walk
{
    RfVec3 o, d, throughput;
    float vcm, vc;
    float full; // brightness at the start, for roulette
    bool from_light;
    RfRandomKey key;
    uint32_t dimension;
    int hits;
} Walk;

// Goes on to the next surface; false where there is none.
bool advance_walk( const RfTracer* tracer, Walk* w, Point* x );

// Scatters; false where the walk ends.
bool scatter_walk( Walk* w, const Point* x );

Point seen_from( const Point* x, RfVec3 wo );

// What carries light on to the camera at a vertex of a light path, and the density of going back: with normals of shading
// transport is not the same both ways.
RfVec3 carried_light( const Point* x, RfVec3 to_eye, float* pdf_reverse );

// ---- bidirectional ----

// A plain bidirectional path tracer (Veach 1997), one path at a time: camera paths and light paths, one of each for each pixel
// and pass, connected in all ways, light paths with the camera too, with balance weights. A baseline for measurements, and a referee that
// shares only the points of surfaces with the tracers it is compared with.

typedef struct BidirectionalSettings
{
    int spp;
    int max_depth; // surfaces on a path, the emitter's among them
    uint64_t seed;
} BidirectionalSettings;

// NULL, or what the scene has that is not dealt with: lights other than triangles, thin or rough glass, cameras with lenses
// and the like.
const char* bidirectional_lacks( const RfTracer* tracer, const RfEye* eye );

// The whole image by a box filter, 3 floats per pixel.
void bidirectional_image( const RfTracer* tracer, const RfEye* eye, const BidirectionalSettings* settings, float* rgb );

#endif
