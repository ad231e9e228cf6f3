// Parts of the light, of groups and of dimmed lamps, which records keep apart: every frame scales them to its own
// (src/reuse/estimators.md, section 18).
#include "reuse/harvest/harvest_steps.h"

#include <string.h>

void rf_begin_groups( RfHarvest* harvest, RfHarvestScratch* scratch )
{
    harvest->path.grouped = rf_tracer_lights( harvest->path.tracer )->group_count > 1 && scratch->dimmed != NULL;
    scratch->wavefront.dimmed = scratch->dimmed;
}

void rf_begin_parts( RfHarvest* harvest, int eye, int count, RfHarvestScratch* scratch )
{
    bool frames = rf_looks_at_frames( harvest );
    harvest->path.parts = ( rf_tracer_lights( harvest->path.tracer )->dimmed_count > 0 || frames ) && scratch->dimmed != NULL;
    harvest->path.frames = frames ? harvest->tracers : NULL;
    harvest->path.frame = harvest->path.at_frame = eye;
    scratch->part = 0;
    for ( int k = 0; k < rf_dimmed_parts( &harvest->path ); ++k )
        rf_clear_arrivals( count, scratch->dimmed + k );
}

void rf_clear_parts( const RfHarvest* harvest, RfHitBatch* batch )
{
    batch->dimmed_count = rf_dimmed_parts( &harvest->path );
    for ( int part = 1; part <= batch->dimmed_count; ++part )
    {
        RfHitBatch of_part = rf_batch_of_part( batch, part, part < rf_base_parts( &harvest->path ) );
        size_t others = (size_t)( of_part.miss_count + of_part.glint_count );
        if ( others > 0 )
            memset( rf_miss_radiance( &of_part ), 0, 4 * others * sizeof( float ) );
        if ( of_part.removed != NULL )
            rf_begin_removed( harvest, &of_part );
        batch->dimmed[part - 1].any_removed = false;
    }
}

// What paths have found at second vertices, shared by their tile.
static void light_tiles( const RfTileReuseSettings* settings, RfHarvestScratch* scratch )
{
    scratch->tiles->part = scratch->part;
    if ( scratch->tiles->paired )
        rf_light_pairings( settings, &scratch->wavefront, scratch->tiles );
}

// Light that is kept apart for its own frame: what a base part has of it has been found; that of other parts is that of tiles alone.
static void begin_own( const RfHarvest* harvest, int part, RfHarvestScratch* scratch )
{
    int base = rf_counts_in( &harvest->path, part );
    if ( part >= rf_base_parts( &harvest->path ) )
        rf_clear_arrivals( RF_LANES, rf_own_arrivals( harvest->path.own, base ) );
    rf_set_own_group( scratch, base );
}

void rf_weight_dimmed( const RfHarvest* harvest, const RfTileReuseSettings* tiles, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    for ( int part = 1; part <= batch->dimmed_count; ++part )
    {
        RfHitBatch of_part = rf_batch_of_part( batch, part, part < rf_base_parts( &harvest->path ) );
        scratch->part = part;
        if ( harvest->path.own != NULL )
            begin_own( harvest, part, scratch );
        if ( rf_reuses_tiles( scratch ) && harvest->path.max_depth > 1 )
            light_tiles( tiles, scratch );
        rf_weight_batch( harvest, &of_part, scratch );
        batch->dimmed[part - 1].any_removed = of_part.any_removed;
        batch->any_removed = batch->any_removed || of_part.any_removed;
    }
    scratch->part = 0;
}
