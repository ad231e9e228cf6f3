// Multiple importance sampling (Veach, Guibas, Optimally Combining Sampling Techniques for Monte Carlo Rendering, SIGGRAPH
// 1995). A sample that several techniques could have drawn, technique k with n_k samples of density p_k, has the weight
//
//     w_i = t(n_i p_i) / Σ_k t(n_k p_k)
//
// and counts f w_i / (n_i p_i). The heuristic is t: the balance heuristic has t(x) = x, the power heuristic t(x) = x². All
// weights of the renderer are computed here, and another heuristic is another t: rf_mis_term and rf_mis_term_per_density, no
// more. Densities that become weights are in the same measure; only their quotients matter, so t must be a power, of which a
// factor cancels. It must be finite for RF_MAX_LIGHT_SAMPLES RF_DELTA_PDF, 2^66: the square is (2^-8 x)².
//
// The cameras of a group, and the paths of a tile, are not techniques that compete. What they find is shared without regard to
// who found it, as samples of one *mixture* with the density Σ p_k, of which each has the share p_k / Σ p. These sums are densities
// and remain so with any heuristic; against light sampling the mixture is one technique. (With t(x) = x both are the same, hence
// the balance heuristic in src/reuse/estimators.md, E1.)
#ifndef REFRAME_PATH_MIS_H
#define REFRAME_PATH_MIS_H

#include "base/fault.h"
#include "path/lanes.h"

#include <stdbool.h>

// t(np).
static inline float rf_mis_term( float np ) { return np; }

// t(np) / np.
static inline float rf_mis_term_per_density( float np )
{
    (void)np;
    return 1.0f;
}

// w_i of a technique with n_i p_i = own against another one.
static inline float rf_balance_weight( float own, float other )
{
    float term = rf_mis_term( own );
    return term / ( term + rf_mis_term( other ) );
}

// w_i / (n_i p_i).
static inline float rf_balance_scale( float own, float other )
{
    return rf_mis_term_per_density( own ) / ( rf_mis_term( own ) + rf_mis_term( other ) );
}

// The share of one density in a mixture, with the sum of all its densities, > 0.
static inline float rf_mixture_share( float density, float sum ) { return density / sum; }

// Radiance that arrives along the ray of each path slot. Emission hit by the ray is
// kept separate, since light sampling at the ray's origin could have found it too
// (src/reuse/estimators.md, E3).
typedef struct RfArrivals
{
    RF_ALIGN float emitted[3][RF_LANES];
    float light_pdf_solid_angle[RF_LANES]; // of the emitter, by light sampling at the origin; over q behind panes
    float rest[3][RF_LANES];               // all longer paths
} RfArrivals;

// No light at slots [0, count).
void rf_clear_arrivals( int count, RfArrivals* arrivals );
void rf_copy_arrivals( int count, const RfArrivals* from, RfArrivals* to );

// The light that arrives at vertices from one direction each, in two parts: A, which light sampling could have found as well, and
// B, which it could not.
typedef struct RfArrivalLanes
{
    RF_ALIGN float a[3][RF_LANES]; // |cos| times radiance
    float b[3][RF_LANES];          // likewise
    float light_pdf[RF_LANES];     // K p_L
    bool scattered;                // the directions were drawn by scattering, not by light sampling
} RfArrivalLanes;

// Light samples, K of them at each vertex; of one part of the light, where their parts are set, or RF_ALL_PARTS.
#define RF_ALL_PARTS ( -1 )
void rf_gather_light_sample( const RfLightLanes* light, int part, int count, float k, RfArrivalLanes* out );

// What arrives along the rays that the vertices scatter to wi, by slot.
void rf_gather_scattered( const RfVertexLanes* vertices, int count, const float* const wi[3], const RfArrivals* arrivals, float k,
                          RfArrivalLanes* out );

// The factors of A and B in Q at a lane, with P the density of scattering: A is weighted between light sampling and scattering, B has the latter's density.
// By the balance heuristic Q = A / (K p_L + P) + B / P, whichever drew the direction (src/reuse/estimators.md, section 3).
static inline void rf_arrival_scales( const RfArrivalLanes* arrival, int lane, float pdf, float* scale_a, float* scale_b )
{
    const float least = 1e-30f; // below, nothing was drawn there
    float light_pdf = arrival->light_pdf[lane], drawn = arrival->scattered ? pdf : light_pdf;
    float sum = rf_mis_term( light_pdf ) + rf_mis_term( pdf );
    *scale_a = sum > rf_mis_term( least ) ? rf_mis_term_per_density( drawn ) / sum : 0.0f;
    *scale_b = pdf > least || RF_FAULT( mixture ) ? 1.0f / pdf : 0.0f;
}

// Q at a lane.
static inline void rf_weigh_arrival( const RfArrivalLanes* arrival, int lane, float pdf, float q[3] )
{
    float scale_a, scale_b;
    rf_arrival_scales( arrival, lane, pdf, &scale_a, &scale_b );
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
