// The hits of a batch as a camera of the group sees them: their reprojection to its film, and the scattering of glossy hits
// towards it. Both phases do it, with the same bits: the harvest for visibility and densities, accumulation to add.
#ifndef REFRAME_REUSE_PROJECT_H
#define REFRAME_REUSE_PROJECT_H

#include "reuse/chains/mirrored.h"
#include "scene/eye.h"

// Projects the hits to a camera. The density is 0 where the hit is behind the camera, outside its film or turned away, or was
// found by a chain that the camera cannot follow. Occluders do not count.
void rf_project_batch( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, RfProjectedLanes out );

// Densities and filters at the camera whose rays found the hits: never 0, and 1 at the end of a chain. Pixels and places are the
// batch's own.
void rf_own_densities( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, RfProjectedLanes out );

static inline int rf_glossy_count( const RfHitBatch* batch ) { return batch->count - batch->first[RF_BSDF_FIRST_GLOSSY]; }

// Unit directions from the glossy hits to camera number `eye` of the group, or its image in the mirror in which they were
// found; to their own camera exactly back along the ray that found them.
void rf_directions_to( const RfMirrors* mirrors, const RfEye* at, int eye, const RfHitBatch* batch, float* const wo[3] );

// f and density per solid angle of all glossy hits, from lane 0 on. Either output may
// be NULL.
void rf_evaluate_glossy( const RfHitBatch* batch, const float* const wo[3], const float* const wi[3], float* const f[3],
                         float* pdf_solid_angle );

#endif
