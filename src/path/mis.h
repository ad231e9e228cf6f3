// Multiple importance sampling by the balance heuristic (Veach, Guibas, Optimally Combining Sampling Techniques for Monte Carlo
// Rendering, SIGGRAPH 1995). A sample that several techniques could have drawn, technique k with n_k samples of density p_k,
// has the weight
//
//     w_i = n_i p_i / Σ_k n_k p_k
//
// and counts f w_i / (n_i p_i) = f / Σ_k n_k p_k. All weights of the renderer are computed here. Densities that become weights
// are in the same measure; only their quotients matter.
#ifndef REFRAME_PATH_MIS_H
#define REFRAME_PATH_MIS_H

#include "base/fault.h"
#include "path/lanes.h"

// w_i, with n_i p_i of the technique and the sum of all others.
static inline float rf_balance_weight( float own, float others ) { return own / ( own + others ); }

// w_i, with n_i p_i of the technique and the sum over all, > 0.
static inline float rf_balance_weight_of_sum( float own, float sum ) { return own / sum; }

// w_i / (n_i p_i).
static inline float rf_balance_scale( float own, float others ) { return 1.0f / ( own + others ); }

// Radiance that arrives along the ray of each path slot. Emission hit by the ray is
// kept separate, since light sampling at the ray's origin could have found it too
// (src/reuse/estimators.md, E3).
typedef struct RfArrivals
{
    RF_ALIGN float emitted[3][RF_LANES];
    float light_pdf_solid_angle[RF_LANES]; // of the emitter, by light sampling at the origin; over q behind panes
    float rest[3][RF_LANES];               // all longer paths
} RfArrivals;

// The light that arrives at vertices from one direction each, in two parts: A, which light sampling could have found as well, and
// B, which it could not.
typedef struct RfArrivalLanes
{
    RF_ALIGN float a[3][RF_LANES]; // |cos| times radiance
    float b[3][RF_LANES];          // likewise
    float light_pdf[RF_LANES];     // K p_L
} RfArrivalLanes;

// Light samples, K of them at each vertex.
void rf_gather_light_sample( const RfLightLanes* light, int count, float k, RfArrivalLanes* out );

// What arrives along the rays that the vertices scatter to wi, by slot.
void rf_gather_scattered( const RfVertexLanes* vertices, int count, const float* const wi[3], const RfArrivals* arrivals, float k,
                          RfArrivalLanes* out );

// Q = A / (K p_L + P) + B / P at a lane, with P the density of scattering (src/reuse/estimators.md, section 3).
static inline void rf_weigh_arrival( const RfArrivalLanes* arrival, int lane, float pdf, float q[3] )
{
    const float least = 1e-30f; // below, nothing was drawn there
    float scale_a = arrival->light_pdf[lane] + pdf > least ? rf_balance_scale( arrival->light_pdf[lane], pdf ) : 0.0f;
    float scale_b = pdf > least || RF_FAULT( mixture ) ? 1.0f / pdf : 0.0f;
    for ( int c = 0; c < 3; ++c )
        q[c] = arrival->a[c][lane] * scale_a + arrival->b[c][lane] * scale_b;
}

// The range of the weights over frames (E1) and over the paths of a tile (E5), for a technique of one sample.
typedef struct RfWeightRange
{
    float least, most;
    uint64_t count; // of the weights above 0
    uint64_t nans;
} RfWeightRange;

// For tests: collects the range of the weights of all renders from now on; NULL: of none. Renders must have one thread then.
void rf_watch_weights( RfWeightRange* range );

// Records weights that carry a factor `scale`.
void rf_note_weights( const float* weight, int count, float scale );

#endif
