// Each batch is harvested as by exact weights and then weighted once for every frame of the group, as if the cameras that count
// there were the ones that saw each hit. For eq15, first hits of the whole pass are traced ahead, to know where they land.
#include "reuse/biased_weights.h"

#include "reuse/accumulate/accumulate.h"
#include "reuse/harvest/harvest_scratch.h"
#include "reuse/harvest/record_weights.h"
#include "reuse/reuse.h"

#include <string.h>

// Of a pass, by eq15.
typedef struct Landed
{
    uint32_t* eyes; // whose hits landed in a pixel: a bit for each, rf_seen_words for each pixel of each frame
    RfHitBatch* hits;
    RfHarvestScratch* scratch;
} Landed;

// Records as they were harvested, and then as each frame of the group weights them: these have directions, light, density_sum and
// rows of their own, and share the rest.
static RfHitBatch** place_batches( const RfBatchShape* shape, RfLayout* layout )
{
    RfHitBatch** batches = rf_take( layout, (size_t)shape->eyes + 1, sizeof *batches );
    for ( int i = 0; i <= shape->eyes; ++i )
    {
        RfHitBatch* hits = rf_place_batch( shape, layout );
        if ( batches != NULL )
            batches[i] = hits;
    }
    return batches;
}

static size_t landed_words( const RfEstimatorGroup* group )
{
    return (size_t)group->width * (size_t)group->height * (size_t)( group->eye_count * rf_seen_words( group->eye_count ) );
}

static Landed* place_landed( const RfEstimatorGroup* group, const RfBatchShape* shape, RfLayout* layout )
{
    Landed* landed = rf_take( layout, 1, sizeof *landed );
    RfHitBatch* hits = rf_place_batch( shape, layout );
    RfHarvestScratch* scratch = rf_place_harvest_scratch( shape, layout );
    RF_PLACE( layout, landed->eyes, landed_words( group ) );
    if ( landed != NULL )
    {
        landed->hits = hits;
        landed->scratch = scratch;
    }
    return landed;
}

static RfResult check( const RfRenderSettings* s, RfError* error )
{
    if ( s->clamp != 0.0 )
        return rf_fail( error, RF_ERROR_USAGE, "a clamp needs exact weights: --weights exact, or --clamp off" );
    if ( ( s->aovs & RF_PASS_AOVS ) != 0 )
        return rf_fail( error, RF_ERROR_USAGE, "the biased weights cannot split light into passes: exact weights, or no passes" );
    if ( s->light_groups != NULL )
        return rf_fail( error, RF_ERROR_USAGE,
                        "the biased weights cannot split light by groups: exact weights, or no light groups" );
    return rf_reuse_estimator.check( s, error );
}

static RfEstimatorSizes sizes( const RfEstimatorGroup* group )
{
    RfEstimatorSizes sizes = rf_reuse_estimator.sizes( group );
    RfReusePlan plan;
    RfLayout batches = { 0 }, landed = { 0 };
    rf_compile_reuse( group, false, &plan );
    place_batches( &plan.shape, &batches );
    if ( group->settings->weights == RF_WEIGHTS_EQ15 )
        place_landed( group, &plan.shape, &landed );
    sizes.batch = batches.bytes;
    sizes.landing = 0;
    sizes.shared = landed.bytes;
    sizes.shared_name = "landed cameras";
    sizes.diffuse_record *= (size_t)group->eye_count + 1;
    sizes.glossy_record *= (size_t)group->eye_count + 1;
    return sizes;
}

static void compile( const RfEstimatorGroup* group, void* out ) { rf_compile_reuse( group, false, out ); }

static void lay_out_batch( const RfEstimatorGroup* group, void* memory )
{
    place_batches( &rf_reuse_plan( group )->shape, &( RfLayout ){ .memory = memory } );
}

static void lay_out_scratch( const RfEstimatorGroup* group, void* memory )
{
    rf_reuse_estimator.lay_out_scratch( group, memory );
}

// Which cameras' hits landed in the pixel of each hit that a camera sees, in words of `landed`; NULL for the others.
static void find_landed( const RfHarvest* at, int eye, const RfHitBatch* hits, uint32_t* landed, uint32_t* words[RF_LANES] )
{
    const RfEye* camera = at->eyes + eye;
    int32_t projected[RF_LANES];
    float density[RF_LANES];
    const int32_t* pixel = eye == hits->eye ? hits->pixel : projected;
    const uint32_t* seen = hits->seen + eye / 32 * RF_LANES;
    size_t each = (size_t)rf_seen_words( at->shape->eyes ), first = (size_t)eye * (size_t)camera->width * (size_t)camera->height;
    if ( eye != hits->eye )
        rf_project_batch( rf_tracer_mirrors( at->path.tracer ), camera, hits,
                          ( RfProjectedLanes ){ .pixel = projected, .density = density } );
    for ( int i = 0; i < hits->count; ++i )
        words[i] = ( seen[i] >> eye % 32 & 1u ) != 0 ? landed + ( first + (size_t)pixel[i] ) * each : NULL;
}

