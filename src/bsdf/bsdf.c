// The table of scattering models, and the functions that go by it.
#include "bsdf/bsdf.h"

#include "bsdf/lane.h"

#define LAMBERT RF_PARAM_BITS3( RF_PARAM_DIFFUSE )
#define PHONG ( LAMBERT | RF_PARAM_BITS3( RF_PARAM_SPECULAR ) | RF_PARAM_BIT( RF_PARAM_SHAPE ) )
#define GGX ( PHONG | RF_PARAM_BIT( RF_PARAM_F90 ) | RF_PARAM_BIT( RF_PARAM_COAT_F0 ) | RF_PARAM_BIT( RF_PARAM_COAT_F90 ) )
#define COAT                                                                                                                     \
    ( RF_PARAM_BIT( RF_PARAM_CLEARCOAT ) | RF_PARAM_BIT( RF_PARAM_CLEARCOAT_ALPHA ) | RF_PARAM_BITS3( RF_PARAM_CLEARCOAT_N ) )
#define SHEEN ( RF_PARAM_BITS3( RF_PARAM_SHEEN ) | RF_PARAM_BIT( RF_PARAM_SHEEN_ALPHA ) )
#define STRETCH ( RF_PARAM_BIT( RF_PARAM_ANISOTROPY ) | RF_PARAM_BITS3( RF_PARAM_TANGENT ) )
#define FILM ( RF_PARAM_BIT( RF_PARAM_FILM ) | RF_PARAM_BIT( RF_PARAM_FILM_IOR ) | RF_PARAM_BIT( RF_PARAM_FILM_THICKNESS ) )
#define THROUGH ( RF_PARAM_BITS3( RF_PARAM_THROUGH ) | RF_PARAM_BIT( RF_PARAM_CHOICE ) )
#define GLASS ( GGX | RF_PARAM_BITS3( RF_PARAM_TINT ) | RF_PARAM_BIT( RF_PARAM_IOR ) )
#define SPECTRUM ( FILM | RF_PARAM_BIT( RF_PARAM_DISPERSION ) | RF_PARAM_BIT( RF_PARAM_CHOICE ) )

#define EFFECT( id ) RF_EFFECT_BIT( RF_EFFECT_##id )
#define SPECULAR ( EFFECT( MIRRORS ) | EFFECT( TRANSMISSION ) )

// An opaque model with a lobe of GGX over a Lambert base: its name, parameters beside GGX, effect, and whether wide lobes make it
// matte.
#define OPAQUE( word, more, effect, is_matte, throws )                                                                           \
    .name = #word, .params = GGX | ( more ), .built_by = { EFFECT( GGX ), effect }, .forced_by = effect,                         \
    .shape = RF_SHAPE_ALPHA, .matte = is_matte, .caustics = RF_CAUSTICS_##throws, .evaluate = rf_##word##_evaluate,              \
    .sample = rf_##word##_sample

