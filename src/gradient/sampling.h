// Traces the pixels of extended tiles: all pixels of a tile share their paths (src/reuse/estimators.md, E4), have the
// same point inside their pixel, and the same random numbers on the way through mirrors and glass. So they have for direct
// light, as far as differences are concerned; the values have light samples of their own, else the error of a sample would be
// that of a whole tile, which no difference tells of.
#ifndef REFRAME_GRADIENT_SAMPLING_H
#define REFRAME_GRADIENT_SAMPLING_H

#include "gradient/extended_tiles.h"
#include "path/lanes.h"
#include "render/estimator.h"

// What the films need of a patch.
typedef struct RfGradientBatch
{
    int eye; // index in the group of the frame whose pixels these are
    int tile_count;
    RfExtendedTile tile[RF_LISTED_TILES];
    float value[RF_LANES][4];    // radiance: red, green, blue, and 1 where the camera ray missed; tile after tile, row after row
    float common[RF_LANES][3];   // the same, with the light samples that all pixels of a tile have in common: for differences
    float unshared[RF_LANES][3]; // what tiles do not share, which is not in `common`
} RfGradientBatch;

// A thread's workspace.
typedef struct RfGradientScratch RfGradientScratch;
size_t rf_gradient_scratch_bytes( const RfEstimatorGroup* group );
void rf_lay_out_gradient_scratch( const RfEstimatorGroup* group, void* memory );

// The tiles of a group's films.
RfExtendedTiles rf_group_tiles( const RfEstimatorGroup* group );

// Fills `batch` with patch job.job; adds the rays traced to `rays`. Returns the camera rays.
int rf_sample_patch( const RfEstimatorGroup* group, RfTraceJob job, RfGradientBatch* batch, RfGradientScratch* scratch,
                     RfRayCounts* rays );

// The camera rays of the patch just traced.
RfFirstHits rf_first_hits_of_patch( const RfGradientScratch* scratch );

#endif
