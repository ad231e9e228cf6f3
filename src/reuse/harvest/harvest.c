// Traces a batch into hit records: its pixels, one lens point and shutter time for all of them, camera rays and
// their specular chains, hits, and the light that the rest of their paths brings.
#include "reuse/harvest/harvest.h"

#include "path/roulette.h"
#include "reuse/chains/chain_arrivals.h"
#include "reuse/harvest/camera_rays.h"
#include "reuse/harvest/hit_list.h"
#include "reuse/harvest/own_frame.h"
#include "reuse/harvest/own_glints.h"
#include "reuse/harvest/record_weights.h"
#include "reuse/harvest/visibility.h"

#include <string.h>

RfHarvest rf_harvest_at( const RfHarvest* harvest, int eye, RfLensSample lens, RfHarvestScratch* scratch )
{
    RfHarvest at = *harvest;
    at.path.tracer = rf_harvest_tracer( harvest, eye );
    at.path.occluders = &scratch->occluders;
    if ( !rf_is_blurred_shape( &harvest->shape ) )
        return at;
    for ( int l = 0; l < harvest->shape.eyes; ++l )
        scratch->eyes[l] = rf_sample_eye( harvest->eyes + l, lens );
    at.eyes = scratch->eyes;
    if ( scratch->tracers == NULL )
        return at;
    for ( int l = 0; l < harvest->shape.eyes; ++l )
        scratch->tracers[l] = rf_tracer_at( rf_harvest_tracer( harvest, l ), lens.time,
                                            scratch->at_moment + (size_t)l * rf_tracer_at_bytes( harvest->shape.moving_lights ) );
    at.tracers = scratch->tracers;
    at.path.tracer = scratch->tracers[eye];
    return at;
}

void rf_sample_direct( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    int k = harvest->path.light_samples, samples = harvest->shape.light_samples;
    for ( int set = 0; set < rf_light_set_count( &harvest->path, samples ); ++set )
    {
        int j = set % samples;
        uint32_t dimension =
            j < k ? rf_vertex_dimension( 1, k ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)j
                  : rf_vertex_dimension( 1, k ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)( j - k ) + RF_DIMENSION_OPPOSITE;
        RfPathSettings at = rf_settings_of_sample( &harvest->path, samples, set );
        rays->shadow += (uint64_t)rf_sample_lights( &at, &scratch->wavefront, scratch->hits, dimension, scratch->direct + set,
                                                    &scratch->wavefront.scratch );
    }
}

// Thin panes that camera rays pass do not count towards max_depth. Returns RfWavefront.spent.
static const int32_t* find_passed_panes( const RfHarvest* harvest, RfHarvestScratch* scratch, float* const wi[3] )
{
    const RfVertexLanes* v = &scratch->first;
    memset( scratch->spent, 0, sizeof scratch->spent );
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        float cos_g = v->ng[0][i] * wi[0][i] + v->ng[1][i] * wi[1][i] + v->ng[2][i] * wi[2][i];
        scratch->spent[v->slot[i]] = cos_g < 0.0f && rf_is_at_pane( harvest->path.tracer, v, i ) ? -1 : 0;
    }
    return scratch->spent;
}

// Tiles share the light of chains; not where connections find it, nor where replayed rays could meet other surfaces, nor in
// gradients, nor without caustics, which all of it is.
static bool shares_chain_light( const RfHarvest* harvest, const RfHarvestScratch* scratch )
{
    return rf_reuses_tiles( scratch ) && rf_calls_for( scratch->chains != NULL, RF_EFFECT_CHAINS ) &&
           !rf_tracer_runs( harvest->path.tracer ).any_blended && harvest->path.connector == NULL && !harvest->path_roulette &&
           harvest->path_source == NULL && !harvest->shape.caustics;
}