const RfBsdfModel g_rf_bsdf_models[RF_BSDF_KIND_COUNT] = {
    [RF_BSDF_LAMBERT] = { .name = "lambert",
                          .params = LAMBERT,
                          .matte = true,
                          .evaluate = rf_lambert_evaluate,
                          .sample = rf_lambert_sample },
    [RF_BSDF_PHONG] = { .name = "phong",
                        .params = PHONG,
                        .built_by = { EFFECT( PHONG ) },
                        .forced_by = EFFECT( PHONG ),
                        .shape = RF_SHAPE_EXPONENT,
                        .matte = true,
                        .evaluate = rf_phong_evaluate,
                        .sample = rf_phong_sample },
    [RF_BSDF_GGX] = { OPAQUE( ggx, 0, EFFECT( GGX ), true, OF_METAL ) },
    [RF_BSDF_COATED] = { OPAQUE( coated, COAT, EFFECT( CLEARCOAT ), false, OF_METAL ) },
    [RF_BSDF_SHEEN] = { OPAQUE( sheen, SHEEN, EFFECT( SHEEN ), false, OF_METAL ) },
    [RF_BSDF_ANISOTROPIC] = { OPAQUE( anisotropic, STRETCH, EFFECT( ANISOTROPY ), false, OF_METAL ) },
    [RF_BSDF_IRIDESCENT] = { OPAQUE( iridescent, FILM, EFFECT( IRIDESCENCE ), true, OF_METAL ) },
    [RF_BSDF_LAYERED] = { OPAQUE( layered, COAT | SHEEN | STRETCH | FILM, 0, false, OF_METAL ) },
    [RF_BSDF_TRANSLUCENT] = { OPAQUE( translucent, THROUGH, EFFECT( DIFFUSE_TRANSMISSION ), false, NEVER ) },
    [RF_BSDF_FROSTED] = { .name = "frosted",
                          .params = GLASS | RF_PARAM_BIT( RF_PARAM_CHOICE ),
                          .built_by = { EFFECT( TRANSMISSION ) },
                          .forced_by = EFFECT( TRANSMISSION ),
                          .shape = RF_SHAPE_ALPHA,
                          .caustics = RF_CAUSTICS_OF_GLASS,
                          .evaluate = rf_frosted_evaluate,
                          .sample = rf_frosted_sample },
    [RF_BSDF_GLASS] = { .name = "glass",
                        .params = GLASS,
                        .built_by = { SPECULAR },
                        .forced_by = SPECULAR,
                        .shape = RF_SHAPE_ALPHA,
                        .caustics = RF_CAUSTICS_OF_GLASS,
                        .evaluate = rf_glass_evaluate,
                        .sample_weighted = rf_glass_sample },
    [RF_BSDF_SPECTRAL] = { .name = "spectral",
                           .params = GLASS | SPECTRUM,
                           .built_by = { SPECULAR, EFFECT( DISPERSION ) | EFFECT( IRIDESCENCE ) },
                           .forced_by = EFFECT( DISPERSION ),
                           .shape = RF_SHAPE_ALPHA,
                           .caustics = RF_CAUSTICS_OF_GLASS,
                           .evaluate = rf_spectral_evaluate,
                           .sample_weighted = rf_spectral_sample },
};

// The lanes after the first block go by shifted arrays.
void rf_bsdf_evaluate( RfBsdfKind kind, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                       float* const f[3], float* pdf_solid_angle )
{
    const RfBsdfModel* model = rf_bsdf_model( kind );
    model->evaluate( count < RF_BLOCK ? count : RF_BLOCK, lanes, wo, wi, f, pdf_solid_angle );
    for ( int first = RF_BLOCK; first < count; first += RF_BLOCK )
    {
        const float *o[3], *in[3];
        float *out[3], *pdf = pdf_solid_angle != NULL ? pdf_solid_angle + first : NULL;
        RfBsdfLanes block = rf_bsdf_lanes( kind, lanes->n, lanes->param, first );
        for ( int c = 0; c < 3; ++c )
        {
            o[c] = wo[c] + first;
            in[c] = wi[c] + first;
            out[c] = f != NULL ? f[c] + first : NULL;
        }
        int left = count - first;
        model->evaluate( left < RF_BLOCK ? left : RF_BLOCK, &block, o, in, f != NULL ? out : NULL, pdf );
    }
}

void rf_bsdf_sample( RfBsdfKind kind, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                     float* const wi[3] )
{
    const RfBsdfModel* model = rf_bsdf_model( kind );
    model->sample( count < RF_BLOCK ? count : RF_BLOCK, lanes, wo, u, wi );
    for ( int first = RF_BLOCK; first < count; first += RF_BLOCK )
    {
        const float *o[3], *random[3];
        float* out[3];
        RfBsdfLanes block = rf_bsdf_lanes( kind, lanes->n, lanes->param, first );
        for ( int c = 0; c < 3; ++c )
        {
            o[c] = wo[c] + first;
            random[c] = u[c] + first;
            out[c] = wi[c] + first;
        }
        int left = count - first;
        model->sample( left < RF_BLOCK ? left : RF_BLOCK, &block, o, random, out );
    }
}

void rf_bsdf_sample_weighted( RfBsdfKind kind, int count, const RfBsdfLanes* lanes, const float* const wo[3],
                              const float* const u[3], float* const wi[3], float* const weight[3], float* pdf_solid_angle )
{
    rf_bsdf_model( kind )->sample_weighted( count, lanes, wo, u, wi, weight, pdf_solid_angle );
}
