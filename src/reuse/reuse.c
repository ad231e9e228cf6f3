// The table entry of frame and tile reuse (render/estimator.h).
#include "reuse/reuse.h"

#include "reuse/accumulate/accumulate.h"
#include "reuse/project.h"
#include "reuse/biased_weights.h"
#include "reuse/harvest/connection_share.h"
#include "reuse/harvest/glints.h"
#include "reuse/harvest/camera_rays.h"
#include "reuse/harvest/visibility.h"
#include "reuse/tile_pilot.h"

static RfResult check( const RfRenderSettings* s, RfError* error )
{
    if ( !rf_is_tile( &s->tile ) )
        return rf_fail( error, RF_ERROR_USAGE, "tiles must have 1 to %d pixels, and rooks a square grid", RF_MAX_TILE_PIXELS );
    return RF_OK;
}

static size_t batch_bytes( const RfBatchShape* shape )
{
    RfLayout layout = { 0 };
    rf_place_batch( shape, &layout );
    return layout.bytes;
}

// Of one hit.
static size_t record_bytes( const RfBatchShape* shape )
{
    return ( batch_bytes( shape ) - rf_piece_bytes( sizeof( RfHitBatch ) ) + RF_LANES - 1 ) / RF_LANES;
}

// What all batches of a pass share: light paths, and what their share is chosen in.
static RfLightPaths* place_shared( const RfEstimatorGroup* group, const RfBatchShape* shape, RfLayout* layout, RfPilot** pilot )
{
    RfLightPaths* paths = rf_place_light_paths( group, layout );
    *pilot = rf_place_pilot( group, shape, layout );
    return paths;
}

static RfEstimatorSizes sizes( const RfEstimatorGroup* group )
{
    RfReusePlan plan;
    rf_compile_reuse( group, false, &plan );
    const RfBatchShape* shape = &plan.shape;
    RfBatchShape diffuse = *shape;
    RfLayout scratch = { 0 }, shared = { 0 }, accumulation = { 0 }, landing = { 0 }, tile_pilot = { 0 };
    RfPilot* pilot;
    diffuse.params = 0;
    rf_place_harvest_scratch( shape, &scratch );
    rf_place_accumulation( &plan, &accumulation );
    rf_place_landing( &plan, &landing );
    rf_place_tile_pilot( &plan, &tile_pilot );
    if ( shape->connections )
        place_shared( group, shape, &shared, &pilot );
    return ( RfEstimatorSizes ){
        .jobs = plan.patches.count,
        .compiled = sizeof plan,
        .batch = batch_bytes( shape ),
        .trace_scratch = scratch.bytes,
        .accumulate_scratch = accumulation.bytes,
        .landing = landing.bytes,
        .tile_pilot = tile_pilot.bytes,
        .shared = shared.bytes,
        .shared_name = "light paths",
        .splits = shape->own_light && !shape->caustics,
        .diffuse_record = record_bytes( &diffuse ),
        .glossy_record = record_bytes( shape ),
        .directions = rf_direction_count( shape ),
    };
}

static void compile( const RfEstimatorGroup* group, void* out ) { rf_compile_reuse( group, false, out ); }

static void lay_out_batch( const RfEstimatorGroup* group, void* memory )
{
    rf_place_batch( &rf_reuse_plan( group )->shape, &( RfLayout ){ .memory = memory } );
}

static void lay_out_scratch( const RfEstimatorGroup* group, void* memory )
{
    rf_place_harvest_scratch( &rf_reuse_plan( group )->shape, &( RfLayout ){ .memory = memory } );
}

static int trace( const RfEstimatorGroup* group, RfTraceJob job, void* batch, void* scratch, RfRayCounts* rays )
{
    return rf_harvest_batch( group, job, batch, scratch, rays );
}

static void prepare( const RfEstimatorGroup* group, int pass, void* shared, RfRayCounts* rays )
{
    RfLightPaths* paths = shared;
    if ( paths->share_of != group->number + 1 )
    {
        RfPilot* pilot;
        place_shared( group, &rf_reuse_plan( group )->shape, &( RfLayout ){ .memory = shared }, &pilot );
        rf_choose_connection_share( group, paths, pilot, rays );
    }
    paths->share_of = group->number + 1;
    if ( rf_drawn_light_paths( paths ) == NULL )
        return;
    rf_draw_light_paths( group, pass, shared );
    rays->path += paths->rays;
}

static bool is_traced( const RfEstimatorGroup* group, RfTraceJob job )
{
    RfHarvest harvest = rf_make_harvest( group );
    return rf_is_patch_traced( &harvest, job );
}

static RfFirstHits first_hits( const void* memory )
{
    const RfHarvestScratch* scratch = memory;
    return ( RfFirstHits ){ .hits = &scratch->first,
                            .rays = &scratch->camera_rays,
                            .surfaces = scratch->surfaces,
                            .pixel = scratch->pixel,
                            .place = { scratch->place[0], scratch->place[1] },
                            .features = scratch->features,
                            .path_rays = scratch->wavefront.rays_of };
}

