// Traces a batch into hit records: its pixels, one lens point and shutter time for all of them, camera rays and
// their specular chains, hits, and the light that the rest of their paths brings.
#include "reuse/harvest/harvest.h"

#include "path/roulette.h"
#include "reuse/chains/chain_arrivals.h"
#include "reuse/harvest/camera_rays.h"
#include "reuse/harvest/hit_list.h"
#include "reuse/harvest/own_frame.h"
#include "reuse/harvest/record_weights.h"
#include "reuse/harvest/visibility.h"

#include <string.h>

RfHarvest rf_make_harvest( const RfEstimatorGroup* group )
{
    const RfRenderSettings* settings = group->settings;
    const RfReusePlan* plan = rf_reuse_plan( group );
    return ( RfHarvest ){
        .group = group,
        .plan = plan,
        .shape = &plan->shape,
        .path = { .tracer = group->tracer,
                  .max_depth = group->max_depth,
                  .frosted = plan->shape.frosted,
                  .guide = group->guide,
                  .light_samples = settings->light_samples,
                  .light_sampling = settings->light_sampling },
        .tracers = group->tracers,
        .eyes = group->eyes,
        .light_paths = rf_drawn_light_paths( group->shared ),
    };
}

RfHarvest rf_harvest_at( const RfHarvest* harvest, int eye, RfLensSample lens, RfHarvestScratch* scratch )
{
    RfHarvest at = *harvest;
    const RfBatchShape* shape = harvest->shape;
    if ( rf_is_blurred_shape( shape ) )
    {
        for ( int l = 0; l < shape->eyes; ++l )
            scratch->eyes[l] = rf_sample_eye( harvest->eyes + l, lens );
        at.eyes = scratch->eyes;
        for ( int l = 0; l < shape->eyes && scratch->tracers != NULL; ++l )
            scratch->tracers[l] = rf_tracer_at( rf_harvest_tracer( harvest, l ), lens.time,
                                                scratch->at_moment + (size_t)l * rf_tracer_at_bytes( shape->moving_lights ) );
        if ( scratch->tracers != NULL )
            at.tracers = scratch->tracers;
    }
    at.path.tracer = rf_harvest_tracer( &at, eye );
    at.path.occluders = &scratch->occluders;
    at.path.grouped = rf_tracer_lights( at.path.tracer )->group_count > 1 && shape->layers.parts > 1;
    return at;
}

void rf_sample_direct( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    int k = harvest->path.light_samples, samples = harvest->shape->light_samples;
    for ( int set = 0; set < rf_light_set_count( &harvest->path, samples ); ++set )
    {
        int j = set % samples;
        uint32_t dimension =
            j < k ? rf_vertex_dimension( 1, k ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)j
                  : rf_vertex_dimension( 1, k ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)( j - k ) + RF_DIMENSION_OPPOSITE;
        RfLightSample sample = { dimension, rf_frame_of_sample( &harvest->path, samples, set ) };
        rays->shadow += (uint64_t)rf_sample_lights( &harvest->path, &scratch->wavefront, scratch->hits, sample,
                                                    scratch->direct + set, &scratch->wavefront.scratch );
    }
}

// Thin panes that camera rays pass do not count towards max_depth (RfPathSettings.spent).
static void find_passed_panes( const RfHarvest* harvest, float* const wi[3], RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = &scratch->first;
    memset( scratch->spent, 0, sizeof scratch->spent );
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        float cos_g = v->ng[0][i] * wi[0][i] + v->ng[1][i] * wi[1][i] + v->ng[2][i] * wi[2][i];
        scratch->spent[v->slot[i]] = cos_g < 0.0f && rf_is_at_pane( harvest->path.tracer, v, i ) ? -1 : 0;
    }
}

// Tiles share the light of chains; not where connections find it, nor where replayed rays could meet other surfaces, nor in
// gradients, nor without caustics, which all of it is.
static bool shares_chain_light( const RfHarvest* harvest, const RfHarvestScratch* scratch )
{
    return rf_reuses_tiles( scratch ) && rf_calls_for( scratch->chains != NULL, RF_EFFECT_CHAINS ) &&
           !rf_tracer_runs( harvest->path.tracer ).any_blended && harvest->light_paths == NULL && !harvest->path_roulette &&
           harvest->path_source == NULL && !harvest->shape->caustics;
}

