// KHR_materials_anisotropy: GGX with two roughnesses, as of brushed metal: highlights are stretched along the tangent.
#include "bsdf/facets.h"

static const RfFacetsOf s_of = { true, false };

void rf_anisotropic_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                              float* const f[3], float* pdf_solid_angle )
{
    rf_facets_evaluate( s_of, count, lanes, wo, wi, f, pdf_solid_angle );
}

void rf_anisotropic_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                            float* const wi[3] )
{
    rf_facets_sample( s_of, count, lanes, wo, u, wi );
}
