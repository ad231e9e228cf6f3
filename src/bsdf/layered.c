// The models made of layers over GGX: a clear coat (KHR_materials_clearcoat), sheen, or any of coat, sheen, anisotropy and film
// together, of which those that a surface lacks have the strength 0.
#include "bsdf/coat.h"
#include "bsdf/lane.h"
#include "bsdf/sheen.h"

// What is below, and the layers over it, from below.
typedef struct Layers
{
    RfBsdfEvaluate* evaluate;
    RfBsdfSample* sample;
    bool sheen, coat;
} Layers;

static const Layers s_coated = { rf_ggx_evaluate, rf_ggx_sample, false, true };
static const Layers s_sheen = { rf_ggx_evaluate, rf_ggx_sample, true, false };
static const Layers s_layered = { rf_facets_evaluate, rf_facets_sample, true, true };

RF_KERNEL void evaluate( Layers of, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                         float* const f[3], float* pdf_solid_angle )
{
    of.evaluate( count, lanes, wo, wi, f, pdf_solid_angle );
    if ( of.sheen )
        rf_lay_sheen( count, lanes, wo, wi, f, pdf_solid_angle );
    if ( of.coat )
        rf_lay_coat( count, lanes, wo, wi, f, pdf_solid_angle );
}

// What the layer leaves to those below; where it was chosen, any number does.
static void pass_on( int count, const float* u_below, float* left )
{
    for ( int i = 0; i < count; ++i )
        left[i] = rf_maxf( u_below[i], 0.0f );
}

// All lobes are sampled, from the base on; those that were chosen are kept.
RF_KERNEL void sample( Layers of, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                       float* const wi[3] )
{
    float below_coat[RF_BLOCK], below_sheen[RF_BLOCK], left[RF_BLOCK];
    if ( of.coat )
    {
        rf_choose_coat( count, lanes, wo, u[2], below_coat );
        pass_on( count, below_coat, left );
    }
    if ( of.sheen )
    {
        rf_choose_sheen( count, lanes, wo, of.coat ? left : u[2], below_sheen );
        pass_on( count, below_sheen, left );
    }
    const float* random[3] = { u[0], u[1], left };
    of.sample( count, lanes, wo, random, wi );
    if ( of.sheen )
        rf_sample_sheen( count, lanes, random, below_sheen, wi );
    if ( of.coat )
        rf_sample_coat( count, lanes, wo, random, below_coat, wi );
}

RF_MODEL_FUNCTIONS( coated, s_coated )
RF_MODEL_FUNCTIONS( sheen, s_sheen )
RF_MODEL_FUNCTIONS( layered, s_layered )
