// What cameras see first on their way to the hits of a batch (film/covering.h): their own camera what its ray hit; another the hit
// itself, unless a thin pane or the mirror that shows it is before it.
#include "reuse/harvest/harvest_steps.h"

#include <string.h>

static uint32_t number_of( const RfHarvest* harvest, uint32_t triangle )
{
    return rf_surface_number( rf_tracer_scene( harvest->path.tracer ), harvest->shape.covering, triangle );
}

void rf_note_surfaces( const RfHarvest* harvest, int count, const RfHarvestScratch* scratch, RfHitBatch* batch )
{
    const RfVertexLanes* first = &scratch->first;
    uint32_t by_slot[RF_LANES];
    memset( by_slot, 0, (size_t)count * sizeof *by_slot );
    for ( int i = 0; i < first->count; ++i )
        by_slot[first->slot[i]] = number_of( harvest, scratch->surfaces->triangle[first->ray[i]] );
    for ( int i = 0; i < batch->count; ++i )
        batch->surface[i] = by_slot[scratch->hits->slot[i]];
    for ( int k = 0; k < batch->miss_count; ++k )
        batch->surface[batch->count + k] = by_slot[scratch->miss_slot[k]];
}

void rf_note_surfaces_seen( const RfHarvest* harvest, int eye, const float* density, const RfHarvestScratch* scratch,
                            RfHitBatch* batch )
{
    uint32_t* seen = batch->surface_seen + (size_t)eye * RF_LANES;
    bool chains = rf_follows_chains( scratch );
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        uint32_t before = scratch->first_seen[i], end = chains ? scratch->chains->triangle[slot] : RF_MISS;
        if ( !( density[i] > 0.0f ) )
            continue;
        if ( before != RF_MISS )
            seen[i] = number_of( harvest, before );
        else
            seen[i] = end != RF_MISS ? number_of( harvest, end ) : batch->surface[i];
    }
}
