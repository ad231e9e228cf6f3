// Adds hit records to films: projects them to the frame's camera, weights them (E1), lights them and adds them to pixels.
#include "reuse/accumulate/accumulate.h"

#include "base/fault.h"
#include "path/mis.h"
#include "reuse/accumulate/splat.h"
#include "reuse/harvest/harvest.h"
#include "scene/lens.h"

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
    RfBatchShape shape;
    const RfEye* eyes;
    int eye; // of the films, in the group
    const RfMirrors* mirrors;
    const RfLights* lights; // of the films' frame
    RfSplat splat;
    Scratch* scratch; // NULL where landings are added
} Accumulation;

static RfLandedHits* place_landing( const RfEstimatorGroup* group, const RfBatchShape* shape, RfLayout* layout )
{
    RfFilmLayers films[RF_FRAME_FILMS_MOST];
    int count = rf_list_film_layers( shape, group->settings->aovs, films );
    return rf_place_landing( count, shape->filtered, rf_has_covering( shape ), layout );
}

static Scratch* place_scratch( const RfEstimatorGroup* group, const RfBatchShape* shape, RfLayout* layout )
{
    Scratch* scratch = rf_take( layout, 1, sizeof *scratch );
    for ( int c = 0; c < 2; ++c )
        RF_PLACE( layout, scratch->at.offset[c], shape->filtered ? RF_LANES : 0 );
    RfHitLights* lights = rf_place_hit_lights( shape, layout );
    RfLandedHits* landing = place_landing( group, shape, layout );
    if ( scratch != NULL )
    {
        scratch->lights = lights;
        scratch->landing = landing;
    }
    return scratch;
}

size_t rf_accumulate_scratch_bytes( const RfEstimatorGroup* group )
{
    RfBatchShape shape = rf_batch_shape( group );
    RfLayout layout = { 0 };
    place_scratch( group, &shape, &layout );
    return layout.bytes;
}

size_t rf_landing_bytes( const RfEstimatorGroup* group )
{
    RfBatchShape shape = rf_batch_shape( group );
    RfLayout layout = { 0 };
    place_landing( group, &shape, &layout );
    return layout.bytes;
}

// The film of a job that is made of these layers.
static RfFilm* film_of( const RfEstimatorGroup* group, const RfBatchShape* shape, RfAccumulateJob job, RfFilmLayers layers )
{
    if ( layers.removed )
        return job.films + 1;
    if ( layers.base != RF_ALL )
        return job.groups != NULL ? job.groups + rf_group_of_part( layers.base, shape->groups ) : NULL;
    if ( layers.kind == RF_ALL )
        return job.films;
    unsigned before = group->settings->aovs & RF_PASS_AOVS & ( RF_AOV_BIT( RF_AOV_EMISSION + layers.kind ) - 1 );
    return job.passes != NULL ? job.passes + __builtin_popcount( before ) : NULL;
}

