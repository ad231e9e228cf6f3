// Walks of bidirectional path tracing, from the eye and from lights, with what the weights of all ways to make a path need.
#ifndef REFRAME_TESTS_WALKS_H
#define REFRAME_TESTS_WALKS_H

#include "support/points.h"

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

// What carries light on to the eye at a vertex of a light path, and the density of going back: with normals of shading
// transport is not the same both ways.
RfVec3 carried_light( const Point* x, RfVec3 to_eye, float* pdf_reverse );

#endif
