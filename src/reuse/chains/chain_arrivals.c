// Light that reaches first hits by chains: from their paths and from chain samples (path/chain_samples.h),
// combined by the balance heuristic (src/reuse/estimators.md, section 10).
#include "reuse/chains/chain_arrivals.h"

#include <string.h>

// Hits behind a chain get chain samples: no other frame helps them, and their paths are the most expensive.
static void list_hits( const RfHarvestScratch* scratch, RfChainSamples* samples )
{
    const RfVertexLanes* v = scratch->hits;
    samples->count = 0;
    for ( int i = 0; i < rf_record_count( v ); ++i )
    {
        samples->taken[i] = rf_follows_chains( scratch ) && scratch->chains->view[v->slot[i]] == RF_VIEW_CHAIN;
        samples->hit[samples->count] = i;
        samples->count += samples->taken[i];
    }
}

static void add_own( const RfHarvest* harvest, RfHarvestScratch* scratch, RfChainSampling sampling )
{
    const RfVertexLanes* v = scratch->hits;
    const RfChainLight* chain_light = harvest->path.chain_light;
    for ( int i = 0; i < rf_record_count( v ); ++i )
    {
        int slot = v->slot[i];
        bool taken = scratch->chain_samples != NULL && scratch->chain_samples->taken[i];
        bool own = harvest->path.own != NULL && chain_light->touched[slot];
        int part = harvest->path.grouped ? chain_light->part[slot] : 0;
        RfArrivals* arrivals = rf_arrivals_of_part( &scratch->wavefront, part );
        float( *rest )[RF_LANES] = own ? rf_own_arrivals( harvest->path.own, part )->rest : arrivals->rest;
        float( *to )[RF_LANES] = taken ? arrivals->emitted : rest, found = 0.0f;
        for ( int c = 0; c < 3; ++c )
            found += chain_light->light[c][slot];
        if ( !( found > 0.0f ) )
            continue;
        float cosine = 0.0f;
        for ( int c = 0; c < 3; ++c )
        {
            to[c][slot] += chain_light->light[c][slot];
            cosine += v->n[c][i] * scratch->scattered[c][i];
        }
        if ( taken )
            arrivals->light_pdf_solid_angle[slot] =
                rf_chain_sample_pdf( sampling, cosine ) / (float)harvest->shape->light_samples;
    }
}

void rf_add_chain_light( const RfHarvest* harvest, RfHarvestScratch* scratch, RfChainSampling sampling )
{
    if ( scratch->chain_samples != NULL )
        list_hits( scratch, scratch->chain_samples );
    add_own( harvest, scratch, sampling );
    if ( scratch->chain_samples != NULL )
        rf_trace_chain_samples( &harvest->path, sampling, scratch->hits, &scratch->wavefront, scratch->chain_samples );
}

void rf_share_chain_light( const RfHarvest* harvest, const RfHarvestScratch* scratch, int pairing, RfArrivalLanes* out )
{
    const RfVertexLanes* v = scratch->hits;
    const RfPairingLanes* t = scratch->tiles->pairings + pairing;
    for ( int i = v->first[RF_BSDF_FIRST_GLOSSY]; i < rf_record_count( v ); ++i )
    {
        if ( !( scratch->chain_samples->taken[i] && rf_receives_chain_light( scratch->tiles, pairing, i ) ) )
            continue;
        float cosine = 0.0f;
        for ( int c = 0; c < 3; ++c )
        {
            cosine += v->n[c][i] * t->wi[c][i];
            out->a[c][i] = out->b[c][i];
            out->b[c][i] = 0.0f;
        }
        out->light_pdf[i] = rf_chain_sample_pdf( rf_chain_sampling( harvest, true ), cosine );
    }
}
