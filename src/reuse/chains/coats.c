// Draws between a smooth coat's lobe, which goes on as a specular chain, and the base beneath it.
#include "reuse/chains/coats.h"

#include "scene/projection.h"

static float mean3( float* const param[RF_PARAM_COUNT], RfBsdfParam p, int i )
{
    return ( param[p][i] + param[p + 1][i] + param[p + 2][i] ) * ( 1.0f / 3.0f );
}

float rf_base_probability_of( const RfVertexLanes* v, int i )
{
    float cos_o = v->n[0][i] * v->wo[0][i] + v->n[1][i] * v->wo[1][i] + v->n[2][i] * v->wo[2][i];
    float diffuse = ( v->param[RF_PARAM_DIFFUSE][i] + v->param[RF_PARAM_DIFFUSE + 1][i] + v->param[RF_PARAM_DIFFUSE + 2][i] ) *
                    ( 1.0f / 3.0f );
    return rf_base_probability( diffuse, v->param[RF_PARAM_COAT_F0][i], v->param[RF_PARAM_COAT_F90][i], cos_o );
}

void rf_make_lobe( const RfVertexLanes* v, int i, RfVertexLanes* lobes, int to )
{
    rf_copy_vertices( v, i, 1, rf_bsdf_model( RF_BSDF_GGX )->params, lobes, to );
    float grazing = v->param[RF_PARAM_F90][i];
    for ( int c = 0; c < 3; ++c )
    {
        lobes->param[RF_PARAM_DIFFUSE + c][to] = 1.0f - grazing; // what mirrors that are lobes lack at grazing angles
        lobes->param[RF_PARAM_TINT + c][to] = 0.0f;
        lobes->absorption[c][to] = 0.0f;
    }
    lobes->param[RF_PARAM_F90][to] = 1.0f;
    lobes->param[RF_PARAM_IOR][to] = 0.0f;
}

void rf_make_base( RfVertexLanes* v, int i )
{
    for ( int c = 0; c < 3; ++c )
        v->param[RF_PARAM_SPECULAR + c][i] = 0.0f;
    v->param[RF_PARAM_F90][i] = 0.0f;
}

void rf_weight_bases( const RfHitBatch* batch, const RfEye* eye, float* density, float* const filter[3] )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY];
    for ( int i = first; i < batch->count; ++i )
    {
        if ( batch->view[i] != RF_VIEW_BASE )
            continue;
        int k = i - first;
        RfVec3 way = rf_scale( rf_eye_way( eye, RF_GET3( batch->p, i ) ), -1.0f );
        float cos_o = rf_dot( way, RF_GET3( batch->n, k ) ) / rf_length( way );
        float q = rf_base_probability( mean3( batch->param, RF_PARAM_DIFFUSE, k ), batch->param[RF_PARAM_COAT_F0][k],
                                       batch->param[RF_PARAM_COAT_F90][k], cos_o );
        density[i] *= q;
        for ( int c = 0; c < 3 && filter != NULL; ++c )
            filter[c][i] = 1.0f / q;
    }
}
