#include "reuse/accumulate.h"

#include "reuse/glossy.h"
#include "reuse/harvest.h"
#include "reuse/reprojection.h"
#include "reuse/splat.h"
#include "reuse/spread.h"
#include "reuse/weight_range.h"
#include "scene/lens.h"

#include <string.h>

// What all batches of a call share.
typedef struct Accumulation
{
    const RfEye* eyes;
    const RfMirrors* mirrors;
    RfBatchShape shape;
    RfWeights weights;
    const RfPixelFilter* filter; // by which samples are spread; NULL: each counts in its own pixel
    float weight;                // of the pass in the film
    void* const* batches;        // RfHitBatch, in the order in which they add to the film
    int batch_count;
} Accumulation;

static RfEye eye_of( const Accumulation* a, int eye, const RfHitBatch* batch )
{
    return rf_is_blurred_shape( &a->shape ) ? rf_sample_eye( a->eyes + eye, batch->lens ) : a->eyes[eye];
}

// Pixels of the hits at an eye, and their weights r_t = J_t V_t / Σ J_l V_l times `weight` (E1).
static void reprojection_weights( const Accumulation* a, int eye_index, const RfHitBatch* batch, RfAccumulateScratch* scratch )
{
    RfEye at = eye_of( a, eye_index, batch );
    const RfEye* eye = &at;
    float weight = a->weight, *restrict ratio = scratch->ratio,
          *filter[3] = { scratch->filter[0], scratch->filter[1], scratch->filter[2] };
    int32_t* pixel = scratch->pixel;
    float* offset[2] = { scratch->offset[0], scratch->offset[1] };
    bool own = eye_index == batch->eye;
    for ( int c = 0; c < 2 && own && rf_has_filter( a->filter ); ++c )
        memcpy( offset[c], batch->offset[c], (size_t)batch->count * sizeof( float ) );
    if ( own )
    {
        memcpy( pixel, batch->pixel, (size_t)batch->count * sizeof *pixel );
        rf_own_densities( a->mirrors, eye, batch, ratio, filter );
    }
    else
        rf_project_batch( a->mirrors, eye, batch, pixel, ratio, filter, rf_has_filter( a->filter ) ? offset : NULL );
    if ( batch->densities != NULL )
        memcpy( ratio, batch->densities + (size_t)eye_index * RF_LANES, (size_t)batch->count * sizeof *ratio );
    for ( int c = 0; c < 3 && batch->panes[c] != NULL; ++c )
    {
        const float* kappa = batch->panes[c] + (size_t)eye_index * RF_LANES;
        for ( int i = 0; i < batch->count; ++i )
            filter[c][i] *= kappa[i];
    }
    const float* restrict sum = batch->density_sum;
    const uint32_t* restrict seen = batch->seen + ( eye_index / 32 ) * RF_LANES;
    uint32_t bit = 1u << ( eye_index % 32 );
#pragma omp simd
    for ( int i = 0; i < batch->count; ++i )
        ratio[i] = ( seen[i] & bit ) != 0 ? weight * ( ratio[i] / sum[i] ) : 0.0f;
    rf_note_weights( ratio, batch->count, weight );
}

static void reproject( const Accumulation* a, int eye, const RfHitBatch* batch, RfAccumulateScratch* scratch )
{
    reprojection_weights( a, eye, batch, scratch );
    if ( a->weights == RF_WEIGHTS_EXACT )
        return;
    // the biased weightings count each hit once
    for ( int i = 0; i < batch->count; ++i )
        scratch->ratio[i] = scratch->ratio[i] > 0.0f ? a->weight : 0.0f;
}