// Where own-frame light has sums of its own, they get the glints of groups and the count of own samples, but not extra ones.
static RfSplat make_splat( const RfEstimatorGroup* group, const RfBatchShape* shape, RfAccumulateJob job )
{
    bool extra = group->need != NULL;
    RfFilmLayers films[RF_FRAME_FILMS_MOST];
    RfSplat out = {
        .half = job.half,
        .splits = shape->own_light,
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
    out.count = rf_list_film_layers( shape, group->settings->aovs, films );
    for ( int k = 0; k < out.count; ++k )
    {
        out.films[k].layers = films[k];
        out.films[k].film = film_of( group, shape, job, films[k] );
    }
    return out;
}

static Accumulation make_accumulation( const RfEstimatorGroup* group, RfAccumulateJob job )
{
    Accumulation out = {
        .shape = rf_batch_shape( group ),
        .eyes = group->eyes,
        .eye = job.eye,
        .mirrors = rf_tracer_mirrors( group->tracer ),
        .lights = rf_tracer_lights( group->tracers != NULL ? group->tracers[job.eye] : group->tracer ),
    };
    out.splat = make_splat( group, &out.shape, job );
    return out;
}

static bool reaches_rows( const Accumulation* a, const RfHitBatch* batch )
{
    const RfSplat* s = &a->splat;
    int beyond = rf_has_filter( s->filter ) ? s->filter->reach : 0, low = batch->rows[2 * a->eye],
        high = batch->rows[2 * a->eye + 1];
    return low <= high && ( low - beyond ) * s->width < s->end && ( high + beyond + 1 ) * s->width > s->low;
}

// Pixels of the hits at the camera, and their weights r_t = J_t V_t / Σ J_l V_l times that of the pass (E1).
static void reproject( const Accumulation* a, const RfEye* eye, const RfHitBatch* batch, RfProjectedHits* at )
{
    float weight = a->splat.weight, *restrict ratio = at->ratio;
    bool own = a->eye == batch->eye, spreads = rf_has_filter( a->splat.filter );
    RfProjectedLanes out = { .pixel = at->pixel,
                             .density = ratio,
                             .filter = { at->filter[0], at->filter[1], at->filter[2] },
                             .offset = { spreads ? at->offset[0] : NULL, spreads ? at->offset[1] : NULL } };
    for ( int c = 0; c < 2 && own && spreads; ++c )
        memcpy( out.offset[c], batch->offset[c], (size_t)batch->count * sizeof( float ) );
    if ( own )
    {
        memcpy( out.pixel, batch->pixel, (size_t)batch->count * sizeof *out.pixel );
        rf_own_densities( a->mirrors, eye, batch, out );
    }
    else
        rf_project_batch( a->mirrors, eye, batch, out );
    if ( batch->densities != NULL )
        memcpy( ratio, batch->densities + (size_t)a->eye * RF_LANES, (size_t)batch->count * sizeof *ratio );
    for ( int c = 0; c < 3 && batch->panes[c] != NULL; ++c )
    {
        const float* kappa = batch->panes[c] + (size_t)a->eye * RF_LANES;
        for ( int i = 0; i < batch->count; ++i )
            out.filter[c][i] *= kappa[i];
    }
    const float* restrict sum = batch->density_sum;
    const uint32_t* restrict seen = batch->seen + ( a->eye / 32 ) * RF_LANES;
    uint32_t bit = 1u << ( a->eye % 32 );
#pragma omp simd
    for ( int i = 0; i < batch->count; ++i )
    {
        float all = RF_FAULT( normalised_frames ) ? sum[i] + ratio[i] : sum[i];
        ratio[i] = ( seen[i] & bit ) != 0 ? weight * rf_mixture_share( ratio[i], all ) : 0.0f;
    }
    rf_note_weights( ratio, batch->count, weight );
}

// Projects and lights the hits of a batch, and keeps those that land; `sorted` into bins, unless a filter spreads them.
static void land( const Accumulation* a, const RfHitBatch* batch, bool sorted, RfLandedHits* landing )
{
    // camera of the group, at the batch's point of the lens and moment of the shutter
    RfEye eye = rf_is_blurred_shape( &a->shape ) ? rf_sample_eye( a->eyes + a->eye, batch->lens ) : a->eyes[a->eye];
    const RfSplat* s = &a->splat;
    Scratch* scratch = a->scratch;
    int16_t order[RF_LANES];
    reproject( a, &eye, batch, &scratch->at );
    rf_light_hits( a->lights, a->mirrors, &eye, a->eye, batch, scratch->lights );
    rf_list_landing( batch, a->eye, &scratch->at, sorted && !rf_has_filter( s->filter ), order, landing );
    for ( int k = 0; k < s->count; ++k )
    {
        landing->lit[k] = false;
        if ( s->films[k].film != NULL && rf_film_is_lit( &a->shape, batch, s->films[k].layers, a->eye ) )
            rf_keep_light( batch, &scratch->at, rf_film_light( batch, s->films[k].layers, scratch->lights ), order, k, landing );
    }
}

uint64_t rf_accumulate_rows( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                             void* memory )
{
    Accumulation a = make_accumulation( group, job );
    a.scratch = place_scratch( group, &a.shape, &( RfLayout ){ .memory = memory } );
    uint64_t landed = 0;
    for ( int k = 0; k < batch_count; ++k )
    {
        const RfHitBatch* batch = batches[k];
        if ( !reaches_rows( &a, batch ) )
            continue;
        land( &a, batch, false, a.scratch->landing );
        landed += rf_splat( &a.splat, batch, job.eye == batch->eye, a.scratch->landing );
    }
    return landed;
}

void rf_land_batch( const RfEstimatorGroup* group, RfAccumulateJob job, const RfHitBatch* batch, void* memory, void* landing )
{
    Accumulation a = make_accumulation( group, job );
    a.scratch = place_scratch( group, &a.shape, &( RfLayout ){ .memory = memory } );
    RfLandedHits* hits = place_landing( group, &a.shape, &( RfLayout ){ .memory = landing } );
    if ( reaches_rows( &a, batch ) )
        land( &a, batch, true, hits );
}

uint64_t rf_add_landings( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, void* const* landings,
                          int batch_count )
{
    Accumulation a = make_accumulation( group, job );
    uint64_t landed = 0;
    for ( int k = 0; k < batch_count; ++k )
    {
        const RfHitBatch* batch = batches[k];
        if ( reaches_rows( &a, batch ) )
            landed += rf_splat( &a.splat, batch, job.eye == batch->eye, landings[k] );
    }
    return landed;
}
