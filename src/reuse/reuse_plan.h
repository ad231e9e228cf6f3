// A group compiled: what its batches are made of, and which films they add to. Made once for all groups of a render that have so
// many frames, and const from then on; RfEstimatorGroup carries it.
#ifndef REFRAME_REUSE_REUSE_PLAN_H
#define REFRAME_REUSE_REUSE_PLAN_H

#include "render/estimator.h"
#include "reuse/record.h"
#include "reuse/tile/tile.h"

// The films of a frame: the picture, light groups in the order of their base parts, passes, removed light.
#define RF_FRAME_FILMS_MOST ( 2 + RF_LIGHT_GROUPS_MOST + RF_KINDS )

typedef struct RfReusePlan
{
    RfBatchShape shape;
    RfPatchLayout patches;
    bool alpha; // the sky that camera rays see is black: RF_AOV_ALPHA
    int film_count;
    RfFilmLayers films[RF_FRAME_FILMS_MOST];
} RfReusePlan;

// `even_light_samples`: first hits have no more light samples than other vertices, and light is not told apart by layers.
void rf_compile_reuse( const RfEstimatorGroup* group, bool even_light_samples, RfReusePlan* out );

// The group's own.
static inline const RfReusePlan* rf_reuse_plan( const RfEstimatorGroup* group ) { return group->compiled; }

#endif
