// A dielectric whose base scatters light to the side that it came from and to the other, Lambert both (KHR_materials_diffuse_transmission):
//
//   f = D G2 F / (4 μo μi) + ρ/π (1 − Fc(μo)) (1 − Fc(μi))      on the side of the light,
//   f = τ/π (1 − Fc(|μo|)) (1 − Fc(|μi|))                        on the other,
//
// D, G2, F and Fc as in GGX. A hit has drawn the side on which light arrives (RF_PARAM_CHOICE), the other one with the
// probability p, and n is on that side: it scatters the light of one hemisphere, over the probability of its side. So it is
// GGX with other reflectances, and where light arrives on the other side, seen as from the mirror image of wo.
#include "bsdf/lane.h"

typedef struct Turned
{
    float diffuse[3][RF_BLOCK], specular[3][RF_BLOCK], f90[RF_BLOCK], wo[3][RF_BLOCK];
} Turned;

static void turn_block( int first, int count, const RfBsdfLanes* lanes, const float* const wo[3], Turned* restrict out )
{
    const float* restrict nx = lanes->n[0] + first, * restrict ny = lanes->n[1] + first, * restrict nz = lanes->n[2] + first;
    const float* restrict dx = lanes->param[RF_PARAM_DIFFUSE] + first, * restrict dy = lanes->param[RF_PARAM_DIFFUSE + 1] + first;
    const float* restrict dz = lanes->param[RF_PARAM_DIFFUSE + 2] + first;
    const float* restrict sx = lanes->param[RF_PARAM_SPECULAR] + first;
    const float* restrict sy = lanes->param[RF_PARAM_SPECULAR + 1] + first;
    const float* restrict sz = lanes->param[RF_PARAM_SPECULAR + 2] + first;
    const float* restrict tx = lanes->param[RF_PARAM_THROUGH] + first, * restrict ty = lanes->param[RF_PARAM_THROUGH + 1] + first;
    const float* restrict tz = lanes->param[RF_PARAM_THROUGH + 2] + first;
    const float* restrict f90 = lanes->param[RF_PARAM_F90] + first, * restrict choice = lanes->param[RF_PARAM_CHOICE] + first;
    const float* restrict ox = wo[0] + first, * restrict oy = wo[1] + first, * restrict oz = wo[2] + first;

#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 n = rf_vec3( nx[i], ny[i], nz[i] ), o = rf_vec3( ox[i], oy[i], oz[i] );
        RfVec3 d = rf_vec3( dx[i], dy[i], dz[i] ), t = rf_vec3( tx[i], ty[i], tz[i] ), s = rf_vec3( sx[i], sy[i], sz[i] );
        float through = choice[i] < 0.0f ? 1.0f : 0.0f, here = 1.0f - through;
        float p = rf_through_probability( t, d, s, f90[i] ), drawn = through > 0.0f ? p : 1.0f - p;
        float scale = drawn > 0.0f ? 1.0f / ( drawn > 0.0f ? drawn : 1.0f ) : 0.0f;
        RfVec3 base = rf_scale( rf_madd( rf_scale( d, here ), t, through ), scale );
        RfVec3 seen = rf_madd( o, n, RF_FAULT( mirrored_eye ) ? 0.0f : -2.0f * through * rf_dot( n, o ) );
        out->diffuse[0][i] = base.x;
        out->diffuse[1][i] = base.y;
        out->diffuse[2][i] = base.z;
        out->specular[0][i] = s.x * here * scale;
        out->specular[1][i] = s.y * here * scale;
        out->specular[2][i] = s.z * here * scale;
        out->f90[i] = f90[i] * here * scale;
        out->wo[0][i] = seen.x;
        out->wo[1][i] = seen.y;
        out->wo[2][i] = seen.z;
    }
}

static RfBsdfLanes turned_lanes( const RfBsdfLanes* lanes, int first, const Turned* turned )
{
    RfBsdfLanes out = { .n = { lanes->n[0] + first, lanes->n[1] + first, lanes->n[2] + first } };
    for ( int c = 0; c < 3; ++c )
    {
        out.param[RF_PARAM_DIFFUSE + c] = turned->diffuse[c];
        out.param[RF_PARAM_SPECULAR + c] = turned->specular[c];
    }
    out.param[RF_PARAM_F90] = turned->f90;
    out.param[RF_PARAM_SHAPE] = lanes->param[RF_PARAM_SHAPE] + first;
    out.param[RF_PARAM_COAT_F0] = lanes->param[RF_PARAM_COAT_F0] + first;
    out.param[RF_PARAM_COAT_F90] = lanes->param[RF_PARAM_COAT_F90] + first;
    return out;
}

void rf_translucent_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                              float* const f[3], float* pdf_solid_angle )
{
    Turned turned;
    const float* seen[3] = { turned.wo[0], turned.wo[1], turned.wo[2] };
    for ( int first = 0; first < count; first += RF_BLOCK )
    {
        int size = rf_block_size( first, count );
        turn_block( first, size, lanes, wo, &turned );
        RfBsdfLanes side = turned_lanes( lanes, first, &turned );
        const float* in[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
        float* pdf = pdf_solid_angle != NULL ? pdf_solid_angle + first : NULL;
        if ( f == NULL )
        {
            rf_ggx_evaluate( size, &side, seen, in, NULL, pdf );
            continue;
        }
        float* out[3] = { f[0] + first, f[1] + first, f[2] + first };
        rf_ggx_evaluate( size, &side, seen, in, out, pdf );
    }
}

void rf_translucent_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                            float* const wi[3] )
{
    Turned turned;
    const float* seen[3] = { turned.wo[0], turned.wo[1], turned.wo[2] };
    for ( int first = 0; first < count; first += RF_BLOCK )
    {
        int size = rf_block_size( first, count );
        turn_block( first, size, lanes, wo, &turned );
        RfBsdfLanes side = turned_lanes( lanes, first, &turned );
        const float* numbers[3] = { u[0] + first, u[1] + first, u[2] + first };
        float* out[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
        rf_ggx_sample( size, &side, seen, numbers, out );
    }
}