// Mean density over the eyes whose hits landed in the pixel: FR (15).
static void mix_landed_eyes( const Accumulation* a, const RfHitBatch* batch, const uint32_t* landed_eyes, int direction,
                             RfAccumulateScratch* s )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = rf_glossy_count( batch );
    int words = rf_seen_words( a->shape.eyes );
    const RfDirectionLanes* lanes = batch->directions + direction;
    const float* wi[3] = { lanes->wi[0], lanes->wi[1], lanes->wi[2] };
    float* wo[3] = { s->wo[0], s->wo[1], s->wo[2] };
    const float* wo_in[3] = { wo[0], wo[1], wo[2] };
    int32_t landed[RF_LANES] = { 0 };
    memset( s->mixture, 0, sizeof s->mixture );
    for ( int l = 0; l < a->shape.eyes; ++l )
    {
        RfEye at = eye_of( a, l, batch );
        rf_directions_to( a->mirrors, &at, l, batch, wo );
        rf_evaluate_glossy( batch, wo_in, wi, NULL, s->pdf );
        for ( int i = 0; i < count; ++i )
        {
            uint32_t word = landed_eyes[(size_t)s->pixel[first + i] * (size_t)words + (size_t)( l / 32 )];
            int there = word >> ( l % 32 ) & 1u;
            s->mixture[i] += there ? s->pdf[i] : 0.0f;
            landed[i] += there;
        }
    }
    for ( int i = 0; i < count; ++i )
        s->mixture[i] /= (float)( landed[i] > 0 ? landed[i] : 1 );
}

// sum += f Q of one direction; for eq15, Q depends on the mixture density of the pixel.
static void add_direction( const RfDirectionLanes* lanes, int count, bool eq15, RfAccumulateScratch* s )
{
    for ( int c = 0; c < 3; ++c )
    {
        float* restrict sum = s->sum[c];
        const float* restrict f = s->f[c];
        const float* restrict q = lanes->q[c];
        if ( !eq15 )
        {
#pragma omp simd
            for ( int i = 0; i < count; ++i )
                sum[i] += f[i] * q[i];
            continue;
        }
        for ( int i = 0; i < count; ++i )
        {
            float p = s->mixture[i], both = lanes->light_pdf[i] + p;
            sum[i] += f[i] * ( ( both > 0.0f ? lanes->a[c][i] / both : 0.0f ) + ( p > 0.0f ? lanes->b[c][i] / p : 0.0f ) );
        }
    }
}

// Radiance of the glossy hits towards the eye, into sum.
static void light_glossy( const Accumulation* a, int eye, const RfHitBatch* batch, const uint32_t* landed_eyes,
                          RfAccumulateScratch* s )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = rf_glossy_count( batch );
    float* wo[3] = { s->wo[0], s->wo[1], s->wo[2] };
    const float* wo_in[3] = { wo[0], wo[1], wo[2] };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    for ( int i = 0; i < count; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            s->sum[c][i] = batch->radiance[4 * ( first + i ) + c];
    }
    RfEye at = eye_of( a, eye, batch );
    if ( !a->shape.eq15 )
        rf_directions_to( a->mirrors, &at, eye, batch, wo );
    for ( int d = 0; d < rf_direction_count( &a->shape ); ++d )
    {
        const RfDirectionLanes* lanes = batch->directions + d;
        const float* wi[3] = { lanes->wi[0], lanes->wi[1], lanes->wi[2] };
        if ( a->shape.eq15 )
        {
            mix_landed_eyes( a, batch, landed_eyes, d, s );
            rf_directions_to( a->mirrors, &at, eye, batch, wo );
        }
        rf_evaluate_glossy( batch, wo_in, wi, f, NULL );
        add_direction( lanes, count, a->shape.eq15, s );
    }
}

static bool reaches_rows( const Accumulation* a, const RfHitBatch* batch, RfAccumulateJob job )
{
    int beyond = rf_has_filter( a->filter ) ? a->filter->reach : 0, low = batch->rows[2 * job.eye],
        high = batch->rows[2 * job.eye + 1];
    return low <= high && low - beyond < job.end_row && high + beyond >= job.first_row;
}

