#include "reuse/harvest_internal.h"

#include "scene/pinhole.h"

#include <string.h>

RfBatchShape rf_batch_shape( const RfEstimatorGroup* group )
{
    const RfRenderSettings* settings = group->settings;
    bool unevaluable = ( group->traits.kinds & ~0u << RF_BSDF_FIRST_UNEVALUABLE ) != 0;
    int tile_pixels = rf_tile_pixels( &settings->tile );
    bool grouped = settings->group != 0 && ( group->traits.mirrors || group->traits.smooth || group->traits.panes );
    bool chains =
        ( unevaluable || group->traits.smooth ) && settings->weights == RF_WEIGHTS_EXACT && ( tile_pixels > 1 || grouped );
    return ( RfBatchShape ){
        .eyes = group->eye_count,
        .light_samples = settings->light_samples,
        .tile_pixels = tile_pixels,
        .params = rf_glossy_params( group->traits.kinds ),
        .eq15 = settings->weights == RF_WEIGHTS_EQ15,
        .blended = group->traits.blended,
        .panes = group->traits.panes,
        .own_frame_light = unevaluable || chains || group->traits.sky,
        .chains = chains,
    };
}

RfHarvest rf_make_harvest( const RfEstimatorGroup* group )
{
    const RfRenderSettings* settings = group->settings;
    return ( RfHarvest ){
        .path = { group->tracer, group->max_depth, settings->light_samples, settings->light_sampling },
        .shape = rf_batch_shape( group ),
        .patches = rf_lay_out_patches( &settings->tile, group->width, group->height ),
        .tile_roulette = settings->tile_roulette,
        .weights = settings->weights,
        .seed = settings->seed,
        .eyes = group->eyes,
        .first_frame = group->first_frame,
        .group = group->number,
        .need = group->need,
        .round = group->round,
        .first_hits_only = group->first_hits_only,
    };
}

static size_t scratch_struct_bytes( void ) { return ( sizeof( RfHarvestScratch ) + 63 ) / 64 * 64; }

size_t rf_harvest_scratch_bytes( const RfBatchShape* shape )
{
    size_t lanes = RF_LANES * sizeof( float );
    return scratch_struct_bytes() + (size_t)shape->light_samples * sizeof( RfLightLanes ) + (size_t)shape->eyes * lanes +
           (size_t)rf_direction_count( shape ) * lanes +
           rf_tile_reuse_bytes( shape->light_samples, shape->tile_pixels, shape->panes ) +
           ( shape->chains ? sizeof( RfChains ) + 64 : 0 );
}

RfHarvestScratch* rf_lay_out_harvest_scratch( const RfBatchShape* shape, void* memory )
{
    RfHarvestScratch* scratch = memory;
    scratch->direct = (RfLightLanes*)( (char*)memory + scratch_struct_bytes() );
    scratch->density = (float*)( scratch->direct + shape->light_samples );
    scratch->mixture = scratch->density + (size_t)shape->eyes * RF_LANES;
    char* rest = (char*)( scratch->mixture + (size_t)rf_direction_count( shape ) * RF_LANES );
    scratch->tiles = rf_lay_out_tile_reuse( shape->light_samples, shape->tile_pixels, shape->panes, rest );
    rest += rf_tile_reuse_bytes( shape->light_samples, shape->tile_pixels, shape->panes );
    scratch->chains = shape->chains ? (RfChains*)(void*)( rest + ( 64 - (uintptr_t)rest % 64 ) % 64 ) : NULL;
    return scratch;
}

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

// One ray through a uniform point of each pixel.
static void make_camera_rays( const RfEye* eye, int count, const int32_t* pixel, RfWavefront* wavefront, RfRayLanes* rays )
{
    int32_t* slot = rays->slot;
    for ( int i = 0; i < count; ++i )
        slot[i] = i;
    float( *random )[RF_LANES] = wavefront->scratch.random;
    rf_draw_lanes( wavefront, count, slot, RF_DIMENSION_FILM_X, 2, random );
    RfEye e = *eye;
    float inverse_focal = 1.0f / e.focal;
    RfVec3 origin = rf_pinhole_origin( &e );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        int y = pixel[i] / e.width, x = pixel[i] - y * e.width;
        RfVec3 d = rf_pinhole_ray( &e, inverse_focal, x, y, random[0][i], random[1][i] );
        rays->o[0][i] = origin.x;
        rays->o[1][i] = origin.y;
        rays->o[2][i] = origin.z;
        rays->d[0][i] = d.x;
        rays->d[1][i] = d.y;
        rays->d[2][i] = d.z;
    }
    rays->count = count;
}

// Lists unevaluable hits and chains without a hit, of mirrors, glass and coats, behind the rays that missed.
static void note_own_frame( const RfVertexLanes* first, const uint8_t* recorded, RfHarvestScratch* scratch, RfHitBatch* batch )
{
    for ( int i = 0; i < first->count; ++i )
    {
        int slot = first->slot[i];
        if ( recorded[slot] )
            continue;
        rf_miss_pixel( batch )[batch->miss_count] = scratch->pixel[slot];
        scratch->miss_slot[batch->miss_count++] = slot;
    }
}

