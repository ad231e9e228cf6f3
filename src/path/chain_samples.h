// Chain samples: extra cosine-weighted rays from first hits that only look for light at the end of a specular chain. A
// scattered ray rarely finds such light, and costs a whole path; a chain sample ends at anything but mirrors and smooth glass.
// src/reuse/estimators.md, section 10.
#ifndef REFRAME_PATH_CHAIN_SAMPLES_H
#define REFRAME_PATH_CHAIN_SAMPLES_H

#include "path/wavefront.h"

// How many there are beside a scattered ray.
typedef struct RfChainSampling
{
    int count;   // of each hit
    float worth; // of the scattered ray beside one of them, > 0: more than 1 where tiles share what it finds
} RfChainSampling;

// What chain samples found, by hit: one light sample, whose density is that of rf_chain_sample_pdf. Of glossy hits one of the
// samples stands for all.
typedef struct RfChainSamples
{
    int count; // hits that have chain samples
    int32_t hit[RF_LANES];
    bool taken[RF_LANES]; // by hit
    RfLightLanes found;
    // inside, by slot
    RF_ALIGN float way[3][RF_LANES], light[3][RF_LANES]; // of one sample
    RF_ALIGN float sum[RF_LANES];                        // luminance of all so far
} RfChainSamples;

// The density of all chain samples at this cosine, over the worth of the scattered ray, 1/sr.
static inline float rf_chain_sample_pdf( RfChainSampling sampling, float cosine )
{
    return (float)sampling.count / sampling.worth * RF_INV_PI * cosine;
}

// Traces the chain samples of hits, the first vertices of their paths, for those listed in `samples`. Of the others nothing is
// found. Uses the wavefront, but for its arrivals, and counts the rays up.
void rf_trace_chain_samples( const RfPathSettings* settings, RfChainSampling sampling, const RfVertexLanes* hits,
                             RfWavefront* wavefront, RfChainSamples* samples );

#endif
