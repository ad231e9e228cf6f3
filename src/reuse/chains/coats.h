// Coats so smooth that no direction of another path falls into their lobe. At a first hit each camera ray draws
// either the lobe, which is followed as a chain, or the base, which becomes a record (src/reuse/estimators.md,
// section 10).
#ifndef REFRAME_REUSE_CHAINS_COATS_H
#define REFRAME_REUSE_CHAINS_COATS_H

#include "reuse/record.h"
#include "scene/eye.h"

static inline bool rf_is_smooth_coat( const RfVertexLanes* v, int i )
{
    return rf_calls_for( v->param[RF_PARAM_SHAPE][i] < RF_SMOOTH_ALPHA, RF_EFFECT_SMOOTH_GLOSS );
}

// The probability that a camera ray at this cosine draws the base: its share of the reflected light, clamped; 0
// without a base.
static inline float rf_base_probability( float diffuse, float coat_f0, float coat_f90, float cos_o )
{
    float m = 1.0f - rf_clampf( cos_o, RF_MIN_COS, 1.0f ), m2 = m * m;
    float coat = coat_f0 + ( coat_f90 - coat_f0 ) * ( m2 * m2 * m ), base = diffuse * ( 1.0f - coat );
    return diffuse > 0.0f ? rf_clampf( base / ( base + coat ), 0.1f, 0.9f ) : 0.0f;
}

// The same for a GGX lane of some vertices.
float rf_base_probability_of( const RfVertexLanes* v, int i );

// Turns lane `to` into the lobe of GGX lane i as a vertex of RF_BSDF_GLASS.
void rf_make_lobe( const RfVertexLanes* v, int i, RfVertexLanes* lobes, int to );

// Leaves the base of a GGX lane, without its coat.
void rf_make_base( RfVertexLanes* v, int i );

// Multiplies the densities of the hits that are bases by the probabilities that the camera draws these, and divides
// their filter (three arrays; may be NULL).
void rf_weight_bases( const RfHitBatch* batch, const RfEye* eye, float* density, float* const filter[3] );

#endif