// Lists the pixels whose chain brought light and has a hit, too.
static void note_glints( const RfHarvestScratch* scratch, RfHitBatch* batch, int32_t* glint_slot )
{
    const RfChains* chains = scratch->chains;
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        if ( chains->light[0][slot] + chains->light[1][slot] + chains->light[2][slot] == 0.0f )
            continue;
        rf_glint_pixel( batch )[batch->glint_count] = scratch->pixel[slot];
        glint_slot[batch->glint_count++] = slot;
    }
}

// Hits keep the pixel they were drawn in. Rays that hit nothing are misses; what has no record is listed behind these.
static void note_pixels( int count, RfHarvestScratch* scratch, RfHitBatch* batch )
{
    uint8_t hit[RF_LANES], recorded[RF_LANES];
    memset( hit, 0, (size_t)count );
    memset( recorded, 0, (size_t)count );
    for ( int i = 0; i < scratch->first.count; ++i )
        hit[scratch->first.slot[i]] = 1;
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        recorded[slot] = 1;
        batch->pixel[i] = scratch->pixel[slot];
    }
    int32_t* miss_pixel = rf_miss_pixel( batch );
    batch->miss_count = batch->glint_count = 0;
    for ( int slot = 0; slot < count; ++slot )
    {
        miss_pixel[batch->miss_count] = scratch->pixel[slot];
        scratch->miss_slot[batch->miss_count] = slot;
        batch->miss_count += !hit[slot];
    }
    scratch->ray_miss_count = batch->miss_count;
    note_own_frame( &scratch->first, recorded, scratch, batch );
    if ( scratch->hits != &scratch->first )
        note_glints( scratch, batch, scratch->glint_slot );
}

static void sample_direct( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    int k = harvest->path.light_samples;
    uint32_t dimension = rf_vertex_dimension( 1, k ) + RF_DIMENSION_LIGHTS;
    for ( int j = 0; j < k; ++j )
        rays->shadow +=
            (uint64_t)rf_sample_lights( &harvest->path, &scratch->wavefront, scratch->hits, dimension + 3u * (uint32_t)j,
                                        scratch->direct + j, &scratch->wavefront.scratch );
}

// Panes that camera rays pass do not count in max_depth.
static void note_passed_panes( const RfHarvest* harvest, RfHarvestScratch* scratch, float* const wi[3] )
{
    const RfVertexLanes* v = &scratch->first;
    memset( scratch->spent, 0, sizeof scratch->spent );
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        float cos_g = v->ng[0][i] * wi[0][i] + v->ng[1][i] * wi[1][i] + v->ng[2][i] * wi[2][i];
        scratch->spent[v->slot[i]] = cos_g < 0.0f && rf_starts_at_pane( harvest->path.tracer, v, i ) ? -1 : 0;
    }
    scratch->wavefront.spent = scratch->spent;
}

// Samples scattered directions and traces the rest of the paths.
static void trace_tails( const RfHarvest* harvest, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    const RfVertexLanes* v = scratch->hits;
    RfWavefront* wavefront = &scratch->wavefront;
    float* wi[3] = { scratch->scattered[0], scratch->scattered[1], scratch->scattered[2] };
    rf_scatter_deferred( &harvest->path, wavefront, v, 1, wi );
    int unevaluable = v->count - rf_record_count( v );
    if ( unevaluable > 0 )
        memcpy( scratch->unevaluable_pdf, wavefront->scratch.pdf + rf_record_count( v ), (size_t)unevaluable * sizeof( float ) );
    if ( unevaluable > 0 && rf_tracer_has_panes( harvest->path.tracer ) )
        note_passed_panes( harvest, scratch, wi );
    if ( scratch->tiles != NULL )
    {
        RfTileReuseSettings settings = { &harvest->path, harvest->shape.tile_pixels, harvest->tile_roulette };
        rays->tile += rf_trace_tile_tails( &settings, v, wi, wavefront, scratch->tiles );
    }
    else
        rf_trace_tails( &harvest->path, wavefront, 2 );
}

static void copy_hits( const RfVertexLanes* v, RfHitBatch* batch )
{
    batch->count = rf_record_count( v );
    for ( int k = 0; k <= RF_BSDF_KIND_COUNT; ++k )
        batch->first[k] = v->first[k] < batch->count ? v->first[k] : batch->count;
    size_t bytes = (size_t)batch->count * sizeof( float );
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( batch->p[c], v->p[c], bytes );
        memcpy( batch->ng[c], v->ng[c], bytes );
    }
    int first = v->first[RF_BSDF_FIRST_GLOSSY];
    bytes = (size_t)( batch->count - first ) * sizeof( float );
    if ( bytes == 0 )
        return;
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( batch->n[c], v->n[c] + first, bytes );
        memcpy( batch->wo[c], v->wo[c] + first, bytes );
    }
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
    {
        if ( batch->param[p] != NULL )
            memcpy( batch->param[p], v->param[p] + first, bytes );
    }
}

