// Hits that were found in flat mirrors, and the images of the eyes in these: one more way for each eye
// to see such a hit (src/reuse/estimators.md, section 10).
#ifndef REFRAME_REUSE_CHAINS_MIRRORED_H
#define REFRAME_REUSE_CHAINS_MIRRORED_H

#include "reuse/harvest/records.h"
#include "scene/eye.h"

static inline bool rf_is_mirrored( uint8_t view )
{
    return rf_calls_for( view >= RF_VIEW_FIRST_MIRROR && view < RF_VIEW_BASE, RF_EFFECT_FLAT_MIRRORS );
}

// True if the eye's straight ray found the hit.
static inline bool rf_is_straight( uint8_t view ) { return view == RF_VIEW_DIRECT || view == RF_VIEW_BASE; }

// Projects the mirrored hits through the image of the eye: pixel and density J of the image times the probability
// that the mirror reflects, 0 where the image does not face the hit. Occluders and the mirror's outline do not count.
// filter (three arrays; may be NULL) gets the weight of the reflection, offset (two; may be NULL) the place in the pixel.
// Other lanes are left alone.
void rf_project_mirrored( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, int32_t* pixel, float* density,
                          float* const filter[3], float* const offset[2] );

// The same for the eye whose chains found them: neither its film nor its side of the mirror counts.
void rf_own_mirrored_densities( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, float* density,
                                float* const filter[3] );

// Unit directions from the mirrored glossy hits to the image of the eye; lane 0 is the first glossy hit.
void rf_directions_to_image( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, float* const wo[3] );

// Tests whether the eye sees the mirrored hits with density > 0 in their mirror; other lanes are left alone. `lifted`: the
// hits, off their surface. Returns the rays traced.
int rf_see_mirrored( const RfTracer* tracer, const RfEye* eye, const RfHitBatch* batch, const float* const lifted[3],
                     float* density );

#endif