// Records which eyes' hits landed in each pixel of the job's rows, for FR (15).
static void note_landed_eyes( const Accumulation* a, RfAccumulateJob job, RfPixelRange range, uint32_t* landed_eyes,
                              RfAccumulateScratch* s )
{
    size_t words = (size_t)rf_seen_words( a->shape.eyes );
    for ( int k = 0; k < a->batch_count; ++k )
    {
        const RfHitBatch* batch = a->batches[k];
        if ( !reaches_rows( a, batch, job ) )
            continue;
        reproject( a, job.eye, batch, s );
        for ( int i = 0; i < batch->count; ++i )
        {
            int32_t pixel = s->pixel[i];
            if ( s->ratio[i] > 0.0f && pixel >= range.low && pixel < range.end )
                landed_eyes[(size_t)pixel * words + (size_t)( batch->eye / 32 )] |= 1u << ( batch->eye % 32 );
        }
    }
}

// By the pixel filter.
static uint64_t spread( const Accumulation* a, int eye, const RfHitBatch* batch, RfPixelRange range,
                        const RfAccumulateScratch* scratch )
{
    RfSpread s = { a->filter, range, a->eyes[eye].width, a->eyes[eye].height };
    uint64_t landed = rf_spread_hits( batch, scratch, s );
    return landed + ( eye == batch->eye ? rf_spread_own_frame( batch, !a->shape.own_frame_light, a->weight, s ) : 0 );
}

// Each sample in its own pixel.
static uint64_t splat( const Accumulation* a, int eye, const RfHitBatch* batch, RfPixelRange range,
                       const RfAccumulateScratch* scratch )
{
    uint64_t landed = rf_splat_diffuse( batch, scratch, range );
    if ( rf_glossy_count( batch ) > 0 )
        landed += rf_splat_glossy( batch, scratch, range );
    if ( eye != batch->eye )
        return landed;
    landed += rf_splat_misses( batch, !a->shape.own_frame_light, a->weight, range );
    rf_splat_glints( batch, a->weight, range );
    return landed;
}

static uint64_t add_batch( const Accumulation* a, RfAccumulateJob job, const RfHitBatch* batch, RfPixelRange range,
                           RfAccumulateScratch* scratch )
{
    reproject( a, job.eye, batch, scratch );
    if ( rf_glossy_count( batch ) > 0 )
        light_glossy( a, job.eye, batch, job.pass_state, scratch );
    uint64_t landed =
        rf_has_filter( a->filter ) ? spread( a, job.eye, batch, range, scratch ) : splat( a, job.eye, batch, range, scratch );
    if ( rf_calls_for( job.landed != NULL, RF_EFFECT_AOV_SAMPLES ) )
        rf_count_landed( batch, scratch, range, job.landed );
    if ( rf_calls_for( job.landed != NULL && job.eye == batch->eye, RF_EFFECT_AOV_SAMPLES ) )
        rf_count_misses( batch, range, job.landed );
    return landed;
}

uint64_t rf_accumulate_rows( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                             RfAccumulateScratch* scratch )
{
    Accumulation a = { group->eyes,
                       rf_tracer_mirrors( group->tracer ),
                       rf_batch_shape( group ),
                       group->settings->weights,
                       group->need == NULL ? group->filter : NULL,
                       job.weight,
                       batches,
                       batch_count };
    int width = group->width;
    RfPixelRange range = { job.films->half[job.half], job.first_row * width, job.end_row * width, job.sky };
    if ( a.shape.eq15 )
        note_landed_eyes( &a, job, range, job.pass_state, scratch );
    uint64_t landed = 0;
    for ( int k = 0; k < batch_count; ++k )
    {
        const RfHitBatch* batch = batches[k];
        if ( reaches_rows( &a, batch, job ) )
            landed += add_batch( &a, job, batch, range, scratch );
    }
    return landed;
}
