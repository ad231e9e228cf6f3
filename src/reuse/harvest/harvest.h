// First phase, harvest: traces one patch of one frame in one pass into a batch of hit records: first hits, the light that
// arrives at them, their visibility from every camera of the group, and the densities for MIS weights.
#ifndef REFRAME_REUSE_HARVEST_HARVEST_H
#define REFRAME_REUSE_HARVEST_HARVEST_H

#include "light_paths/connections.h"
#include "path/wavefront.h"
#include "reuse/reuse_plan.h"

// What the steps of a batch are given.
typedef struct RfHarvest
{
    const RfEstimatorGroup* group;
    const RfReusePlan* plan;
    const RfBatchShape* shape;       // of the plan
    RfPathSettings path;             // of camera rays; of the paths from their hits on, once rf_harvest_hits has found them
    const RfTracer* const* tracers;  // as in RfEstimatorGroup, at the batch's moment of the shutter
    const RfEye* eyes;               // shape->eyes of them, at the batch's point of the lens
    const RfLightPaths* light_paths; // NULL: none
    bool path_roulette;              // see RfTileReuseSettings
    const int32_t* path_source;      // its `source`
} RfHarvest;

// Positions in pixels are drawn by it; NULL: uniformly.
static inline const RfPixelFilter* rf_drawn_by( const RfEstimatorGroup* group )
{
    return group->need != NULL ? group->filter : NULL;
}

// The group's, at no point of the lens and moment yet.
RfHarvest rf_make_harvest( const RfEstimatorGroup* group );

// A thread's workspace.
typedef struct RfHarvestScratch RfHarvestScratch;

// Fills `batch` with the hits of patch job.job; adds the rays traced to `rays`. Returns the camera rays.
int rf_harvest_batch( const RfEstimatorGroup* group, RfTraceJob job, RfHitBatch* batch, RfHarvestScratch* scratch,
                      RfRayCounts* rays );

// The steps, which estimators with an order of their own take one by one (src/gradient).

// The harvest of batches of one frame: with its tracer, and with all cameras as pinholes at a point of the lens and moment of the
// shutter, in scratch->eyes, and what moves at that moment in scratch->tracers.
RfHarvest rf_harvest_at( const RfHarvest* harvest, int eye, RfLensSample lens, RfHarvestScratch* scratch );

// Finds what the camera rays hit: scratch->first.
void rf_find_first_hits( const RfHarvest* harvest, RfHarvestScratch* scratch );

// Follows camera rays through mirrors and glass: scratch->hits.
void rf_follow_camera_rays( const RfHarvest* harvest, RfHarvestScratch* scratch );

// The same from the hits on: how the rest of their paths is traced, and what is kept apart of its light.
RfHarvest rf_harvest_hits( const RfHarvest* harvest, int eye, RfHarvestScratch* scratch );

// Starts roulette with the throughput of the chains up to the hits.
void rf_scale_roulette( RfHarvestScratch* scratch, int count );

// Light samples at the hits.
void rf_sample_direct( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays );

// Samples scattered directions at the hits and traces the rest of the paths.
void rf_trace_hit_tails( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays );

#endif
