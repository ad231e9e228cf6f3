#include "path/chain_light.h"

static void add_event( RfChainLight* chain_light, const RfVertexLanes* v, int i, const float* const wi[3], float pdf )
{
    int slot = v->slot[i], at = chain_light->length[slot];
    if ( !chain_light->open[slot] || at == RF_MAX_CHAIN_LIGHT || !rf_is_chain_event( v, i, pdf ) )
    {
        chain_light->open[slot] = false;
        return;
    }
    bool transmits = v->n[0][i] * wi[0][i] + v->n[1][i] * wi[1][i] + v->n[2][i] * wi[2][i] < 0.0f;
    chain_light->transmitted[slot] |= (uint16_t)( (unsigned)transmits << at );
    chain_light->length[slot] += 1;
}

static void begin( RfChainLight* chain_light, const RfVertexLanes* v, int i )
{
    int slot = v->slot[i];
    for ( int c = 0; c < 3; ++c )
        chain_light->light[c][slot] = 0.0f;
    chain_light->transmitted[slot] = 0;
    chain_light->length[slot] = 0;
    chain_light->open[slot] = i < rf_record_count( v );
}

void rf_note_chain_events( RfChainLight* chain_light, const RfVertexLanes* v, int vertex, const float* const wi[3],
                           const float* pdf )
{
    for ( int i = 0; i < v->count && chain_light != NULL; ++i )
    {
        if ( vertex == 1 )
            begin( chain_light, v, i );
        else
            add_event( chain_light, v, i, wi, pdf[i] );
    }
}
