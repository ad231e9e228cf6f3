#include "reuse/harvest_internal.h"

#include "scene/projection.h"

#include <string.h>

static void make_keys( uint64_t pass_key, int count, const int32_t* pixel, RfWavefront* wavefront )
{
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfRandomKey key = rf_pixel_key( pass_key, (uint32_t)pixel[i] );
        wavefront->key_a[i] = key.a;
        wavefront->key_b[i] = key.b;
    }
}

// Further samples of a pixel have the random numbers of further passes.
static void make_copies_keys( const RfHarvest* harvest, RfTraceJob job, int count, const int32_t* copy,
                              RfHarvestScratch* scratch )
{
    for ( int i = 0; i < count; ++i )
    {
        RfRandomKey key = rf_pixel_key( rf_harvest_key( harvest, job.eye, job.pass + copy[i] ), (uint32_t)scratch->pixel[i] );
        scratch->wavefront.key_a[i] = key.a;
        scratch->wavefront.key_b[i] = key.b;
    }
}

// The rays of eyes that are no pinholes.
static void make_other_rays( const RfEye* eye, int count, const int32_t* pixel, float ( *random )[RF_LANES], RfRayLanes* rays )
{
    const float inverse[2] = { 1.0f / eye->focal_x, 1.0f / eye->focal };
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 o, d;
        rf_eye_ray( eye, inverse, pixel[i] % eye->width, pixel[i] / eye->width, random[0][i], random[1][i], &o, &d );
        rays->o[0][i] = o.x;
        rays->o[1][i] = o.y;
        rays->o[2][i] = o.z;
        rays->d[0][i] = d.x;
        rays->d[1][i] = d.y;
        rays->d[2][i] = d.z;
    }
}

void rf_make_camera_rays( const RfPixelFilter* filter, const RfEye* eye, int count, const int32_t* pixel, RfWavefront* wavefront,
                          RfRayLanes* rays )
{
    int32_t* slot = rays->slot;
    for ( int i = 0; i < count; ++i )
        slot[i] = i;
    float( *random )[RF_LANES] = wavefront->scratch.random;
    rf_draw_lanes( wavefront, count, slot, RF_DIMENSION_FILM_X, 2, random );
    if ( rf_has_filter( filter ) )
        rf_draw_places( filter, eye, count, pixel, random );
    RfEye e = *eye;
    const float inverse[2] = { 1.0f / e.focal_x, 1.0f / e.focal };
    RfVec3 origin = rf_pinhole_origin( &e );
    int straight = rf_is_perspective( eye ) ? count : 0;
    if ( straight < count )
        make_other_rays( eye, count, pixel, random, rays );
#pragma omp simd
    for ( int i = 0; i < straight; ++i )
    {
        int y = pixel[i] / e.width, x = pixel[i] - y * e.width;
        RfVec3 d = rf_pinhole_ray( &e, inverse, x, y, random[0][i], random[1][i] );
        rays->o[0][i] = origin.x;
        rays->o[1][i] = origin.y;
        rays->o[2][i] = origin.z;
        rays->d[0][i] = d.x;
        rays->d[1][i] = d.y;
        rays->d[2][i] = d.z;
    }
    rays->count = count;
}

void rf_sample_direct( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    int k = harvest->path.light_samples;
    for ( int j = 0; j < harvest->shape.light_samples; ++j )
    {
        uint32_t dimension =
            j < k ? rf_vertex_dimension( 1, k ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)j
                  : rf_vertex_dimension( 1, k ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)( j - k ) + RF_DIMENSION_OPPOSITE;
        rays->shadow += (uint64_t)rf_sample_lights( &harvest->path, &scratch->wavefront, scratch->hits, dimension,
                                                    scratch->direct + j, &scratch->wavefront.scratch );
    }
}