// How tiles share paths.
static RfTileReuseSettings tile_settings( const RfHarvest* harvest, const RfHarvestScratch* scratch )
{
    return ( RfTileReuseSettings ){
        .path = &harvest->path,
        .tile_pixels = harvest->shape.tile_pixels,
        .tile_of = scratch->tile_of,
        .tile_count = scratch->tile_count,
        .path_roulette = harvest->path_roulette,
        .chain_light = shares_chain_light( harvest, scratch ),
        .source = harvest->path_source,
    };
}

void rf_trace_hit_tails( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    const RfVertexLanes* v = scratch->hits;
    RfWavefront* wavefront = &scratch->wavefront;
    float* wi[3] = { scratch->scattered[0], scratch->scattered[1], scratch->scattered[2] };
    bool chain_light = shares_chain_light( harvest, scratch );
    wavefront->spent = rf_follows_chains( scratch ) ? scratch->chains->length : NULL;
    wavefront->chain_light = !( chain_light || scratch->chain_samples != NULL ) ? NULL
                             : rf_reuses_tiles( scratch )                       ? &scratch->tiles->slots.chain_light
                                                                                : scratch->chain_light;
    rf_scatter_deferred( &harvest->path, wavefront, v, 1, wi );
    int specular = v->count - rf_record_count( v );
    if ( specular > 0 )
        memcpy( scratch->specular_pdf, wavefront->scratch.pdf + rf_record_count( v ), (size_t)specular * sizeof( float ) );
    if ( specular > 0 && rf_tracer_has_panes( harvest->path.tracer ) )
        wavefront->spent = find_passed_panes( harvest, scratch, wi );
    if ( rf_reuses_tiles( scratch ) )
    {
        RfTileReuseSettings settings = tile_settings( harvest, scratch );
        rays->tile += rf_trace_tile_tails( &settings, v, wi, wavefront, scratch->tiles );
    }
    else
        rf_trace_tails( &harvest->path, wavefront, 2 );
    if ( wavefront->chain_light != NULL )
        rf_add_chain_light( harvest, scratch, rf_chain_sampling( harvest, chain_light ) );
}

void rf_find_first_hits( const RfHarvest* harvest, RfHarvestScratch* scratch )
{
    RfLaneScratch* lanes = &scratch->wavefront.scratch;
    rf_find_vertices( &harvest->path, &scratch->camera_rays, true, &scratch->first, lanes );
    if ( scratch->surfaces == NULL )
        return;
    size_t count = (size_t)scratch->camera_rays.count;
    memcpy( scratch->surfaces->triangle, lanes->triangle, count * sizeof *lanes->triangle );
    memcpy( scratch->surfaces->u, lanes->u, count * sizeof *lanes->u );
    memcpy( scratch->surfaces->v, lanes->v, count * sizeof *lanes->v );
}

// Splits tiles by chain length, since paths with different numbers of vertices left do not share, and without caustics by whether
// hits throw them: what second vertices send on is a caustic to some hits, and to others not.
static void split_tiles( const RfHarvest* harvest, RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = scratch->hits;
    if ( !harvest->shape.caustics )
    {
        rf_split_tiles( v, scratch->chains->length, scratch->tile_of, &scratch->tile_count );
        return;
    }
    int32_t key[RF_LANES];
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        for ( int i = v->first[kind]; i < v->first[kind + 1]; ++i )
            key[v->slot[i]] = rf_throws_caustics( v, (RfBsdfKind)kind, i ) +
                              2 * ( rf_follows_chains( scratch ) ? scratch->chains->length[v->slot[i]] : 0 );
    }
    rf_split_tiles( v, key, scratch->tile_of, &scratch->tile_count );
}

