// Light that counts in its own frame alone: of misses and specular hits, and what is kept apart of that of hits.
#ifndef REFRAME_REUSE_HARVEST_OWN_FRAME_H
#define REFRAME_REUSE_HARVEST_OWN_FRAME_H

#include "reuse/harvest/harvest_scratch.h"

// Radiance of the own-frame samples: the sky, and specular hits, which are listed behind the misses.
void rf_light_own_frame( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch );

// Marks the hits of camera rays that are on what moves: scratch->own->moving.
void rf_note_moving_hits( const RfTracer* tracer, RfHarvestScratch* scratch );

// Finds scratch->own->part by the light samples at each hit and a scattered ray of it, which hits these triangles.
void rf_find_own_parts( const RfHarvest* harvest, const uint32_t* triangle, RfHarvestScratch* scratch );

// Adds the light that is kept apart to the batch, as glints; caustics to the removed light.
void rf_add_own_light( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch );

#endif