// Panes that camera rays pass do not count in max_depth.
static void note_passed_panes( const RfHarvest* harvest, RfHarvestScratch* scratch, float* const wi[3] )
{
    const RfVertexLanes* v = &scratch->first;
    memset( scratch->spent, 0, sizeof scratch->spent );
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        float cos_g = v->ng[0][i] * wi[0][i] + v->ng[1][i] * wi[1][i] + v->ng[2][i] * wi[2][i];
        scratch->spent[v->slot[i]] = cos_g < 0.0f && rf_is_at_pane( harvest->path.tracer, v, i ) ? -1 : 0;
    }
    scratch->wavefront.spent = scratch->spent;
}

// Tiles share the light of chains; not where connections find it, nor where replayed rays could meet other surfaces, nor in gradients.
static bool shares_chain_light( const RfHarvest* harvest, const RfHarvestScratch* scratch )
{
    return rf_reuses_tiles( scratch ) && rf_calls_for( scratch->chains != NULL, RF_EFFECT_CHAINS ) &&
           !rf_tracer_runs( harvest->path.tracer ).any_blended && harvest->path.connector == NULL && !harvest->path_roulette &&
           harvest->path_source == NULL;
}

void rf_trace_hit_tails( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    const RfVertexLanes* v = scratch->hits;
    RfWavefront* wavefront = &scratch->wavefront;
    float* wi[3] = { scratch->scattered[0], scratch->scattered[1], scratch->scattered[2] };
    bool chain_light = shares_chain_light( harvest, scratch );
    wavefront->chain_light = !( chain_light || scratch->chain_samples != NULL ) ? NULL
                             : rf_reuses_tiles( scratch )                       ? &scratch->tiles->chain_light
                                                                                : scratch->chain_light;
    rf_scatter_deferred( &harvest->path, wavefront, v, 1, wi );
    int specular = v->count - rf_record_count( v );
    if ( specular > 0 )
        memcpy( scratch->specular_pdf, wavefront->scratch.pdf + rf_record_count( v ), (size_t)specular * sizeof( float ) );
    if ( specular > 0 && rf_tracer_has_panes( harvest->path.tracer ) )
        note_passed_panes( harvest, scratch, wi );
    if ( rf_reuses_tiles( scratch ) )
    {
        RfTileReuseSettings settings = { &harvest->path,
                                         harvest->shape.tile_pixels,
                                         rf_calls_for( harvest->tile_roulette, RF_EFFECT_TILE_ROULETTE ),
                                         harvest->path_roulette,
                                         chain_light,
                                         harvest->path_source };
        rays->tile += rf_trace_tile_tails( &settings, v, wi, wavefront, scratch->tiles );
    }
    else
        rf_trace_tails( &harvest->path, wavefront, 2 );
    if ( wavefront->chain_light != NULL )
        rf_add_chain_light( harvest, scratch, rf_chain_sampling( harvest, chain_light ) );
}

void rf_follow_camera_rays( const RfHarvest* harvest, RfHarvestScratch* scratch )
{
    const RfVertexLanes* first = &scratch->first;
    RfWavefront* wavefront = &scratch->wavefront;
    scratch->hits = first;
    wavefront->spent = NULL;
    if ( !rf_calls_for( scratch->chains != NULL, RF_EFFECT_CHAINS ) || !rf_has_chains( first ) )
        return;
    rf_follow_chains( &harvest->path, first, &scratch->camera_rays, !harvest->first_hits_only, wavefront, scratch->chains );
    scratch->hits = &scratch->chains->hits;
    wavefront->spent = scratch->chains->length;
    if ( rf_reuses_tiles( scratch ) )
        rf_split_tiles( scratch->chains, scratch->tiles );
}

