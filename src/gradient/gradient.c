// The table entry of gradient-domain path reusing (render/estimator.h).
#include "gradient/gradient.h"

#include "gradient/films.h"

static bool is_tile( const RfTile* tile )
{
    int w = tile->width, h = tile->height;
    bool is_block = tile->kind == RF_TILE_BLOCK && w >= 2 && h >= 2 && w <= RF_MAX_TILE_SIDE && h <= RF_MAX_TILE_SIDE;
    return tile->kind == RF_TILE_NONE || is_block;
}

static RfResult check( const RfRenderSettings* s, RfError* error )
{
    if ( s->group > 0 )
        return rf_fail( error, RF_ERROR_USAGE,
                        "the estimator 'gradient' reuses no frames, where gradients seldom pay: group 0, not %d", s->group );
    if ( !is_tile( &s->tile ) )
        return rf_fail( error, RF_ERROR_USAGE, "the estimator 'gradient' needs tiles of 1 pixel, or blocks of 2x2 to %dx%d",
                        RF_MAX_TILE_SIDE, RF_MAX_TILE_SIDE );
    if ( s->weights != RF_WEIGHTS_EXACT )
        return rf_fail( error, RF_ERROR_USAGE, "the estimator 'gradient' has exact weights only" );
    if ( s->normalize != RF_NORMALIZE_CROSSFIT )
        return rf_fail( error, RF_ERROR_USAGE, "the estimator 'gradient' has no normalisation to choose" );
    return RF_OK;
}

static RfEstimatorSizes sizes( const RfEstimatorGroup* group )
{
    RfGradientPlan plan;
    RfLayout scratch = { 0 };
    rf_compile_gradients( group, &plan );
    rf_place_gradient_scratch( &plan, &scratch );
    return ( RfEstimatorSizes ){
        .jobs = plan.tiles.patches,
        .compiled = sizeof plan,
        .batch = sizeof( RfGradientBatch ),
        .trace_scratch = scratch.bytes,
        .accumulate_scratch = 64,
        .finish_scratch = rf_finish_gradients_bytes( group->settings, group->width, group->height ),
        .diffuse_record = sizeof( float[4] ),
        .glossy_record = sizeof( float[4] ),
        .directions = 1,
    };
}

static void compile( const RfEstimatorGroup* group, void* out ) { rf_compile_gradients( group, out ); }

static void lay_out_batch( const RfEstimatorGroup* group, void* memory )
{
    (void)group;
    RfGradientBatch* batch = memory;
    batch->tile_count = 0;
}

static void lay_out_scratch( const RfEstimatorGroup* group, void* memory )
{
    rf_place_gradient_scratch( group->compiled, &( RfLayout ){ .memory = memory } );
}

static int trace( const RfEstimatorGroup* group, RfTraceJob job, void* batch, void* scratch, RfRayCounts* rays )
{
    return rf_sample_patch( group, job, batch, scratch, rays );
}

static RfFirstHits first_hits( const void* scratch ) { return rf_first_hits_of_patch( scratch ); }

static uint64_t accumulate( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                            void* scratch )
{
    (void)scratch;
    return rf_accumulate_gradients( group, job, batches, batch_count );
}

const RfEstimator rf_gradient_estimator = {
    .name = "gradient",
    .films = RF_GRADIENT_FILMS,
    .filters = true,
    .draws_by_filter = true,
    .has_gradients = true,
    .has_alpha = true,
    .has_features = true,
    .has_variance = true,
    .usual_passes = 4, // two in each half: their variances are known
    .tile = { RF_TILE_BLOCK, 4, 4 },
    .check = check,
    .sizes = sizes,
    .compile = compile,
    .lay_out_batch = lay_out_batch,
    .lay_out_scratch = lay_out_scratch,
    .trace = trace,
    .first_hits = first_hits,
    .accumulate = accumulate,
    .finish = rf_finish_gradients,
};
