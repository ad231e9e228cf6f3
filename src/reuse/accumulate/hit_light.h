// The light of a batch's hits towards a camera, in each film of its frame. Films are linear in the layers (reuse/layer.h): those that
// are in the same films make one *sum*, in which each has the scale of its part. Directions of glossy hits are evaluated once for all.
#ifndef REFRAME_REUSE_ACCUMULATE_HIT_LIGHT_H
#define REFRAME_REUSE_ACCUMULATE_HIT_LIGHT_H

#include "light/light.h"
#include "reuse/project.h"

// Of glossy hits, from lane 0 on.
typedef struct RfGlossyLight
{
    RF_ALIGN float rgb[3][RF_LANES];
} RfGlossyLight;

// Of a film: 4 per hit, of diffuse ones, and of glossy ones.
typedef struct RfHitLight
{
    const float* radiance;
    const RfGlossyLight* glossy;
} RfHitLight;

// A layer that brings light to a frame.
typedef struct RfLitLayer
{
    const RfLayerLight* light;
    float scale[3];
    bool scaled;
    int sum;
} RfLitLayer;

// Workspace.
typedef struct RfHitLights
{
    const RfBatchShape* shape;
    int layer_count, sum_count;
    RfLitLayer* layers;
    RfHitLight* sums;
    float* radiance;       // of sums of several layers, 4 RF_LANES each; NULL: each has one at most
    RfGlossyLight* glossy; // of sums
    float* film_radiance;  // of the picture, and of another film; NULL: there is one sum for each film
    RfGlossyLight* film_glossy;
    RF_ALIGN float wo[3][RF_LANES];
    RF_ALIGN float f[3][RF_LANES];
    RF_ALIGN float q[3][RF_LANES];
} RfHitLights;

RfHitLights* rf_place_hit_lights( const RfBatchShape* shape, RfLayout* layout );

// Finds the light of all sums. `lights`: of the film's frame; `at`: its camera, number `eye` of the group.
void rf_light_hits( const RfLights* lights, const RfMirrors* mirrors, const RfEye* at, int eye, const RfHitBatch* batch,
                    RfHitLights* out );

// The light of a film, from the sums. The picture must have been asked for before others are.
RfHitLight rf_film_light( const RfHitBatch* batch, RfFilmLayers film, RfHitLights* lights );

// Whether a film has light of the batch in the frame of camera `eye`. Removed caustics count in their own frame alone.
bool rf_film_is_lit( const RfBatchShape* shape, const RfHitBatch* batch, RfFilmLayers film, int eye );

#endif
