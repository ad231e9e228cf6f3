// The glossy hits of a batch seen from the eyes of the group. Shared by the harvest
// (densities) and accumulation (BSDFs), which must get the same bits.
#ifndef REFRAME_REUSE_GLOSSY_H
#define REFRAME_REUSE_GLOSSY_H

#include "reuse/records.h"
#include "scene/eye.h"

static inline int rf_glossy_count( const RfHitBatch* batch ) { return batch->count - batch->first[RF_BSDF_FIRST_GLOSSY]; }

// Unit directions from the glossy hits to eye number `eye` of the group, or its image in the mirror in which they were found; to their
// own eye exactly back along the ray that found them.
void rf_directions_to( const RfMirrors* mirrors, const RfEye* at, int eye, const RfHitBatch* batch, float* const wo[3] );

// f and density per solid angle of all glossy hits, from lane 0 on. Either output may
// be NULL.
void rf_evaluate_glossy( const RfHitBatch* batch, const float* const wo[3], const float* const wi[3], float* const f[3],
                         float* pdf_solid_angle );

// Sets the light of all directions to zero.
void rf_clear_directions( RfHitBatch* batch, int directions, bool eq15 );

#endif