static uint64_t accumulate( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                            void* scratch )
{
    return rf_accumulate_rows( group, job, batches, batch_count, scratch );
}

static void land( const RfEstimatorGroup* group, RfAccumulateJob job, const void* batch, void* scratch, void* landing )
{
    rf_land_batch( group, job, batch, scratch, landing );
}

// Camera rays that hit something but have no record: they are listed behind those that missed.
static int own_frame_hits( const RfHitBatch* batch, const RfHarvestScratch* scratch )
{
    return batch->miss_count - scratch->ray_miss_count;
}

// The share of hit i that no other frame helps with: of the light that holds in the group, `share`, the weight of its own
// frame; of own-frame light, all.
static double unhelped( const RfHarvestScratch* scratch, double share, int i )
{
    return scratch->own != NULL ? share + ( 1.0 - share ) * (double)scratch->own->part[i] : share;
}

static void add_own_shares( const void* batch_memory, const void* scratch_memory, float* sum )
{
    const RfHitBatch* batch = batch_memory;
    const RfHarvestScratch* scratch = scratch_memory;
    const float* own = scratch->density + (size_t)batch->eye * RF_LANES;
    for ( int i = 0; i < batch->count; ++i )
        sum[batch->pixel[i]] += (float)unhelped( scratch, (double)rf_mixture_share( own[i], batch->density_sum[i] ), i );
    int hits = own_frame_hits( batch, scratch ), base = batch->miss_count - hits;
    for ( int i = 0; i < hits; ++i )
        sum[rf_miss_pixel( batch )[base + i]] += 1.0f;
}

static uint64_t count_samples( const void* memory, float weight, float* sum )
{
    const RfHitBatch* batch = memory;
    int all = batch->count + batch->miss_count;
    for ( int k = 0; k < all; ++k )
        sum[batch->pixel[k]] += weight;
    return (uint64_t)all;
}

static void add_glints( const RfEstimatorGroup* group, int block, void* scratch, float* sums, RfRayCounts* rays )
{
    RfHarvest harvest = rf_make_harvest( group );
    rf_add_glints( &harvest, block, sums, scratch, rays );
}

static void count_reuse( const RfEstimatorGroup* group, int eye, void* batch_memory, void* scratch_memory, RfReuseCount* count )
{
    RfHitBatch* batch = batch_memory;
    RfHarvestScratch* scratch = scratch_memory;
    RfHarvest harvest = rf_make_harvest( group );
    RfRayCounts rays = { 0 };
    batch->eye = eye;
    harvest = rf_harvest_at( &harvest, eye, batch->lens, scratch );
    rf_test_batch_visibility( &harvest, batch, scratch, &rays );
    const float* own = scratch->density + (size_t)eye * RF_LANES;
    double share = 0.0;
    for ( int i = 0; i < batch->count; ++i )
        share += unhelped( scratch, (double)own[i] / (double)batch->density_sum[i], i );
    count->hits += scratch->first.count;
    count->glossy += rf_glossy_count( batch );
    count->own_share += share + own_frame_hits( batch, scratch );
    count->eye_rays += (double)rays.eye;
}

const int rf_tile_sides[RF_TILE_CHOICES] = { 1, 2, 3, 4, 6, 8 };

static void count_tiles( const RfEstimatorGroup* group, void* batch, void* scratch, void* memory, RfTileCount* count )
{
    RfTilePilot* pilot = rf_place_tile_pilot( rf_reuse_plan( group ), &( RfLayout ){ .memory = memory } );
    if ( count == NULL )
        rf_begin_tile_pair( group, batch, scratch, pilot );
    else
        rf_end_tile_pair( group, batch, scratch, pilot, count );
}

const RfEstimator rf_reuse_estimator = {
    .name = "reuse",
    .films = 1,
    .tile = { RF_TILE_BLOCK, 3, 3 },
    .filters = true,
    .has_alpha = true,
    .has_features = true,
    .has_covering = true,
    .clamps = true,
    .guides = true,
    .splits_light = true,
    .other_weights = &rf_biased_estimator,
    .check = check,
    .sizes = sizes,
    .compile = compile,
    .lay_out_batch = lay_out_batch,
    .lay_out_scratch = lay_out_scratch,
    .prepare = prepare,
    .trace = trace,
    .is_traced = is_traced,
    .first_hits = first_hits,
    .accumulate = accumulate,
    .land = land,
    .add_landings = rf_add_landings,
    .add_own_shares = add_own_shares,
    .count_samples = count_samples,
    .add_glints = add_glints,
    .count_reuse = count_reuse,
    .count_tiles = count_tiles,
};