void rf_trace_hit_tails( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    const RfVertexLanes* v = scratch->hits;
    const RfPathSettings* path = &harvest->path;
    RfWavefront* wavefront = &scratch->wavefront;
    float* wi[3] = { scratch->scattered[0], scratch->scattered[1], scratch->scattered[2] };
    bool chain_light = shares_chain_light( harvest, scratch );
    rf_scatter_deferred( path, wavefront, v, 1, wi );
    int specular = v->count - rf_record_count( v );
    if ( specular > 0 )
        memcpy( scratch->specular_pdf, wavefront->scratch.pdf + rf_record_count( v ), (size_t)specular * sizeof( float ) );
    if ( path->spent == scratch->spent )
        find_passed_panes( harvest, wi, scratch );
    if ( rf_reuses_tiles( scratch ) )
    {
        RfTileReuseSettings settings = {
            .path = path,
            .tile_pixels = harvest->shape->tile_pixels,
            .tile_of = scratch->tile_of,
            .tile_count = scratch->tile_count,
            .path_roulette = harvest->path_roulette,
            .chain_light = chain_light,
            .source = harvest->path_source,
        };
        rays->tile += rf_trace_tile_tails( &settings, v, wi, wavefront, scratch->tiles );
    }
    else
        rf_trace_tails( path, wavefront, 2 );
    if ( path->chain_light != NULL )
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
    if ( !harvest->shape->caustics )
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

// Hits with chain samples are not guided: these are weighed against directions that are drawn by the cosine.
static void leave_unguided( RfVertexLanes* hits, const RfHarvestScratch* scratch )
{
    for ( int i = 0; i < rf_record_count( hits ) && hits->guide != NULL && scratch->chain_samples != NULL; ++i )
    {
        if ( scratch->chains->view[hits->slot[i]] == RF_VIEW_CHAIN )
            hits->table[i] = RF_NOT_GUIDED;
    }
}

void rf_follow_camera_rays( const RfHarvest* harvest, RfHarvestScratch* scratch )
{
    const RfVertexLanes* first = &scratch->first;
    RfWavefront* wavefront = &scratch->wavefront;
    scratch->hits = &scratch->first;
    if ( rf_calls_for( scratch->chains != NULL, RF_EFFECT_CHAINS ) && rf_has_chains( first ) )
    {
        scratch->chains->clamped = scratch->clamp != NULL;
        rf_follow_chains( &harvest->path, first, &scratch->camera_rays, !harvest->group->first_hits_only, wavefront,
                          scratch->chains );
        scratch->hits = &scratch->chains->hits;
        leave_unguided( &scratch->chains->hits, scratch );
    }
    if ( rf_reuses_tiles( scratch ) && ( rf_follows_chains( scratch ) || harvest->shape->caustics ) )
        split_tiles( harvest, scratch );
    if ( scratch->features != NULL && harvest->group->need == NULL && !harvest->group->first_hits_only )
        rf_find_features( &harvest->path, first, &scratch->camera_rays, !harvest->plan->alpha, wavefront, scratch->features );
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
    RfLightPathConnector connector = rf_make_connector( harvest->light_paths, harvest->group->settings->kernel_normalization,
                                                        &harvest->path, scratch->connections );
    RfHarvest connected = *harvest;
    connected.path.connector = &connector.connector;
    rf_trace_hit_tails( &connected, scratch, rays );
    for ( int j = 0; j < harvest->path.light_samples; ++j )
        rf_note_lit( &connected.path, &scratch->wavefront, scratch->direct + j, j, scratch->hits->count );
    rf_connect_vertices( &connector, &scratch->wavefront, NULL, scratch->hits, 1 );
}

// Estimates by first hits alone, without paths, how much of their light is own-frame.
static void look_for_own_light( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    RfWavefront* wavefront = &scratch->wavefront;
    float* wi[3] = { scratch->scattered[0], scratch->scattered[1], scratch->scattered[2] };
    rf_sample_direct( harvest, scratch, rays );
    rf_scatter_deferred( &harvest->path, wavefront, scratch->hits, 1, wi );
    rf_count_path_rays( wavefront, &wavefront->rays );
    rf_find_vertices_past_panes( &harvest->path, &wavefront->rays, 0, &wavefront->vertices, &wavefront->scratch );
    rf_find_own_parts( harvest, wavefront->scratch.triangle, scratch );
}

// Which vertices count towards max_depth before the hits.
static const int32_t* spent_before( const RfHarvest* harvest, const RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = scratch->hits;
    if ( v->count > rf_record_count( v ) && rf_tracer_has_panes( harvest->path.tracer ) )
        return scratch->spent;
    return rf_follows_chains( scratch ) ? scratch->chains->length : NULL;
}

RfHarvest rf_harvest_hits( const RfHarvest* harvest, int eye, RfHarvestScratch* scratch )
{
    RfHarvest out = *harvest;
    const RfLights* lights = rf_tracer_lights( harvest->path.tracer );
    bool frames = rf_looks_at_frames( harvest ), split = rf_splits_light( harvest ) || harvest->shape->caustics;
    bool chain_light = shares_chain_light( harvest, scratch ) || scratch->chain_samples != NULL;
    out.path.own = split ? &scratch->own->paths : NULL;
    out.path.parts = ( lights->dimmed_count > 0 || frames ) && harvest->shape->layers.parts > 1;
    out.path.frames = frames ? harvest->tracers : NULL;
    out.path.frame = eye;
    out.path.spent = spent_before( harvest, scratch );
    if ( chain_light )
        out.path.chain_light = rf_reuses_tiles( scratch ) ? &scratch->tiles->slots.chain_light : scratch->chain_light;
    return out;
}

// No light at slots [0, count) of the hits yet. What the chains before them have found is kept already, as it is in the frame: it
// holds there alone anyway, and is no caustic.
static void begin_light( const RfHarvest* harvest, int count, RfHarvestScratch* scratch )
{
    const RfPathSettings* path = &harvest->path;
    const RfBatchShape* shape = harvest->shape;
    for ( int part = 0; part <= rf_dimmed_parts( path ); ++part )
        rf_clear_arrivals( count, rf_arrivals_of_part( &scratch->wavefront, part ) );
    scratch->wavefront.rays.count = 0;
    rf_scale_roulette( scratch, count );
    if ( scratch->own != NULL )
        memset( scratch->own->part, 0, sizeof scratch->own->part );
    if ( path->own == NULL )
        return;
    path->own->caustics = false;
    if ( shape->caustics )
        rf_begin_caustics( count, path->own );
    else
        memset( path->own->touched, 0, (size_t)count );
    for ( int base = 0; base < rf_base_parts( path ); ++base )
    {
        rf_clear_arrivals( count, rf_own_arrivals( path->own, base ) );
        if ( scratch->own->removed != NULL )
            memset( scratch->own->removed[base].light, 0, 4 * (size_t)count * sizeof( float ) );
    }
    for ( int k = 0; k < rf_base_parts( path ) * rf_hit_kinds( &shape->layers ); ++k )
        memset( scratch->own->layers[k].light, 0, 4 * (size_t)count * sizeof( float ) );
}

int rf_harvest_batch( const RfEstimatorGroup* group, RfTraceJob job, RfHitBatch* batch, RfHarvestScratch* scratch,
                      RfRayCounts* rays )
{
    RfWavefront* wavefront = &scratch->wavefront;

    // ---- pixels and camera rays: all at one point of the lens and one moment of the shutter
    RfHarvest of_group = rf_make_harvest( group );
    if ( rf_is_blurred_shape( of_group.shape ) )
        batch->lens = rf_draw_lens( &of_group, job );
    const RfHarvest at = rf_harvest_at( &of_group, job.eye, batch->lens, scratch );
    batch->eye = job.eye;
    wavefront->dimmed = scratch->dimmed;
    rf_clear_ray_counts( wavefront );
    int count = rf_list_pixels( &at, job, scratch );
    rf_make_camera_rays( rf_drawn_by( group ), at.eyes + job.eye, count, scratch->pixel, wavefront, &scratch->camera_rays );
    for ( int c = 0; c < 2 && scratch->place[0] != NULL; ++c )
        memcpy( scratch->place[c], wavefront->scratch.random[c], (size_t)count * sizeof( float ) );
    rays->primary += (uint64_t)count;

    // ---- first hits, behind mirrors and glass
    rf_find_first_hits( &at, scratch );
    if ( scratch->own != NULL )
        rf_note_moving_hits( at.path.tracer, scratch );
    rf_follow_camera_rays( &at, scratch );
    rf_draw_sides( wavefront, 1, scratch->hits );
    rf_list_hits( &at, count, scratch, batch );
    if ( batch->surface != NULL )
        rf_note_surfaces( &at, count, scratch, batch );

    // ---- the rest of their paths: light samples, and scattered rays with all that they meet
    const RfHarvest hits = rf_harvest_hits( &at, job.eye, scratch ), *harvest = &hits;
    bool lit = harvest->path.max_depth > 1 && !group->first_hits_only;
    begin_light( harvest, count, scratch );
    if ( lit )
    {
        rf_sample_direct( harvest, scratch, rays );
        trace_tails( harvest, scratch, rays );
    }
    else if ( rf_splits_light( harvest ) && harvest->path.max_depth > 1 )
        look_for_own_light( harvest, scratch, rays );
    rays->path += wavefront->path_rays;
    rays->shadow += wavefront->shadow_rays;

    // ---- visibility from all cameras of the group, and what is known of the hits without light
    rf_test_batch_visibility( harvest, batch, scratch, rays );
    if ( group->first_hits_only )
        return count;

    // ---- MIS weights: the light of all layers
    rf_weight_batch( harvest, batch, scratch );
    if ( harvest->shape->own_frame_light )
        rf_light_own_frame( harvest, batch, scratch );
    if ( harvest->path.own != NULL )
        rf_add_own_light( harvest, batch, scratch );
    return count;
}