void rf_follow_camera_rays( const RfHarvest* harvest, RfHarvestScratch* scratch )
{
    const RfVertexLanes* first = &scratch->first;
    RfWavefront* wavefront = &scratch->wavefront;
    scratch->hits = &scratch->first;
    if ( rf_calls_for( scratch->chains != NULL, RF_EFFECT_CHAINS ) && rf_has_chains( first ) )
    {
        scratch->chains->clamped = scratch->clamp != NULL;
        rf_follow_chains( &harvest->path, first, &scratch->camera_rays, !harvest->first_hits_only, wavefront, scratch->chains );
        scratch->hits = &scratch->chains->hits;
    }
    if ( rf_reuses_tiles( scratch ) && ( rf_follows_chains( scratch ) || harvest->shape.caustics ) )
        split_tiles( harvest, scratch );
    if ( scratch->features != NULL && harvest->need == NULL && !harvest->first_hits_only )
        rf_find_features( &harvest->path, first, &scratch->camera_rays, !harvest->alpha, wavefront, scratch->features );
}

void rf_scale_roulette( RfHarvestScratch* scratch, int count )
{
    bool chains = rf_follows_chains( scratch );
    for ( int slot = 0; slot < count; ++slot )
    {
        float most = 1.0f;
        if ( chains )
            most = rf_maxf( scratch->chains->throughput[0][slot],
                            rf_maxf( scratch->chains->throughput[1][slot], scratch->chains->throughput[2][slot] ) );
        scratch->wavefront.roulette_scale[slot] = rf_shared_factor( most );
    }
}

// The rest of the paths; with light paths, connections at all vertices.
static void trace_tails( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    if ( harvest->light_paths == NULL )
    {
        rf_trace_hit_tails( harvest, scratch, rays );
        return;
    }
    RfLightPathConnector connector =
        rf_make_connector( harvest->light_paths, harvest->kernel_normalization, &harvest->path, scratch->connections );
    RfHarvest connected = *harvest;
    connected.path.connector = &connector.connector;
    rf_trace_hit_tails( &connected, scratch, rays );
    for ( int j = 0; j < harvest->path.light_samples; ++j )
        rf_note_lit( &connected.path, &scratch->wavefront, scratch->direct + j, j, scratch->hits->count );
    rf_connect_vertices( &connector, &scratch->wavefront, NULL, scratch->hits, 1 );
}

// From here on light is kept apart that holds in its own frame alone, or caustics: what the chains before first hits have found does
// the former anyway, and is none of the latter.
static void split_light( RfHarvest* harvest, int count, RfHarvestScratch* scratch )
{
    harvest->path.own = &scratch->own->paths;
    for ( int base = 0; base < rf_base_parts( &harvest->path ); ++base )
        rf_clear_arrivals( count, rf_own_arrivals( harvest->path.own, base ) );
    harvest->path.own->caustics = false;
    if ( harvest->shape.caustics )
        rf_begin_caustics( count, harvest->path.own );
    else
        memset( harvest->path.own->touched, 0, (size_t)count );
    int base_parts = rf_base_parts( &harvest->path ), kinds = rf_hit_kinds( &harvest->shape.layers );
    for ( int k = 0; k < base_parts * kinds; ++k )
        memset( scratch->own->layers[k].light, 0, 4 * (size_t)count * sizeof( float ) );
    for ( int base = 0; base < base_parts && scratch->own->removed != NULL; ++base )
        memset( scratch->own->removed[base].light, 0, 4 * (size_t)count * sizeof( float ) );
}

// Estimates by first hits alone, without paths, how much of their light is own-frame.
static void look_for_own_light( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    RfWavefront* wavefront = &scratch->wavefront;
    float* wi[3] = { scratch->scattered[0], scratch->scattered[1], scratch->scattered[2] };
    wavefront->spent = NULL;
    wavefront->chain_light = NULL;
    rf_sample_direct( harvest, scratch, rays );
    rf_scatter_deferred( &harvest->path, wavefront, scratch->hits, 1, wi );
    rf_count_path_rays( wavefront, &wavefront->rays );
    rf_find_vertices_past_panes( &harvest->path, &wavefront->rays, 0, &wavefront->vertices, &wavefront->scratch );
    rf_find_own_parts( harvest, wavefront->scratch.triangle, scratch );
}

