#include "reuse/tile_connections.h"

float rf_connection_weight( const RfPathSettings* settings, const RfTileReuse* reuse, int i, int a )
{
    const RfVertexLanes *x = reuse->hits, *y = &reuse->second;
    if ( i < 0 || reuse->connection_area[a] == INFINITY || !rf_is_matte_lane( settings, x, i ) )
        return 1.0f;
    RfVec3 from =
        rf_madd( rf_vec3( x->p[0][i], x->p[1][i], x->p[2][i] ), rf_vec3( x->ng[0][i], x->ng[1][i], x->ng[2][i] ), x->offset[i] );
    return rf_own_weight( settings->connector->vpl_connections, reuse->connection_area[a], from,
                          rf_vec3( x->n[0][i], x->n[1][i], x->n[2][i] ), rf_vec3( y->p[0][a], y->p[1][a], y->p[2][a] ),
                          rf_vec3( y->ng[0][a], y->ng[1][a], y->ng[2][a] ) );
}

void rf_find_connection_weights( const RfPathSettings* settings, const RfTileReuse* reuse, int pairing, bool connections,
                                 float* weight )
{
    for ( int a = 0; a < rf_record_count( &reuse->second ); ++a )
    {
        int i = reuse->owner[a];
        bool has_receiver = i >= 0 && pairing < reuse->size[i];
        weight[a] = connections ? 0.0f : 1.0f;
        if ( connections && has_receiver )
            weight[a] = rf_connection_weight( settings, reuse, rf_receiver( reuse, a, pairing ), a );
    }
}

void rf_add_diffuse_connections( const RfPathSettings* settings, const float* const wi[3], int tile_pixels, RfTileReuse* reuse,
                                 RfLaneScratch* scratch )
{
    const RfVertexLanes* y = &reuse->second;
    int count = y->first[RF_BSDF_FIRST_GLOSSY];
    const float* wo[3] = { y->wo[0], y->wo[1], y->wo[2] };
    float *f[3] = { scratch->f[0], scratch->f[1], scratch->f[2] }, *weight = scratch->visible;
    rf_evaluate_seen_from( y, RF_BSDF_LAMBERT, wo, wi, f, scratch->pdf );
    for ( int a = 0; a < count; ++a )
    {
        float scale = 1.0f / ( reuse->light_pdf[a] + scratch->pdf[a] );
        for ( int c = 0; c < 3; ++c )
            f[c][a] *= reuse->a[c][a] * scale;
    }
    for ( int pairing = tile_pixels - 1; pairing >= 0; --pairing )
    {
        RfPairingLanes* t = reuse->pairings + pairing;
        rf_find_connection_weights( settings, reuse, pairing, true, weight );
        for ( int c = 0; c < 3; ++c )
        {
            for ( int a = 0; a < count; ++a )
                t->light[c][a] = reuse->pairings[0].light[c][a] + weight[a] * f[c][a];
        }
    }
}
