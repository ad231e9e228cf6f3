// The pixels of a batch and their camera rays.
#ifndef REFRAME_REUSE_HARVEST_CAMERA_RAYS_H
#define REFRAME_REUSE_HARVEST_CAMERA_RAYS_H

#include "reuse/harvest/harvest_scratch.h"

// The point of the lens and the moment of the shutter that a batch has: the same for all cameras of the group.
RfLensSample rf_draw_lens( const RfHarvest* harvest, RfTraceJob job );

// Whether a patch has pixels in the pieces that are traced; its tiles may still have none.
bool rf_is_patch_traced( const RfHarvest* harvest, RfTraceJob job );

// Lists the pixels of a patch that are sampled, and their tiles, and sets their random keys. Returns how many.
int rf_list_pixels( const RfHarvest* harvest, RfTraceJob job, RfHarvestScratch* scratch );

// One camera ray per pixel, through a point drawn uniformly or by a filter (NULL: uniformly). Lane i is slot i,
// which must have its random key.
void rf_make_camera_rays( const RfPixelFilter* filter, const RfEye* eye, int count, const int32_t* pixel, RfWavefront* wavefront,
                          RfRayLanes* rays );

#endif
