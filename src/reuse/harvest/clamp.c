// The clamp on the light of hit records: how much of what a path brings is kept (clamp.h).
#include "reuse/harvest/harvest_scratch.h"

#include <string.h>

void rf_begin_clamp( const RfHarvest* harvest, const RfHitBatch* batch, RfHarvestScratch* scratch )
{
    RfClampHits* clamp = scratch->clamp;
    for ( int kind = 0; kind < RF_CLAMP_KINDS; ++kind )
        clamp->threshold[kind] = harvest->group->clamp != NULL ? harvest->group->clamp[batch->eye].threshold[kind] : INFINITY;
    clamp->watch = harvest->group->clamp_watch;
    bool chains = rf_follows_chains( scratch );
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        clamp->dimmed[i] = 1.0f;
        if ( chains && batch->view[i] == RF_VIEW_CHAIN )
            clamp->dimmed[i] = rf_luminance( RF_GET3( scratch->chains->throughput, slot ) );
    }
}

void rf_clamp_seen_emission( RfHitBatch* batch, const RfHarvestScratch* scratch )
{
    for ( int i = 0; i < batch->part_count * batch->count; ++i )
    {
        int part = i / batch->count, hit = i % batch->count;
        RfLayerLight* removed = rf_removed_light( batch, part );
        float* radiance = rf_layer_light( batch, part, RF_KIND_EMISSION )->radiance + 4 * (size_t)hit;
        float value[3] = { radiance[0], radiance[1], radiance[2] };
        if ( batch->view[hit] != RF_VIEW_CHAIN || !( value[0] + value[1] + value[2] > 0.0f ) )
            continue;
        memset( radiance, 0, sizeof value );
        if ( rf_add_clamped( scratch->clamp, RF_CLAMP_CHAINS, batch, hit, value, radiance, removed->radiance + 4 * (size_t)hit ) )
            removed->dark = false;
    }
}
