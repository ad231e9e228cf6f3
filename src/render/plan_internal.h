// Shared by the files of the plan.
#ifndef REFRAME_RENDER_PLAN_INTERNAL_H
#define REFRAME_RENDER_PLAN_INTERNAL_H

#include "reframe/plan.h"
#include "base/arena.h"
#include "render/sizes.h"

// Traces some batches of the path by the estimator, one at a time.
typedef struct PlanProbe
{
    const RfEye* eyes;
    int eye_count;
    RfRenderSettings settings; // with a seed of its own
    RfArena arena;
    RfRenderSizes sizes; // for the largest group looked at
    void *scratch, *batch;
    RfEstimatorGroup group;
    int eye; // index in it of the frame that is traced
} PlanProbe;

// The probe looks at so many frames, and batches of each.
#define PLAN_FRAMES 4
#define PLAN_JOBS 8

// What it counted: sums over own-frame samples.
typedef struct PlanCounts
{
    double samples, hits, glossy;
    RfRayCounts rays; // without reuse
    // by row
    double share[RF_PLAN_ROWS]; // Σ w: share of each hit's weight that its own frame keeps
    double eye_rays[RF_PLAN_ROWS];
} PlanCounts;

// For groups of up to `most_eyes`. Fails with RF_ERROR_MEMORY.
RfResult rf_begin_probe( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                         int most_eyes, PlanProbe* probe, RfError* error );
void rf_end_probe( PlanProbe* probe );

// Sets the probe's group to `eyes` frames around `frame`, as far as the path goes.
void rf_aim_probe( PlanProbe* probe, int frame, int eyes );

// The i-th of the frames looked at, and the batch of the k-th position there.
int rf_probe_frame( const PlanProbe* probe, int i );
int rf_probe_job( const PlanProbe* probe, int i, int k );

// Counts for groups of eyes[0 … rows), the first of which is 1.
void rf_count_plan( PlanProbe* probe, const int* eyes, int rows, PlanCounts* counts );

// Cost of a pixel over all groups where a sample costs `own`, and `reuse` for every other eye of
// its group: Σ passes · eyes · (own + (eyes − 1) · reuse).
double rf_plan_work( const RfGroupPlan* plan, double own, double reuse );

#endif