// Of pinholes.
static int harvest_first_hits( const RfHarvest* harvest, RfTraceJob job, RfHitBatch* batch, RfHarvestScratch* scratch,
                               RfRayCounts* rays )
{
    const RfEye* eye = harvest->eyes + job.eye;
    RfWavefront* wavefront = &scratch->wavefront;
    uint64_t key = rf_harvest_key( harvest, job.eye, job.pass );
    batch->eye = job.eye;
    rf_clear_ray_counts( wavefront );

    int tiles, count = rf_list_patch( &harvest->patches, eye, key, job.job, scratch->pixel, scratch->tile_of, &tiles );
    int32_t copy[RF_LANES];
    if ( rf_is_adaptive( harvest ) && harvest->packed )
        count = rf_pack_needy( harvest, key, count, &tiles, scratch, copy );
    else if ( rf_is_adaptive( harvest ) )
        count = rf_choose_needy( harvest, key, count, tiles, scratch );
    else if ( harvest->pieces != NULL )
        count = rf_choose_traced( harvest, eye, count, scratch );
    if ( rf_reuses_tiles( scratch ) )
    {
        memcpy( scratch->tiles->tile_of, scratch->tile_of, (size_t)count * sizeof *scratch->tile_of );
        scratch->tiles->tile_count = tiles;
    }
    make_keys( key, count, scratch->pixel, wavefront );
    if ( rf_is_adaptive( harvest ) && harvest->packed )
        make_copies_keys( harvest, job, count, copy, scratch );
    rf_make_camera_rays( harvest->drawn_by, eye, count, scratch->pixel, wavefront, &scratch->camera_rays );
    for ( int c = 0; c < 2 && scratch->place[0] != NULL; ++c )
        memcpy( scratch->place[c], wavefront->scratch.random[c], (size_t)count * sizeof( float ) );
    rf_find_vertices( &harvest->path, &scratch->camera_rays, true, &scratch->first, &wavefront->scratch );
    rays->primary += (uint64_t)count;
    rf_follow_camera_rays( harvest, scratch );
    rf_list_hits( count, scratch, batch );
    return count;
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
        scratch->wavefront.roulette_scale[slot] = rf_maxf( most, 0.1f );
    }
}

int rf_harvest_first_hits( const RfHarvest* harvest, RfTraceJob job, RfHitBatch* batch, RfHarvestScratch* scratch,
                           RfRayCounts* rays )
{
    if ( rf_is_blurred_shape( &harvest->shape ) )
        batch->lens = rf_draw_lens( harvest, job );
    RfHarvest at = rf_harvest_at( harvest, batch->lens, scratch );
    return harvest_first_hits( &at, job, batch, scratch, rays );
}

// Beyond the hits; with light paths, connections at all vertices.
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
    rf_connection_vertices( &connector, &scratch->wavefront, NULL, scratch->hits, 1 );
}

static int harvest_batch( const RfHarvest* harvest, RfTraceJob job, RfHitBatch* batch, RfHarvestScratch* scratch,
                          RfRayCounts* rays )
{
    RfWavefront* wavefront = &scratch->wavefront;
    int count = harvest_first_hits( harvest, job, batch, scratch, rays );

    // the rest of their paths
    memset( &wavefront->arrivals, 0, sizeof wavefront->arrivals );
    wavefront->rays.count = 0;
    rf_scale_roulette( scratch, count );
    bool lit = harvest->path.max_depth > 1 && !harvest->first_hits_only;
    if ( lit )
    {
        rf_sample_direct( harvest, scratch, rays );
        trace_tails( harvest, scratch, rays );
    }
    rays->path += wavefront->path_rays;
    rays->shadow += wavefront->shadow_rays;

    // visibility from all eyes of the group, then MIS weights
    rf_test_batch_visibility( harvest, batch, scratch, rays );
    if ( harvest->first_hits_only )
        return count;
    rf_weight_batch( harvest, batch, scratch );
    if ( harvest->shape.own_frame_light )
        rf_light_own_frame( harvest, batch, scratch );
    return count;
}

int rf_harvest_batch( const RfHarvest* harvest, RfTraceJob job, RfHitBatch* batch, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    if ( rf_is_blurred_shape( &harvest->shape ) )
        batch->lens = rf_draw_lens( harvest, job );
    RfHarvest at = rf_harvest_at( harvest, batch->lens, scratch );
    return harvest_batch( &at, job, batch, scratch, rays );
}
