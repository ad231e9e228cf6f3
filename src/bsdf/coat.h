// A clear coat as a layer, over lobes that something else evaluates and samples. Needs the parameters of the coat, and those of GGX
// for the probability of the lobe.
#ifndef REFRAME_BSDF_COAT_H
#define REFRAME_BSDF_COAT_H

#include "bsdf/models.h"

// Makes f and density of what is below those of both; see rf_bsdf_evaluate.
void rf_lay_coat( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3], float* const f[3],
                  float* pdf_solid_angle );

// Chooses by u between the coat and what is below: u_below is u rescaled for the lobes there, or −1 where it is the coat.
void rf_choose_coat( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* u, float* u_below );

// Directions of the coat, where it was chosen; elsewhere wi stays as it is.
void rf_sample_coat( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3], const float* u_below,
                     float* const wi[3] );

#endif
