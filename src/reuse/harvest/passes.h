// The light of records by how it comes to what cameras see (RF_PASS_AOVS): emission, light that arrives at the first surface from
// lights without a further one, all other light there, and what a chain reflects or transmits.
//
// Hits keep their emission and direct light; what is left of them is indirect. Hits at the end of a chain are all of that chain.
// Misses and glints keep all but the emission, which is what is left of them.
#ifndef REFRAME_REUSE_HARVEST_PASSES_H
#define REFRAME_REUSE_HARVEST_PASSES_H

#include "reuse/harvest/harvest_steps.h"

// Nothing has arrived yet.
void rf_begin_passes( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch );

// batch->radiance is emission so far.
void rf_pass_emission( const RfHitBatch* batch );

// Direct light among what arrives at the diffuse hits from one direction, with f and densities of these; and at the glossy ones, with
// the mixture of densities.
void rf_pass_diffuse( const RfArrivalLanes* arrival, const float* pdf, float* const f[3], const RfHitBatch* batch,
                      const RfHarvestScratch* scratch );
void rf_pass_glossy( const RfArrivalLanes* arrival, const float* mixture, const RfHitBatch* batch,
                     const RfHarvestScratch* scratch );

// The same of light that holds in the hits' own frame alone, from hit `first` to `end`.
void rf_pass_own( const RfArrivalLanes* arrival, int first, int end, const float* pdf, float* const f[3],
                  RfHarvestScratch* scratch );

// What chains bring to misses and glints, by their first event.
void rf_pass_chains( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch );

// Multiplies own light of hits by the filters of the ways to the camera, as accumulation does for what is shared, and by the throughput of
// chains.
void rf_dim_own( const RfHarvest* harvest, const RfHitBatch* batch, const RfHarvestScratch* scratch, float ( *light )[RF_LANES] );

// The glints of the hits' own light, which glint_of[] has by slot, or −1.
void rf_pass_own_light( const RfHarvest* harvest, const int32_t* glint_of, RfHitBatch* batch, RfHarvestScratch* scratch );

// Throughput of the chains to hits, once all light is there.
void rf_pass_throughput( const RfHarvest* harvest, RfHitBatch* batch, const RfHarvestScratch* scratch );

#endif
