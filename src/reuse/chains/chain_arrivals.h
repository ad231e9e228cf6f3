// Light that reaches first hits by chains.
#ifndef REFRAME_REUSE_CHAINS_CHAIN_ARRIVALS_H
#define REFRAME_REUSE_CHAINS_CHAIN_ARRIVALS_H

#include "reuse/harvest/harvest_scratch.h"

// The weight of a scattered ray against one chain sample is larger where its tile shares the light that it finds (`shared`).
// Any value is unbiased; this is about the factor by which sharing reduces the variance of such light.
#define RF_SHARED_CHAIN_WORTH 3.0f
static inline RfChainSampling rf_chain_sampling( const RfHarvest* harvest, bool shared )
{
    return ( RfChainSampling ){ harvest->shape->chain_samples, shared ? RF_SHARED_CHAIN_WORTH : 1.0f };
}

// Adds light that paths found by chains to what arrives at their hits, and traces chain samples.
void rf_add_chain_light( const RfHarvest* harvest, RfHarvestScratch* scratch, RfChainSampling sampling );

// Marks the light of chains in a pairing at glossy hits as light that chain samples could have found as well.
void rf_share_chain_light( const RfHarvest* harvest, const RfHarvestScratch* scratch, int pairing, RfArrivalLanes* out );

#endif
