// Which pixels have glints, by a pilot of first hits (src/reuse/estimators.md, section 7).
#ifndef REFRAME_REUSE_HARVEST_GLINTS_H
#define REFRAME_REUSE_HARVEST_GLINTS_H

#include "reuse/harvest/harvest_scratch.h"

// One camera ray for each pixel of block `job` of the group's first frame. Adds four floats per pixel: the mean and the mean square
// that samples will have of the light of lamps, mirrored or in view (radiance, RGB mean); about what else the surface reflects,
// and 1, where it has a sharp lobe.
void rf_add_glints( const RfHarvest* harvest, int job, float* sum, RfHarvestScratch* scratch, RfRayCounts* rays );

#endif
