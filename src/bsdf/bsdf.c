#include "bsdf/bsdf.h"

void rf_bsdf_evaluate( RfBsdfKind kind, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                       float* const f[3], float* pdf_solid_angle )
{
    switch ( kind )
    {
        case RF_BSDF_LAMBERT: rf_lambert_evaluate( count, lanes, wo, wi, f, pdf_solid_angle ); break;
        case RF_BSDF_PHONG: rf_phong_evaluate( count, lanes, wo, wi, f, pdf_solid_angle ); break;
        case RF_BSDF_GGX: rf_ggx_evaluate( count, lanes, wo, wi, f, pdf_solid_angle ); break;
        case RF_BSDF_COATED: rf_coated_evaluate( count, lanes, wo, wi, f, pdf_solid_angle ); break;
        case RF_BSDF_GLASS: rf_glass_evaluate( count, lanes, wo, wi, f, pdf_solid_angle ); break;
        case RF_BSDF_KIND_COUNT: break;
    }
}

void rf_bsdf_sample( RfBsdfKind kind, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                     float* const wi[3] )
{
    switch ( kind )
    {
        case RF_BSDF_LAMBERT: rf_lambert_sample( count, lanes, wo, u, wi ); break;
        case RF_BSDF_PHONG: rf_phong_sample( count, lanes, wo, u, wi ); break;
        case RF_BSDF_GGX: rf_ggx_sample( count, lanes, wo, u, wi ); break;
        case RF_BSDF_COATED: rf_coated_sample( count, lanes, wo, u, wi ); break;
        case RF_BSDF_GLASS: // by rf_glass_sample
        case RF_BSDF_KIND_COUNT: break;
    }
}
