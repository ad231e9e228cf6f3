// Chain samples: extra cosine-weighted rays from first hits that only look for light at the end of a specular chain. A
// scattered ray rarely finds such light, and costs a whole path; a chain sample ends at anything but mirrors and smooth glass.
// src/reuse/estimators.md, section 10.
#ifndef REFRAME_PATH_CHAIN_SAMPLES_H
#define REFRAME_PATH_CHAIN_SAMPLES_H

#include "path/wavefront.h"

// The numbers of samples of both techniques.
typedef struct RfChainSampling
{
    int count;   // of each hit
    float worth; // T: chain samples that the scattered ray counts as; more than 1 where tiles share what it finds
} RfChainSampling;

// What chain samples found, as one light sample per hit with the density of rf_chain_sample_pdf. At glossy hits
// one of the samples stands for all.
typedef struct RfChainSamples
{
    int count; // hits that have chain samples
    int32_t hit[RF_LANES];
    bool taken[RF_LANES];              // by hit
    RfLightLanes found;                // without groups `part` is not set
    float ( *of_groups )[3][RF_LANES]; // with RfPathSettings.grouped: radiance_cos by base part from 1 on
    // inside, by slot
    RF_ALIGN float way[3][RF_LANES], light[3][RF_LANES]; // of one sample
    uint8_t* part;                                       // with RfPathSettings.grouped: of that light
    RF_ALIGN float sum[RF_LANES];                        // luminance of all so far
} RfChainSamples;

// The density of all chain samples at this cosine over T, 1/sr.
static inline float rf_chain_sample_pdf( RfChainSampling sampling, float cosine )
{
    return (float)sampling.count / sampling.worth * RF_INV_PI * cosine;
}

// Their light of a base part of light groups.
static inline float ( *rf_chain_samples_of( RfChainSamples* samples, int part ) )[RF_LANES]
{
    return part == 0 ? samples->found.radiance_cos : samples->of_groups[part - 1];
}

// Traces chain samples for the first hits listed in `samples`; the others get none. Uses the wavefront except its
// arrivals, and counts the rays.
void rf_trace_chain_samples( const RfPathSettings* settings, RfChainSampling sampling, const RfVertexLanes* hits,
                             RfWavefront* wavefront, RfChainSamples* samples );

#endif