// From here on light groups are kept apart, if there are any: light as it is in the frame, by base part.
static void begin_groups( RfHarvest* harvest, RfHarvestScratch* scratch )
{
    harvest->path.grouped = rf_tracer_lights( harvest->path.tracer )->group_count > 1 && harvest->shape.layers.parts > 1;
    scratch->wavefront.dimmed = scratch->dimmed;
}

// From here on light of all parts is kept apart at slots [0, count) of a frame's hits: what the chains before them have found of it is
// as in the frame.
static void begin_parts( RfHarvest* harvest, int eye, int count, RfHarvestScratch* scratch )
{
    bool frames = rf_looks_at_frames( harvest );
    harvest->path.parts =
        ( rf_tracer_lights( harvest->path.tracer )->dimmed_count > 0 || frames ) && harvest->shape.layers.parts > 1;
    harvest->path.frames = frames ? harvest->tracers : NULL;
    harvest->path.frame = harvest->path.at_frame = eye;
    for ( int part = 0; part <= rf_dimmed_parts( &harvest->path ); ++part )
        rf_clear_arrivals( count, rf_arrivals_of_part( &scratch->wavefront, part ) );
}

int rf_harvest_batch( const RfHarvest* group, RfTraceJob job, RfHitBatch* batch, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    RfWavefront* wavefront = &scratch->wavefront;

    // ---- pixels and camera rays: all at one point of the lens and one moment of the shutter
    if ( rf_is_blurred_shape( &group->shape ) )
        batch->lens = rf_draw_lens( group, job );
    RfHarvest at = rf_harvest_at( group, job.eye, batch->lens, scratch ), *harvest = &at;
    batch->eye = job.eye;
    begin_groups( harvest, scratch );
    rf_clear_ray_counts( wavefront );
    int count = rf_list_pixels( harvest, job, scratch );
    rf_make_camera_rays( harvest->drawn_by, harvest->eyes + job.eye, count, scratch->pixel, wavefront, &scratch->camera_rays );
    for ( int c = 0; c < 2 && scratch->place[0] != NULL; ++c )
        memcpy( scratch->place[c], wavefront->scratch.random[c], (size_t)count * sizeof( float ) );
    rays->primary += (uint64_t)count;

    // ---- first hits, behind mirrors and glass
    rf_find_first_hits( harvest, scratch );
    if ( scratch->own != NULL )
        rf_note_moving_hits( harvest->path.tracer, scratch );
    rf_follow_camera_rays( harvest, scratch );
    rf_draw_sides( wavefront, 1, scratch->hits );
    rf_list_hits( harvest, count, scratch, batch );
    if ( batch->surface != NULL )
        rf_note_surfaces( harvest, count, scratch, batch );

    // ---- the rest of their paths
    if ( scratch->own != NULL )
        memset( scratch->own->part, 0, sizeof scratch->own->part );
    if ( rf_splits_light( harvest ) || harvest->shape.caustics )
        split_light( harvest, count, scratch );
    begin_parts( harvest, batch->eye, count, scratch );
    wavefront->rays.count = 0;
    rf_scale_roulette( scratch, count );
    bool lit = harvest->path.max_depth > 1 && !harvest->first_hits_only;
    if ( lit )
    {
        rf_sample_direct( harvest, scratch, rays );
        trace_tails( harvest, scratch, rays );
    }
    else if ( rf_splits_light( harvest ) && harvest->path.max_depth > 1 )
        look_for_own_light( harvest, scratch, rays );
    rays->path += wavefront->path_rays;
    rays->shadow += wavefront->shadow_rays;

    // ---- visibility from all cameras of the group
    rf_test_batch_visibility( harvest, batch, scratch, rays );
    if ( harvest->first_hits_only )
        return count;

    // ---- MIS weights: the light of all layers
    if ( scratch->clamp != NULL )
        rf_begin_clamp( harvest, batch, scratch );
    rf_weight_batch( harvest, batch, scratch );
    if ( harvest->shape.own_frame_light )
        rf_light_own_frame( harvest, batch, scratch );
    if ( harvest->path.own != NULL )
        rf_add_own_light( harvest, batch, scratch );
    return count;
}
