// What the hits of a tile receive from second vertices, summed up.
#include "reuse/tile_reuse.h"

#include <string.h>

void rf_gather_tile_light( const RfTileReuse* reuse, int pairing, const RfVertexLanes* hits, int first, int end,
                           float light[3][RF_LANES] )
{
    int diffuse = reuse->shared;
    const RfPairingLanes *t = reuse->pairings + pairing, *own = reuse->pairings;
    for ( int i = first; i < end; ++i )
    {
        int a = t->vertex[i];
        float weight = t->weight[i];
        float cos_x = hits->n[0][i] * t->wi[0][i] + hits->n[1][i] * t->wi[1][i] + hits->n[2][i] * t->wi[2][i];
        const RfPairingLanes* from = a < diffuse ? own : t;
        for ( int c = 0; c < 3; ++c )
            light[c][i] = weight > 0.0f ? cos_x * weight * from->light[c][a] : 0.0f;
    }
    for ( int c = 0; c < 3 && reuse->pane_weight != NULL; ++c )
    {
        for ( int i = first; i < end; ++i )
            light[c][i] = t->weight[i] > 0.0f ? light[c][i] * reuse->pane_weight[pairing][c][i] : 0.0f;
    }
}

// The sum of a pairing whose light comes through panes.
static void sum_behind_panes( const RfPairingLanes* t, float pane_weight[3][RF_LANES], const RfPairingLanes* own, int diffuse,
                              const float* weight, int count, float sum[3][RF_LANES] )
{
    for ( int i = 0; i < count; ++i )
    {
        if ( t->weight[i] == 0.0f )
            continue;
        int a = t->vertex[i];
        const RfPairingLanes* from = a < diffuse ? own : t;
        for ( int c = 0; c < 3; ++c )
            sum[c][i] += weight[i] * pane_weight[c][i] * from->light[c][a];
    }
}

void rf_gather_diffuse_tile_light( const RfTileReuse* reuse, int pairings, int count, const bool* weighted, float chain_weight,
                                   float sum[3][RF_LANES] )
{
    int diffuse = reuse->shared;
    const RfPairingLanes* own = reuse->pairings;
    for ( int c = 0; c < 3; ++c )
        memset( sum[c], 0, (size_t)count * sizeof( float ) );
    for ( int s = 1; s < pairings; ++s )
    {
        const RfPairingLanes* t = reuse->pairings + s;
        const float* weight = t->weight;
        float scaled[RF_LANES];
        if ( weighted != NULL )
        {
            for ( int i = 0; i < count; ++i )
                scaled[i] = t->weight[i] * ( weighted[i] && rf_receives_chain_light( reuse, s, i ) ? chain_weight : 1.0f );
            weight = scaled;
        }
        if ( reuse->pane_weight != NULL )
        {
            sum_behind_panes( t, reuse->pane_weight[s], own, diffuse, weight, count, sum );
            continue;
        }
        for ( int i = 0; i < count; ++i )
        {
            if ( t->weight[i] == 0.0f )
                continue;
            int a = t->vertex[i];
            const RfPairingLanes* from = a < diffuse ? own : t;
            for ( int c = 0; c < 3; ++c )
                sum[c][i] += weight[i] * from->light[c][a];
        }
    }
}
