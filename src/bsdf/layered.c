// Several layers at once: a clear coat over sheen over GGX that may be anisotropic and have a thin film. What a surface lacks has
// the strength 0.
#include "bsdf/coat.h"
#include "bsdf/facets.h"
#include "bsdf/sheen.h"

static const RfFacetsOf s_of = { true, true };

void rf_layered_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                          float* const f[3], float* pdf_solid_angle )
{
    rf_facets_evaluate( s_of, count, lanes, wo, wi, f, pdf_solid_angle );
    rf_lay_sheen( count, lanes, wo, wi, f, pdf_solid_angle );
    rf_lay_coat( count, lanes, wo, wi, f, pdf_solid_angle );
}

// All lobes are sampled, from the base on; those that were chosen are kept.
void rf_layered_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                        float* const wi[3] )
{
    for ( int first = 0; first < count; first += RF_BLOCK )
    {
        float below_coat[RF_BLOCK], below_sheen[RF_BLOCK], left[RF_BLOCK];
        int size = rf_block_size( first, count );
        RfBsdfLanes block = rf_bsdf_lanes( RF_BSDF_LAYERED, lanes->n, lanes->param, first );
        const float* o[3] = { wo[0] + first, wo[1] + first, wo[2] + first };
        float* out[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
        rf_choose_coat( size, &block, o, u[2] + first, below_coat );
        for ( int i = 0; i < size; ++i )
            left[i] = rf_maxf( below_coat[i], 0.0f );
        rf_choose_sheen( size, &block, o, left, below_sheen );
        for ( int i = 0; i < size; ++i )
            left[i] = rf_maxf( below_sheen[i], 0.0f );
        const float* random[3] = { u[0] + first, u[1] + first, left };
        rf_facets_sample( s_of, size, &block, o, random, out );
        rf_sample_sheen( size, &block, random, below_sheen, out );
        rf_sample_coat( size, &block, o, random, below_coat, out );
    }
}
