// Re-projection of a batch's hits to the film of an eye. Both phases do it, with the same bits: harvest
// to test visibility, accumulate to add.
#ifndef REFRAME_REUSE_REPROJECTION_H
#define REFRAME_REUSE_REPROJECTION_H

#include "reuse/records.h"
#include "scene/eye.h"

// Pixel (y·width + x) and film density J of every hit; density 0 where the hit
// is behind the eye, outside its film or turned away, or was found by a chain that the eye
// cannot follow. Occluders do not count. filter (three arrays; may be NULL) gets what is
// left of the light on its way to the eye, but only of batches with views; offset (two; may be NULL) gets the place in
// the pixel, 0 to 1.
void rf_project_batch( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, int32_t* pixel, float* density,
                       float* const filter[3], float* const offset[2] );

// Densities at the eye whose rays found the hits: never 0, and 1 at the end of a chain.
void rf_own_densities( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, float* density,
                       float* const filter[3] );

#endif
