// A path tracer in doubles, written apart from the library: triangles by brute force, flat normals, no offsets, light
// sampling alone. It knows Lambert, Phong and GGX, area lights, point lights and a constant sky.
#ifndef REFRAME_TESTS_HARD_DOUBLE_H
#define REFRAME_TESTS_HARD_DOUBLE_H

#include "scene/scene.h"
#include "reframe/camera.h"

#include <stdint.h>

// The picture of an eye that stands still, a pinhole or with a round lens: 3 doubles per pixel.
void hard_double_image( const RfScene* scene, const RfEye* eye, int spp, int max_depth, uint64_t seed, double* rgb );

#endif
