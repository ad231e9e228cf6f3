// The light of dimmed lamps, which records keep apart at scale 1: every frame scales it to its own (src/reuse/estimators.md, section 18).
#include "reuse/harvest/harvest_steps.h"

void rf_begin_parts( RfHarvest* harvest, int eye, int count, RfHarvestScratch* scratch )
{
    bool frames = rf_looks_at_frames( harvest );
    harvest->path.parts = ( rf_tracer_lights( harvest->path.tracer )->dimmed_count > 0 || frames ) && scratch->dimmed != NULL;
    harvest->path.frames = frames ? harvest->tracers : NULL;
    harvest->path.frame = harvest->path.at_frame = eye;
    scratch->wavefront.dimmed = scratch->dimmed;
    scratch->part = 0;
    for ( int k = 0; k < rf_dimmed_parts( &harvest->path ); ++k )
        rf_clear_arrivals( count, scratch->dimmed + k );
}

// The batch with the light of a part in the place of the rest.
static RfHitBatch batch_of_part( const RfHitBatch* batch, int part )
{
    const RfDimmedLight* light = batch->dimmed + part - 1;
    RfHitBatch out = *batch;
    out.radiance = light->radiance;
    out.directions = light->directions;
    out.removed = light->removed;
    out.removed_directions = light->removed_directions;
    out.arrivals = NULL;
    out.miss_count = out.glint_count = 0;
    return out;
}

// What paths have found at second vertices, shared by their tile.
static void light_tiles( const RfTileReuseSettings* settings, RfHarvestScratch* scratch )
{
    scratch->tiles->part = scratch->part;
    if ( scratch->tiles->paired )
        rf_light_pairings( settings, &scratch->wavefront, scratch->tiles );
}

void rf_weight_dimmed( const RfHarvest* harvest, const RfTileReuseSettings* tiles, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    batch->dimmed_count = rf_dimmed_parts( &harvest->path );
    for ( int part = 1; part <= batch->dimmed_count; ++part )
    {
        RfHitBatch of_part = batch_of_part( batch, part );
        scratch->part = part;
        if ( harvest->path.own != NULL ) // what else is kept apart has been added
            rf_clear_arrivals( RF_LANES, &harvest->path.own->arrivals );
        if ( rf_reuses_tiles( scratch ) && harvest->path.max_depth > 1 )
            light_tiles( tiles, scratch );
        if ( of_part.removed != NULL )
            rf_begin_removed( harvest, &of_part );
        rf_weight_batch( harvest, &of_part, scratch );
        batch->dimmed[part - 1].any_removed = of_part.any_removed;
        batch->any_removed = batch->any_removed || of_part.any_removed;
    }
    scratch->part = 0;
}