// Keeps the listed pixels whose tiles are drawn: with the mean of what their pixels need as
// probability. Without tile reuse each pixel is a tile.
static int choose_needy( const RfHarvest* harvest, uint64_t key, int count, int tiles, RfHarvestScratch* scratch )
{
    float need[RF_LANES] = { 0 };
    int32_t size[RF_LANES] = { 0 };
    bool in_tiles = scratch->tiles != NULL;
    for ( int i = 0; i < count; ++i )
    {
        int t = in_tiles ? scratch->tile_of[i] : i;
        need[t] += harvest->need[scratch->pixel[i]];
        size[t] += 1;
    }
    for ( int t = 0; t < ( in_tiles ? tiles : count ); ++t )
    {
        RfRandomKey draw = rf_pixel_key( rf_mix64( key ), (uint32_t)t );
        bool chosen = size[t] > 0 && need[t] / (float)size[t] - (float)harvest->round > rf_random( draw, 0 );
        size[t] = chosen;
    }
    int left = 0;
    for ( int i = 0; i < count; ++i )
    {
        int t = in_tiles ? scratch->tile_of[i] : i;
        scratch->pixel[left] = scratch->pixel[i];
        if ( in_tiles )
            scratch->tile_of[left] = t;
        left += size[t];
    }
    return left;
}

// Follows the camera rays that hit mirrors and glass, if there are any.
static void follow_chains( const RfHarvest* harvest, RfHarvestScratch* scratch )
{
    const RfVertexLanes* first = &scratch->first;
    RfWavefront* wavefront = &scratch->wavefront;
    scratch->hits = first;
    wavefront->spent = NULL;
    if ( scratch->chains == NULL || !rf_has_chains( first ) )
        return;
    rf_follow_chains( &harvest->path, first, &scratch->camera_rays, !harvest->first_hits_only, wavefront, scratch->chains );
    scratch->hits = &scratch->chains->hits;
    wavefront->spent = scratch->chains->length;
    if ( scratch->tiles != NULL )
        rf_split_tiles( scratch->chains, scratch->tiles );
}

static void copy_views( const RfHarvestScratch* scratch, RfHitBatch* batch )
{
    if ( batch->view == NULL )
        return;
    for ( int i = 0; i < batch->count; ++i )
        batch->view[i] = scratch->hits == &scratch->first ? RF_VIEW_DIRECT : scratch->chains->view[scratch->hits->slot[i]];
}

int rf_harvest_first_hits( const RfHarvest* harvest, RfTraceJob job, RfHitBatch* batch, RfHarvestScratch* scratch,
                           RfRayCounts* rays )
{
    const RfEye* eye = harvest->eyes + job.eye;
    RfWavefront* wavefront = &scratch->wavefront;
    uint64_t key =
        rf_pass_key( harvest->seed, (uint32_t)( harvest->first_frame + job.eye ), (uint32_t)harvest->group, (uint32_t)job.pass );
    batch->eye = job.eye;
    wavefront->path_rays = wavefront->shadow_rays = 0;

    int tiles, count = rf_list_patch( &harvest->patches, eye, key, job.job, scratch->pixel, scratch->tile_of, &tiles );
    if ( harvest->need != NULL )
        count = choose_needy( harvest, key, count, tiles, scratch );
    if ( scratch->tiles != NULL )
    {
        memcpy( scratch->tiles->tile_of, scratch->tile_of, (size_t)count * sizeof *scratch->tile_of );
        scratch->tiles->tile_count = tiles;
    }
    make_keys( key, count, scratch->pixel, wavefront );
    make_camera_rays( eye, count, scratch->pixel, wavefront, &scratch->camera_rays );
    rf_find_vertices( &harvest->path, &scratch->camera_rays, true, &scratch->first, &wavefront->scratch );
    rays->primary += (uint64_t)count;
    follow_chains( harvest, scratch );
    copy_hits( scratch->hits, batch );
    copy_views( scratch, batch );
    note_pixels( count, scratch, batch );
    return count;
}

// The weight of the path up to its hit counts in the roulette.
static void scale_roulette( RfHarvestScratch* scratch, int count )
{
    bool chains = scratch->hits != &scratch->first;
    for ( int slot = 0; slot < count; ++slot )
    {
        float most = 1.0f;
        if ( chains )
            most = rf_maxf( scratch->chains->throughput[0][slot],
                            rf_maxf( scratch->chains->throughput[1][slot], scratch->chains->throughput[2][slot] ) );
        scratch->wavefront.roulette_scale[slot] = rf_maxf( most, 0.1f );
    }
}

int rf_harvest_batch( const RfHarvest* harvest, RfTraceJob job, RfHitBatch* batch, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    RfWavefront* wavefront = &scratch->wavefront;
    int count = rf_harvest_first_hits( harvest, job, batch, scratch, rays );

    // the rest of their paths
    memset( &wavefront->arrivals, 0, sizeof wavefront->arrivals );
    wavefront->rays.count = 0;
    scale_roulette( scratch, count );
    bool lit = harvest->path.max_depth > 1 && !harvest->first_hits_only;
    if ( lit )
    {
        sample_direct( harvest, scratch, rays );
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
