// Phase 2, accumulation: weights the hit records that land in a frame (E1, E3) and adds them to the halves of its
// film.
#ifndef REFRAME_REUSE_ACCUMULATE_ACCUMULATE_H
#define REFRAME_REUSE_ACCUMULATE_ACCUMULATE_H

#include "render/estimator.h"
#include "reuse/harvest/records.h"
#include "scene/lens.h"

#include <stddef.h>

typedef struct RfAccumulateScratch
{
    RF_ALIGN int32_t pixel[RF_LANES];
    RF_ALIGN float ratio[RF_LANES];     // r_t, 0 where the hit does not land
    RF_ALIGN float filter[3][RF_LANES]; // of the way to the camera; only for batches with views
    RF_ALIGN float wo[3][RF_LANES];
    RF_ALIGN float f[3][RF_LANES];
    RF_ALIGN float sum[3][RF_LANES];
    RF_ALIGN float pdf[RF_LANES];
    RF_ALIGN float offset[2][RF_LANES]; // place in the pixel; with a pixel filter, else not allocated unless the next are
    // only where light has parts
    RF_ALIGN float q[3][RF_LANES];
    RF_ALIGN float radiance[8 * RF_LANES];
    // only where it is sorted into passes: all of it by hit, towards the camera, what of it is emission or direct, and one pass, 4 per
    // hit, miss and glint
    RF_ALIGN float whole[3][RF_LANES], emission[3][RF_LANES], direct[3][RF_LANES];
    RF_ALIGN float pass[4 * RF_MOST_LISTED];
    // only where it has groups
    const float* lit[RF_LIGHT_GROUPS_MOST]; // radiance, 4 per hit, miss and glint, by base part (light/light.h)
    RF_ALIGN float lit_here[RF_LIGHT_GROUPS_MOST][8 * RF_LANES]; // where it is, if it is no array of the batch
    float sums[RF_LIGHT_GROUPS_MOST][3][RF_LANES];               // as `sum`
} RfAccumulateScratch;

// Bytes of a workspace.
static inline size_t rf_accumulate_scratch_bytes( const RfBatchShape* shape )
{
    return shape->groups > 0   ? sizeof( RfAccumulateScratch )
           : shape->passes     ? offsetof( RfAccumulateScratch, lit )
           : shape->dimmed > 0 ? offsetof( RfAccumulateScratch, whole )
           : shape->filtered   ? offsetof( RfAccumulateScratch, q )
                               : offsetof( RfAccumulateScratch, offset );
}

// What all batches of a call share.
typedef struct RfAccumulation
{
    const RfEye* eyes;
    const RfMirrors* mirrors;
    RfBatchShape shape;
    const RfPixelFilter* filter; // by which samples are spread; NULL: each counts in its own pixel
    unsigned passes;             // RF_PASS_AOVS among others
    bool extra;                  // samples are extra ones of adaptive sampling
    float weight;                // of the pass in the film
    const RfLights* lights;      // of the film's frame
    void* const* batches;        // RfHitBatch, in the order in which they add to the film
    int batch_count;
} RfAccumulation;

// A camera of the group, at a batch's point of the lens and moment of the shutter.
static inline RfEye rf_eye_of( const RfAccumulation* a, int eye, const RfHitBatch* batch )
{
    return rf_is_blurred_shape( &a->shape ) ? rf_sample_eye( a->eyes + eye, batch->lens ) : a->eyes[eye];
}

// Adds batches to some rows of a film; returns how many samples landed there. Jobs on
// different rows or films may run at the same time.
uint64_t rf_accumulate_rows( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                             RfAccumulateScratch* scratch );

// Can hits be projected once for all rows? Not where films of some of the light, or what covers pixels, want more of them.
bool rf_keeps_landings( const RfBatchShape* shape );

// Projects and lights the hits of a batch for a frame, whole, and keeps those that land (splat.h).
void rf_land_batch( const RfEstimatorGroup* group, RfAccumulateJob job, const RfHitBatch* batch, RfAccumulateScratch* scratch,
                    void* landing );

// rf_accumulate_rows with what rf_land_batch kept of each batch.
uint64_t rf_add_landings( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, void* const* landings,
                          int batch_count );

#endif
