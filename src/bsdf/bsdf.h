// Scattering models, evaluated for many lanes at once: every argument is an
// array of n values (structure of arrays), every model is one branch-free loop
// that the compiler vectorises. One model per file; callers sort their lanes
// by kind.
//
// Conventions: wo points to the eye, wi to the light, both unit and away from
// the surface; n is the shading normal on the side the eye sees. f is the BSDF
// in 1/sr without the cosine. f = 0 and pdf = 0 where n·wi ≤ 0. An eye below
// the shading horizon (n·wo < RF_MIN_COS, as happens with interpolated
// normals) is lifted to it along n, the same way in evaluate, density and
// sample, so the three always agree and depend on (point, wo, wi) alone.
#ifndef REFRAME_BSDF_BSDF_H
#define REFRAME_BSDF_BSDF_H

#include "scene/scene.h"

#define RF_MIN_COS 1e-3f

// Parameters per lane, named as in RfMaterial. Arrays a kind does not use are
// not read: Lambert uses diffuse; Phong diffuse, specular, shape (exponent);
// GGX diffuse, specular (F0), shape (alpha), f90, coat_f0, coat_f90; COATED
// these and clearcoat, clearcoat_alpha, clearcoat_n; GLASS diffuse, specular
// and f90 (of the part that is metal), shape (alpha), tint, ior.
typedef struct RfBsdfLanes
{
    const float* n[3];
    const float* diffuse[3];
    const float* specular[3];
    const float* shape;
    const float* f90;
    const float* coat_f0;
    const float* coat_f90;
    // COATED only
    const float* clearcoat;
    const float* clearcoat_alpha;
    const float* clearcoat_n[3]; // unit shading normal of the coat, on the side of n
    // GLASS only; ior: of the far side over the near one, negative in thin walls, 0 for mirrors
    const float* tint[3];
    const float* ior;
} RfBsdfLanes;

// f (three arrays) and the density per solid angle with which rf_bsdf_sample
// chooses wi when seen from wo. Either output may be NULL. wo and wi are
// arrays of x, y, z. Results of a lane depend on that lane only and are the
// same bits whatever n and the lane's place are.
void rf_bsdf_evaluate( RfBsdfKind kind, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                       float* const f[3], float* pdf_solid_angle );

// Draws wi from three uniform numbers in [0, 1) per lane (u[2] picks the lobe).
// Phong lobe directions below the surface come out as they are: their f is 0.
void rf_bsdf_sample( RfBsdfKind kind, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                     float* const wi[3] );

// The same for RF_BSDF_GLASS, whose lobes may have no width and go through the
// surface: also weight = f |n·wi| / density (three arrays, 0 where nothing is
// scattered) and the density, RF_DELTA_PDF for directions that light sampling
// cannot find. Evaluate has the other lobes only.
void rf_glass_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3], float* const wi[3],
                      float* const weight[3], float* pdf_solid_angle );
void rf_glass_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                        float* const f[3], float* pdf_solid_angle );

// What has no width in solid angle has an infinite density there. This stands
// for it: so large that a sum with any other density is the same float, so
// that the balance heuristic gives it all the weight by itself.
#define RF_DELTA_PDF 0x1p60f

// The models one by one; sources in their files.
void rf_lambert_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                          float* const f[3], float* pdf_solid_angle );
void rf_lambert_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                        float* const wi[3] );
void rf_phong_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                        float* const f[3], float* pdf_solid_angle );
void rf_phong_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                      float* const wi[3] );
void rf_ggx_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3], float* const f[3],
                      float* pdf_solid_angle );
void rf_coated_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                         float* const f[3], float* pdf_solid_angle );
void rf_coated_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                       float* const wi[3] );
void rf_ggx_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3], float* const wi[3] );

#endif
