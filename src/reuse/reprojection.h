// Re-projection of a batch's hits to the film of an eye. Both phases do it, with the same bits: harvest
// to test visibility, accumulate to add.
#ifndef REFRAME_REUSE_REPROJECTION_H
#define REFRAME_REUSE_REPROJECTION_H

#include "reuse/records.h"
#include "scene/eye.h"

// Pixel (y·width + x) and film density J of every hit; density 0 where the hit
// is behind the eye, outside its film or turned away. Occluders do not count.
void rf_project_batch( const RfEye* eye, const RfHitBatch* batch, int32_t* pixel, float* density );

// Densities at the eye whose rays found the hits: never 0.
void rf_own_densities( const RfEye* eye, const RfHitBatch* batch, float* density );

#endif
