// First phase, harvest: traces one patch of one frame in one pass into a batch of hit records: first hits, the light that
// arrives at them, their visibility from every camera of the group, and the densities for MIS weights.
#ifndef REFRAME_REUSE_HARVEST_HARVEST_H
#define REFRAME_REUSE_HARVEST_HARVEST_H

#include "light_paths/connections.h"
#include "path/wavefront.h"
#include "render/estimator.h"
#include "render/pieces.h"
#include "reuse/harvest/records.h"
#include "reuse/tile/tile.h"

// What all batches of a group share.
typedef struct RfHarvest
{
    RfPathSettings path;            // with the tracer of the batch's frame, once rf_harvest_at has set it
    const RfTracer* const* tracers; // as in RfEstimatorGroup
    RfBatchShape shape;
    RfPatchLayout patches;
    bool path_roulette;         // see RfTileReuseSettings
    const int32_t* path_source; // its `source`
    bool alpha;                 // the sky that camera rays see is black: RF_AOV_ALPHA
    uint64_t seed;
    const RfPixelFilter* drawn_by; // positions in pixels are drawn by it; NULL: uniformly
    const RfEye* eyes;             // shape.eyes of them
    int first_frame;               // path frame of eyes[0]
    int group;                     // its number
    int64_t passes_before;         // as in RfEstimatorGroup
    const RfPieces* pieces;        // that alone are traced; NULL: all
    const float* need;             // adaptive sampling, as in RfEstimatorGroup
    int round;
    bool packed;
    bool single;
    bool first_hits_only;
    const RfLightPaths* light_paths; // NULL: none
    RfKernelNormalization kernel_normalization;
    const RfClampThresholds* clamps; // thresholds of the frames, and who is told, as in RfEstimatorGroup
    RfClampWatch* clamp_watch;
} RfHarvest;

// The group in the terms of the harvest.
RfHarvest rf_make_harvest( const RfEstimatorGroup* group );

// The shape of the group's batches.
RfBatchShape rf_batch_shape( const RfEstimatorGroup* group );

// A thread's workspace.
typedef struct RfHarvestScratch RfHarvestScratch;

// Fills `batch` with the hits of patch job.job; adds the rays traced to `rays`. Returns the camera rays.
int rf_harvest_batch( const RfHarvest* harvest, RfTraceJob job, RfHitBatch* batch, RfHarvestScratch* scratch, RfRayCounts* rays );

// The steps, which estimators with an order of their own take one by one (src/gradient).

// The harvest of batches of one frame: with its tracer, and with all cameras as pinholes at a point of the lens and moment of the
// shutter, in scratch->eyes, and what moves at that moment in scratch->tracers.
RfHarvest rf_harvest_at( const RfHarvest* harvest, int eye, RfLensSample lens, RfHarvestScratch* scratch );

// Finds what the camera rays hit: scratch->first.
void rf_find_first_hits( const RfHarvest* harvest, RfHarvestScratch* scratch );

// Follows camera rays through mirrors and glass: scratch->hits.
void rf_follow_camera_rays( const RfHarvest* harvest, RfHarvestScratch* scratch );

// Starts roulette with the throughput of the chains up to the hits.
void rf_scale_roulette( RfHarvestScratch* scratch, int count );

// Light samples at the hits.
void rf_sample_direct( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays );

// Samples scattered directions at the hits and traces the rest of the paths.
void rf_trace_hit_tails( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays );

#endif
