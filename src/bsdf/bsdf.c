// Dispatches to the scattering model of a kind through a table of functions.
#include "bsdf/bsdf.h"

void rf_bsdf_evaluate( RfBsdfKind kind, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                       float* const f[3], float* pdf_solid_angle )
{
    rf_bsdf_model( kind )->evaluate( count, lanes, wo, wi, f, pdf_solid_angle );
}

void rf_bsdf_sample( RfBsdfKind kind, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                     float* const wi[3] )
{
    rf_bsdf_model( kind )->sample( count, lanes, wo, u, wi );
}

void rf_bsdf_sample_weighted( RfBsdfKind kind, int count, const RfBsdfLanes* lanes, const float* const wo[3],
                              const float* const u[3], float* const wi[3], float* const weight[3], float* pdf_solid_angle )
{
    rf_bsdf_model( kind )->sample_weighted( count, lanes, wo, u, wi, weight, pdf_solid_angle );
}
