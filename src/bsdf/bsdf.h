// Scattering models, evaluated for many lanes at once: every argument is an
// array of n values (structure of arrays), every model is a few branch-free loops
// that the compiler vectorises. Callers sort their lanes by model.
//
// Conventions: wo points to the camera, wi to the light, both unit and away from
// the surface; n is the shading normal on the side the camera sees. f is the BSDF
// in 1/sr without the cosine. f = 0 and pdf = 0 where n·wi ≤ 0. A camera below
// the shading horizon (n·wo < RF_MIN_COS, as happens with interpolated
// normals) is lifted to it along n, the same way in evaluate, density and
// sample, so the three always agree and depend on (point, wo, wi) alone.
#ifndef REFRAME_BSDF_BSDF_H
#define REFRAME_BSDF_BSDF_H

#include "base/fault.h"
#include "bsdf/models.h"

#define RF_MIN_COS 1e-3f

// A delta lobe has an infinite density. This stands for it: so large that a sum
// with any other density is the same float, and the balance heuristic gives the
// lobe all the weight without a special case.
#define RF_DELTA_PDF ( RF_FAULT( delta_pdf ) ? INFINITY : 0x1p60f )

// f (three arrays) and the density per solid angle with which sampling chooses
// wi when seen from wo. Either output may be NULL. wo and wi are arrays of x,
// y, z. Results of a lane depend on that lane only and are the same bits
// whatever n and the lane's index are. Specular models leave out their delta
// and transmitted lobes.
void rf_bsdf_evaluate( RfBsdfKind kind, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                       float* const f[3], float* pdf_solid_angle );

// Samples wi from three uniform numbers in [0, 1) per lane (u[2] selects the
// lobe). Of models before RF_BSDF_FIRST_SPECULAR only. Phong lobe directions
// below the surface come out as they are: their f is 0.
void rf_bsdf_sample( RfBsdfKind kind, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                     float* const wi[3] );

// Samples wi of models from RF_BSDF_FIRST_SPECULAR on, whose lobes may be deltas
// and may go through the surface, with weight = f |n·wi| / density (0 where nothing
// is scattered) and the density, RF_DELTA_PDF for directions that light sampling
// cannot find.
void rf_bsdf_sample_weighted( RfBsdfKind kind, int count, const RfBsdfLanes* lanes, const float* const wo[3],
                              const float* const u[3], float* const wi[3], float* const weight[3], float* pdf_solid_angle );

// The probability that light is drawn to arrive at a point of TRANSLUCENT on the side that is not seen: the share of `through` in
// what the surface scatters. A function of the point alone, the same for all cameras and frames.
static inline float rf_through_probability( RfVec3 through, RfVec3 diffuse, RfVec3 specular, float f90 )
{
    float f0 = ( specular.x + specular.y + specular.z ) * ( 1.0f / 3.0f );
    float there = ( through.x + through.y + through.z ) * ( 1.0f / 3.0f );
    float here = ( diffuse.x + diffuse.y + diffuse.z ) * ( 1.0f / 3.0f ) + f0 + ( f90 - f0 ) * ( 1.0f / 21.0f );
    return there > 0.0f ? there / ( there + here ) : 0.0f;
}

// The same of a lane of FROSTED: the share of what it transmits, at most 0.9.
float rf_frosted_through_probability( const RfBsdfLanes* lanes, int lane );

// RF_PARAM_CHOICE of SPECTRAL: how much of the largest channel each has in the light of a path, in steps of 1/255, upwards, so that
// none that carries light is taken for dead.
static inline float rf_pack_channels( RfVec3 throughput )
{
    float most = rf_max_component( throughput );
    if ( !( most > 0.0f ) )
        return 0.0f; // nothing is carried on: as if all were alike
    const float t[3] = { throughput.x, throughput.y, throughput.z };
    float code = 0.0f;
    for ( int c = 2; c >= 0; --c )
        code = code * 256.0f + rf_minf( ceilf( 255.0f * ( rf_maxf( t[c], 0.0f ) / most ) ), 255.0f );
    return code;
}

// A thin pane: a smooth thin wall of glass, which rays pass without refraction.
typedef struct RfPane
{
    float probability; // q, with which sampling takes a ray straight through; 0: not a pane here
    RfVec3 colour;     // T, the transmittance: tint times 1 − F
} RfPane;

// The pane that a material is at a point, from either side, for rays at this angle to the shading normal.
RfPane rf_pane_of_material( const RfMaterial* material, float cos_o );

// The pane that a lane of GLASS or SPECTRAL is, seen from wo.
RfPane rf_pane_of_lane( RfBsdfKind kind, const RfBsdfLanes* lanes, int lane, RfVec3 wo );

// The probability that sampling at a lane of GLASS or SPECTRAL without a base, seen from wo, reflects rather than transmits: that of a
// facet along the shading normal.
float rf_reflection_probability_of_lane( RfBsdfKind kind, const RfBsdfLanes* lanes, int lane, RfVec3 wo );

// The probability with which sampling reflects at a smooth (alpha 0), untextured surface of
// RF_BSDF_GLASS that is seen from its front at this cosine, and the weight of the reflection.
float rf_glass_reflection( const RfMaterial* material, float cos_o, RfVec3* weight );

// One event at a mirror or smooth glass: the direction, its weight f |cos| / probability, and the probability of drawing it.
typedef struct RfDeltaEvent
{
    RfVec3 wi, weight;
    float probability; // 0: it cannot be drawn
} RfDeltaEvent;

// Reflection or transmission at a lane of GLASS seen from wo, as sampling does it. Never at rough lanes.
RfDeltaEvent rf_glass_event( const RfBsdfLanes* lanes, int lane, RfVec3 wo, bool transmits );

// What a lane of GLASS or SPECTRAL shows seen from wo, as if it were smooth: its base, what it reflects and what it lets through,
// without the scale of radiance. Where channels refract differently the way is that of green.
typedef struct RfSmoothLobes
{
    RfVec3 base, reflected, transmitted; // their sum is at most 1
    RfVec3 reflected_wi, transmitted_wi;
} RfSmoothLobes;

RfSmoothLobes rf_smooth_lobes_of_lane( RfBsdfKind kind, const RfBsdfLanes* lanes, int lane, RfVec3 wo );

// What a smooth, untextured surface of RF_BSDF_GLASS reflects and lets through as deltas, seen at this cosine from a side
// on which `ior` is the index of the far side over the near one (RF_PARAM_IOR). Without the scale of radiance.
void rf_glass_delta_lobes( const RfMaterial* material, float ior, float cos_o, RfVec3* reflected, RfVec3* transmitted );

#endif