static void prepare( const RfEstimatorGroup* group, int pass, void* memory, RfRayCounts* rays )
{
    RfEstimatorGroup ahead = *group;
    Landed* landed = place_landed( group, &rf_reuse_plan( group )->shape, &( RfLayout ){ .memory = memory } );
    RfRayCounts counts = { 0 };
    ahead.first_hits_only = true;
    ahead.shared = NULL;
    RfHarvest harvest = rf_make_harvest( &ahead );
    memset( landed->eyes, 0, landed_words( group ) * sizeof *landed->eyes );
    rf_set_float_mode();
    for ( int k = 0; k < group->eye_count * harvest.plan->patches.count; ++k )
    {
        RfTraceJob job = { .eye = k / harvest.plan->patches.count, .job = k % harvest.plan->patches.count, .pass = pass };
        uint32_t* words[RF_LANES];
        rf_harvest_batch( &ahead, job, landed->hits, landed->scratch, &counts );
        RfHarvest at = rf_harvest_at( &harvest, job.eye, landed->hits->lens, landed->scratch );
        for ( int eye = 0; eye < group->eye_count; ++eye )
        {
            find_landed( &at, eye, landed->hits, landed->eyes, words );
            for ( int i = 0; i < landed->hits->count; ++i )
            {
                if ( words[i] != NULL )
                    words[i][job.eye / 32] |= 1u << ( job.eye % 32 );
            }
        }
    }
    rays->eye += counts.eye; // camera rays are counted as samples, once
}

// Weights the hits for a frame: by mixtures over the cameras that count there.
static void weight_for( const RfHarvest* at, int eye, const Landed* landed, const RfHitBatch* hits, RfHarvestScratch* scratch,
                        RfHitBatch* out )
{
    RfHitBatch own = *out;
    uint32_t* words[RF_LANES] = { NULL };
    float counted[RF_LANES] = { 0.0f };
    if ( landed != NULL )
        find_landed( at, eye, hits, landed->eyes, words );
    for ( int i = 0; i < at->shape->eyes * hits->count; ++i )
    {
        int l = i / hits->count, k = i % hits->count;
        bool counts = words[k] != NULL ? ( words[k][l / 32] >> l % 32 & 1u ) != 0 : l == hits->eye;
        scratch->density[l * RF_LANES + k] = counts ? 1.0f : 0.0f;
        counted[k] += counts ? 1.0f : 0.0f;
    }
    *out = *hits;
    out->directions = own.directions;
    out->light = own.light;
    out->density_sum = counted;
    out->rows = own.rows;
    memset( own.rows, 0, 2 * (size_t)at->shape->eyes * sizeof *own.rows ); // no camera is left out
    rf_weight_batch( at, out, scratch );
    size_t others = (size_t)( hits->miss_count + hits->glint_count ), first = 4 * (size_t)hits->count;
    memcpy( out->light->radiance + first, hits->light->radiance + first, 4 * others * sizeof( float ) );
    memcpy( own.rows, hits->rows, 2 * (size_t)at->shape->eyes * sizeof *own.rows );
    out->density_sum = own.density_sum;
}

static int trace( const RfEstimatorGroup* group, RfTraceJob job, void* memory, void* workspace, RfRayCounts* rays )
{
    RfHitBatch **batches = memory, *hits = batches[0];
    RfHarvestScratch* scratch = workspace;
    RfEstimatorGroup plain = *group;
    plain.shared = NULL; // no light paths
    int count = rf_harvest_batch( &plain, job, hits, scratch, rays );
    if ( group->first_hits_only )
        return count;
    RfHarvest harvest = rf_make_harvest( &plain );
    RfHarvest at = rf_harvest_at( &harvest, job.eye, hits->lens, scratch );
    // with the density of the frame's camera for the sum of all, accumulation counts each hit once
    for ( int i = 0; i < group->eye_count * hits->count; ++i )
    {
        int eye = i / hits->count, k = i % hits->count;
        float density = scratch->density[eye * RF_LANES + k];
        batches[1 + eye]->density_sum[k] = density > 0.0f ? density : 1.0f;
    }
    for ( int eye = 0; eye < group->eye_count; ++eye )
        weight_for( &at, eye, group->shared, hits, scratch, batches[1 + eye] );
    return count;
}

static bool is_traced( const RfEstimatorGroup* group, RfTraceJob job ) { return rf_reuse_estimator.is_traced( group, job ); }

static RfFirstHits first_hits( const void* scratch ) { return rf_reuse_estimator.first_hits( scratch ); }

static uint64_t accumulate( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                            void* scratch )
{
    uint64_t landed = 0;
    for ( int k = 0; k < batch_count; ++k )
    {
        void* of_frame = ( (RfHitBatch**)batches[k] )[1 + job.eye];
        landed += rf_accumulate_rows( group, job, &of_frame, 1, scratch );
    }
    return landed;
}

static void count_reuse( const RfEstimatorGroup* group, int eye, void* batch, void* scratch, RfReuseCount* count )
{
    rf_reuse_estimator.count_reuse( group, eye, *(RfHitBatch**)batch, scratch, count );
}

const RfEstimator rf_biased_estimator = {
    .name = "reuse",
    .films = 1,
    .tile = { RF_TILE_BLOCK, 3, 3 },
    .filters = true,
    .has_alpha = true,
    .has_features = true,
    .has_covering = true,
    .clamps = true, // but check refuses it, as the next
    .splits_light = true,
    .biased = true,
    .other_weights = &rf_reuse_estimator,
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
    .count_reuse = count_reuse,
};
