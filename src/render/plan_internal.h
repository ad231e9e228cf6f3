// Shared by the files of the plan.
#ifndef REFRAME_RENDER_PLAN_INTERNAL_H
#define REFRAME_RENDER_PLAN_INTERNAL_H

#include "reframe/plan.h"
#include "render/render_internal.h"

// Some hits of the path, harvested by the render's own phase, one batch at a time.
typedef struct PlanProbe
{
    const RfTracer* tracer;
    const RfEye* eyes;
    int eye_count;
    const RfRenderSettings* settings;
    RfArena arena;
    RenderSizes sizes; // for the largest group looked at
    RfHarvestScratch* scratch;
    RfHitBatch batch;
    void* batch_memory;
    RfHarvest harvest;
} PlanProbe;

// Where the probe looks: so many frames, and patches of each.
#define PLAN_FRAMES 4
#define PLAN_PATCHES 8

// What it counted: sums over the native samples.
typedef struct PlanCounts
{
    double samples, hits, glossy;
    RfRayCounts rays; // without reuse
    // by row
    double share[RF_PLAN_ROWS]; // Σ w: of each hit, the part that is left of it in its own frame
    double eye_rays[RF_PLAN_ROWS];
} PlanCounts;

// For groups of up to `most_eyes`. Fails with RF_ERROR_MEMORY.
RfResult rf_begin_probe( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                         int most_eyes, PlanProbe* probe, RfError* error );
void rf_end_probe( PlanProbe* probe );

// Sets the probe's group to `eyes` frames around `frame`, as far as the path goes.
void rf_aim_probe( PlanProbe* probe, int frame, int eyes );

// The i-th of the frames looked at, and the patch of the k-th place there.
int rf_probe_frame( const PlanProbe* probe, int i );
int rf_probe_patch( const PlanProbe* probe, int i, int k );

// Counts for groups of eyes[0 … rows), the first of which is 1.
void rf_count_plan( PlanProbe* probe, const int* eyes, int rows, PlanCounts* counts );

// Settings that are resolved but for the group.
RfResult rf_resolve_common( const RfEye* eyes, int eye_count, const RfRenderSettings* settings, RfRenderSettings* resolved,
                            RfError* error );

// What a pixel of all windows takes where a sample takes `own`, and every other
// eye of its window `reuse`: Σ passes · eyes · (own + (eyes − 1) · reuse).
double rf_plan_work( const RfGroupPlan* plan, double own, double reuse );

#endif
