// Hits that were found in flat mirrors, and the images of the cameras in these: one more way for each camera
// to see such a hit (src/reuse/estimators.md, section 10).
#ifndef REFRAME_REUSE_CHAINS_MIRRORED_H
#define REFRAME_REUSE_CHAINS_MIRRORED_H

#include "reuse/record.h"
#include "scene/eye.h"

// Where the hits of a batch land on the film of a camera, by hit.
typedef struct RfProjectedLanes
{
    int32_t* pixel;   // y·width + x
    float* density;   // film density J; 0: the camera does not see the hit there
    float* filter[3]; // throughput of the way to the camera, set for batches with views only; NULL: not asked for
    float* offset[2]; // the place in the pixel, 0 to 1; NULL: not asked for
} RfProjectedLanes;

static inline bool rf_is_mirrored( uint8_t view )
{
    return rf_calls_for( view >= RF_VIEW_FIRST_MIRROR && view < RF_VIEW_FROSTED, RF_EFFECT_FLAT_MIRRORS );
}

// True if the camera's straight ray found the hit.
static inline bool rf_is_straight( uint8_t view )
{
    return view == RF_VIEW_DIRECT || view == RF_VIEW_FROSTED || view == RF_VIEW_BASE;
}

// Projects the mirrored hits through the image of the camera: pixel and density J of the image times the probability
// that the mirror reflects, 0 where the image does not face the hit. Occluders and the mirror's outline do not count.
// The filter is the weight of the reflection. Other lanes are left alone.
void rf_project_mirrored( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, RfProjectedLanes out );

// Density and filter for the camera whose chains found them: neither its film nor its side of the mirror counts.
void rf_own_mirrored_densities( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, RfProjectedLanes out );

// Unit directions from the mirrored glossy hits to the image of the camera; lane 0 is the first glossy hit.
void rf_directions_to_image( const RfMirrors* mirrors, const RfEye* eye, const RfHitBatch* batch, float* const wo[3] );

// Tests whether the camera sees the mirrored hits with density > 0 in their mirror; other lanes are left alone. `lifted`: the
// hits, off their surface. Returns the rays traced.
int rf_see_mirrored( const RfTracer* tracer, const RfEye* eye, const RfHitBatch* batch, const float* const lifted[3],
                     uint32_t* triangle, float* density );

#endif
