#include "reuse/glossy.h"

#include "reuse/mirrored.h"

#include <string.h>

void rf_directions_to( const RfMirrors* mirrors, const RfEye* at, int eye, const RfHitBatch* batch, float* const wo[3] )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = rf_glossy_count( batch );
    if ( eye == batch->eye )
    {
        for ( int c = 0; c < 3; ++c )
            memcpy( wo[c], batch->wo[c], (size_t)count * sizeof( float ) );
        return;
    }
    RfVec3 o = at->origin;
    const float* restrict px = batch->p[0] + first;
    const float* restrict py = batch->p[1] + first;
    const float* restrict pz = batch->p[2] + first;
    float* restrict x = wo[0];
    float* restrict y = wo[1];
    float* restrict z = wo[2];
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 v = rf_sub( o, rf_vec3( px[i], py[i], pz[i] ) );
        float d2 = rf_dot( v, v );
        float scale = d2 > 0.0f ? 1.0f / sqrtf( d2 ) : 0.0f;
        x[i] = v.x * scale;
        y[i] = v.y * scale;
        z[i] = v.z * scale;
    }
    if ( rf_has_views( batch ) )
        rf_directions_to_image( mirrors, at, batch, wo );
}

void rf_evaluate_glossy( const RfHitBatch* b, const float* const wo[3], const float* const wi[3], float* const f[3],
                         float* pdf_solid_angle )
{
    int base = b->first[RF_BSDF_FIRST_GLOSSY];
    for ( int kind = RF_BSDF_FIRST_GLOSSY; kind < RF_BSDF_KIND_COUNT; ++kind )
    {
        int k = b->first[kind] - base, count = b->first[kind + 1] - b->first[kind];
        if ( count == 0 || !rf_is_model_built( (RfBsdfKind)kind ) )
            continue;
        const float* n[3] = { b->n[0], b->n[1], b->n[2] };
        const float* param[RF_PARAM_COUNT];
        for ( int p = 0; p < RF_PARAM_COUNT; ++p )
            param[p] = b->param[p];
        RfBsdfLanes lanes = rf_bsdf_lanes( (RfBsdfKind)kind, n, param, k );
        const float* out_dir[3] = { wo[0] + k, wo[1] + k, wo[2] + k };
        const float* in_dir[3] = { wi[0] + k, wi[1] + k, wi[2] + k };
        if ( f != NULL )
        {
            float* out[3] = { f[0] + k, f[1] + k, f[2] + k };
            rf_bsdf_evaluate( (RfBsdfKind)kind, count, &lanes, out_dir, in_dir, out,
                              pdf_solid_angle != NULL ? pdf_solid_angle + k : NULL );
        }
        else
            rf_bsdf_evaluate( (RfBsdfKind)kind, count, &lanes, out_dir, in_dir, NULL, pdf_solid_angle + k );
    }
}

static void clear( float* lanes, int count ) { memset( lanes, 0, (size_t)count * sizeof( float ) ); }

void rf_clear_directions( RfHitBatch* batch, int directions, bool eq15 )
{
    int count = rf_glossy_count( batch );
    if ( count == 0 )
        return;
    for ( int d = 0; d < directions; ++d )
    {
        RfDirectionLanes* lanes = batch->directions + d;
        for ( int c = 0; c < 3; ++c )
        {
            clear( lanes->wi[c], count );
            clear( lanes->q[c], count );
            if ( eq15 )
            {
                clear( lanes->a[c], count );
                clear( lanes->b[c], count );
            }
        }
        if ( eq15 )
            clear( lanes->light_pdf, count );
    }
}
