// Auxiliary features for denoisers: the albedo and the shading normal of what a camera ray shows. At mirrors and clear glass that
// is not their own but that of the first surfaces behind them that are neither, reflected and transmitted ones blended by
// Fresnel's equations (the documentation of Open Image Denoise, "Albedos" and "Normals").
#ifndef REFRAME_PATH_FEATURES_H
#define REFRAME_PATH_FEATURES_H

#include "path/wavefront.h"

// By slot.
typedef struct RfFeatures
{
    RF_ALIGN float albedo[3][RF_LANES]; // 0 to 1: reflectance, and what the surfaces or the sky emit
    float normal[3][RF_LANES];          // blended unit vectors; the sky: 0
    // inside
    float share[RF_LANES]; // of the blend that the way which is followed has
} RfFeatures;

// Reflectance of lane i for light along the normal, 0 to 1. The coat of a dielectric reflects before its base does. Transmission
// counts as well: glass is as bright as what is behind it.
RfVec3 rf_albedo_of_lane( const RfVertexLanes* v, int i );

// The shading normal of lane i on the side of the camera.
RfVec3 rf_seen_normal( const RfVertexLanes* v, int i );

// The features of camera rays, of which `first` are the hits. The first mirror or glass that a ray hits reflects and transmits;
// later ones do what is more likely, with the weight of both, so that no chance is in it. With `sky`, rays that hit nothing at
// once have the sky's features; else 0. Uses the wavefront's workspace, but for its keys and arrivals.
void rf_find_features( const RfPathSettings* path, const RfVertexLanes* first, const RfRayLanes* camera_rays, bool sky,
                       RfWavefront* wavefront, RfFeatures* features );

#endif
