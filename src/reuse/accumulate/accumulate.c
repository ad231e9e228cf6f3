// From hit records to the films of a frame: where hits land, their MIS weights (E1), their light in each film, pixels.
#include "reuse/accumulate/accumulate.h"

#include "base/fault.h"
#include "path/mis.h"

#include <string.h>

typedef struct Scratch
{
    RfProjectedHits at;
    RfHitLights* lights;
    RfLandedHits* landing; // of rf_accumulate_rows
} Scratch;

// What all batches of a call share.
typedef struct Accumulation
{
    const RfReusePlan* plan;
    const RfEye* eyes;
    int eye; // of the films, in the group
    const RfMirrors* mirrors;
    const RfLights* lights; // of the films' frame
    RfSplat splat;
} Accumulation;

RfLandedHits* rf_place_landing( const RfReusePlan* plan, RfLayout* layout )
{
    return rf_place_landed_hits( plan->film_count, plan->shape.filtered, rf_has_covering( &plan->shape ), layout );
}

static Scratch* place_scratch( const RfReusePlan* plan, RfLayout* layout )
{
    Scratch* scratch = rf_take( layout, 1, sizeof *scratch );
    for ( int c = 0; c < 2; ++c )
        RF_PLACE( layout, scratch->at.offset[c], plan->shape.filtered ? RF_LANES : 0 );
    RfHitLights* lights = rf_place_hit_lights( &plan->shape, layout );
    RfLandedHits* landing = rf_place_landing( plan, layout );
    if ( scratch != NULL )
    {
        scratch->lights = lights;
        scratch->landing = landing;
    }
    return scratch;
}

void rf_place_accumulation( const RfReusePlan* plan, RfLayout* layout ) { place_scratch( plan, layout ); }

// The film of a job that is made of these layers.
static RfFilm* film_of( const RfEstimatorGroup* group, RfAccumulateJob job, RfFilmLayers layers )
{
    if ( layers.removed )
        return job.films + 1;
    if ( layers.base != RF_ALL )
        return job.groups != NULL ? job.groups + rf_group_of_part( layers.base, rf_reuse_plan( group )->shape.groups ) : NULL;
    if ( layers.kind == RF_ALL )
        return job.films;
    unsigned before = group->settings->aovs & RF_PASS_AOVS & ( RF_AOV_BIT( RF_AOV_EMISSION + layers.kind ) - 1 );
    return job.passes != NULL ? job.passes + __builtin_popcount( before ) : NULL;
}

// Where own-frame light has sums of its own, they get the glints of groups and the count of own samples, but not extra ones.
static RfSplat make_splat( const RfEstimatorGroup* group, RfAccumulateJob job )
{
    const RfReusePlan* plan = rf_reuse_plan( group );
    bool extra = group->need != NULL;
    RfSplat out = {
        .count = plan->film_count,
        .half = job.half,
        .splits = plan->shape.own_light,
        .filter = extra ? NULL : group->filter,
        .width = group->width,
        .height = group->height,
        .low = job.first_row * group->width,
        .end = job.end_row * group->width,
        .weight = job.weight,
        .counted = extra ? NULL : rf_film_own( job.films, job.half ),
        .sky = job.sky,
        .covering = job.covering,
        .landed = job.landed,
    };
    for ( int k = 0; k < out.count; ++k )
        out.films[k] = ( RfSplatFilm ){ plan->films[k], film_of( group, job, plan->films[k] ) };
    return out;
}

static Accumulation make_accumulation( const RfEstimatorGroup* group, RfAccumulateJob job )
{
    return ( Accumulation ){
        .plan = rf_reuse_plan( group ),
        .eyes = group->eyes,
        .eye = job.eye,
        .mirrors = rf_tracer_mirrors( group->tracer ),
        .lights = rf_tracer_lights( rf_group_tracer( group, job.eye ) ),
        .splat = make_splat( group, job ),
    };
}

static bool reaches_rows( const Accumulation* a, const RfHitBatch* batch )
{
    const RfSplat* s = &a->splat;
    int beyond = rf_has_filter( s->filter ) ? s->filter->reach : 0, low = batch->rows[2 * a->eye],
        high = batch->rows[2 * a->eye + 1];
    return low <= high && ( low - beyond ) * s->width < s->end && ( high + beyond + 1 ) * s->width > s->low;
}

// Times κ of the panes on the way to the frame's camera.
static void dim_by_panes( const RfHitBatch* batch, int eye, float* const filter[3] )
{
    for ( int c = 0; c < 3 && batch->panes[c] != NULL; ++c )
    {
        const float* kappa = batch->panes[c] + (size_t)eye * RF_LANES;
        for ( int i = 0; i < batch->count; ++i )
            filter[c][i] *= kappa[i];
    }
}

