// Sheen as a layer, over lobes that something else evaluates and samples. Needs the parameters of the sheen, and those of GGX
// for the probability of the lobe.
#ifndef REFRAME_BSDF_SHEEN_H
#define REFRAME_BSDF_SHEEN_H

#include "bsdf/models.h"

// The directional albedo of white sheen at this cosine, with an error of 0.005 at most: the base keeps what it leaves.
float rf_sheen_albedo( float cos_theta, float alpha );

// Makes f and density of what is below those of both; see rf_bsdf_evaluate.
void rf_lay_sheen( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3], float* const f[3],
                   float* pdf_solid_angle );

// Chooses by u between the sheen and what is below: u_below is u rescaled for the lobes there, or −1 where it is the sheen.
void rf_choose_sheen( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* u, float* u_below );

// Directions of the sheen, where it was chosen; elsewhere wi stays as it is.
void rf_sample_sheen( int count, const RfBsdfLanes* lanes, const float* const u[3], const float* u_below, float* const wi[3] );

#endif