// Keeps the hits of a batch that land in the frame, `sorted` into bins of pixels unless a filter spreads them.
static void land( const Accumulation* a, const RfHitBatch* batch, bool sorted, Scratch* scratch, RfLandedHits* landing )
{
    const RfSplat* splat = &a->splat;
    RfProjectedHits* at = &scratch->at;
    bool own = a->eye == batch->eye, spreads = rf_has_filter( splat->filter );

    // ---- the frame's camera, at the batch's point of the lens and moment of the shutter
    const RfEye* of_frame = a->eyes + a->eye;
    RfEye eye = rf_is_blurred_shape( &a->plan->shape ) ? rf_sample_eye( of_frame, batch->lens ) : *of_frame;

    // ---- where the hits are seen, and their densities J_t V_t: in their own frame as they were sampled
    float* restrict ratio = at->ratio;
    RfProjectedLanes seen_at = { .pixel = at->pixel,
                                 .density = ratio,
                                 .filter = { at->filter[0], at->filter[1], at->filter[2] },
                                 .offset = { spreads ? at->offset[0] : NULL, spreads ? at->offset[1] : NULL } };
    for ( int c = 0; c < 2 && own && spreads; ++c )
        memcpy( seen_at.offset[c], batch->offset[c], (size_t)batch->count * sizeof( float ) );
    if ( own )
    {
        memcpy( seen_at.pixel, batch->pixel, (size_t)batch->count * sizeof *seen_at.pixel );
        rf_own_densities( a->mirrors, &eye, batch, seen_at );
    }
    else
        rf_project_batch( a->mirrors, &eye, batch, seen_at );
    if ( batch->densities != NULL )
        memcpy( ratio, batch->densities + (size_t)a->eye * RF_LANES, (size_t)batch->count * sizeof *ratio );
    dim_by_panes( batch, a->eye, seen_at.filter );

    // ---- MIS weights r_t = J_t V_t / Σ J_l V_l, times that of the pass (E1)
    const float* restrict sum = batch->density_sum;
    const uint32_t* restrict seen = batch->seen + ( a->eye / 32 ) * RF_LANES;
    uint32_t bit = 1u << ( a->eye % 32 );
    float weight = splat->weight;
#pragma omp simd
    for ( int i = 0; i < batch->count; ++i )
    {
        float all = RF_FAULT( normalised_frames ) ? sum[i] + ratio[i] : sum[i];
        ratio[i] = ( seen[i] & bit ) != 0 ? weight * rf_mixture_share( ratio[i], all ) : 0.0f;
    }
    rf_note_weights( ratio, batch->count, weight );

    // ---- the light of all layers towards the camera
    rf_light_hits( a->lights, a->mirrors, &eye, a->eye, batch, scratch->lights );

    // ---- the hits that land, and their light in each film, which is a sum of layers
    int16_t order[RF_LANES];
    rf_list_landing( batch, a->eye, at, sorted && !spreads, order, landing );
    for ( int k = 0; k < splat->count; ++k )
    {
        RfFilmLayers film = splat->films[k].layers;
        landing->lit[k] = splat->films[k].film != NULL && rf_film_is_lit( &a->plan->shape, batch, film, a->eye );
        if ( landing->lit[k] )
            rf_keep_light( batch, at, rf_film_light( batch, film, scratch->lights ), order, k, landing );
    }
}

uint64_t rf_accumulate_rows( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                             void* memory )
{
    const Accumulation a = make_accumulation( group, job );
    Scratch* scratch = place_scratch( a.plan, &( RfLayout ){ .memory = memory } );
    uint64_t landed = 0;
    for ( int k = 0; k < batch_count; ++k )
    {
        const RfHitBatch* batch = batches[k];
        if ( !reaches_rows( &a, batch ) )
            continue;
        land( &a, batch, false, scratch, scratch->landing );
        landed += rf_splat( &a.splat, batch, job.eye == batch->eye, scratch->landing );
    }
    return landed;
}

void rf_land_batch( const RfEstimatorGroup* group, RfAccumulateJob job, const RfHitBatch* batch, void* memory, void* landing )
{
    const Accumulation a = make_accumulation( group, job );
    Scratch* scratch = place_scratch( a.plan, &( RfLayout ){ .memory = memory } );
    RfLandedHits* hits = rf_place_landing( a.plan, &( RfLayout ){ .memory = landing } );
    if ( reaches_rows( &a, batch ) )
        land( &a, batch, true, scratch, hits );
}

uint64_t rf_add_landings( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, void* const* landings,
                          int batch_count )
{
    const Accumulation a = make_accumulation( group, job );
    uint64_t landed = 0;
    for ( int k = 0; k < batch_count; ++k )
    {
        const RfHitBatch* batch = batches[k];
        if ( reaches_rows( &a, batch ) )
            landed += rf_splat( &a.splat, batch, job.eye == batch->eye, landings[k] );
    }
    return landed;
}
