// Adds hit records to a film: projects them to the frame's camera, weights them (E1) and evaluates glossy hits.
#include "reuse/accumulate/accumulate.h"

#include "base/fault.h"
#include "path/mis.h"
#include "reuse/accumulate/covering_weights.h"
#include "reuse/accumulate/pass_light.h"
#include "reuse/accumulate/reprojection.h"
#include "reuse/accumulate/splat.h"
#include "reuse/harvest/harvest.h"
#include "scene/lens.h"

#include <string.h>

// Pixels of the hits at a camera, and their weights r_t = J_t V_t / Σ J_l V_l times `weight` (E1).
static void reproject( const RfAccumulation* a, int eye_index, const RfHitBatch* batch, RfAccumulateScratch* scratch )
{
    RfEye at = rf_eye_of( a, eye_index, batch );
    const RfEye* eye = &at;
    float weight = a->weight, *restrict ratio = scratch->ratio;
    bool own = eye_index == batch->eye, spreads = rf_has_filter( a->filter );
    RfProjectedLanes out = { .pixel = scratch->pixel,
                             .density = ratio,
                             .filter = { scratch->filter[0], scratch->filter[1], scratch->filter[2] },
                             .offset = { spreads ? scratch->offset[0] : NULL, spreads ? scratch->offset[1] : NULL } };
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
        memcpy( ratio, batch->densities + (size_t)eye_index * RF_LANES, (size_t)batch->count * sizeof *ratio );
    for ( int c = 0; c < 3 && batch->panes[c] != NULL; ++c )
    {
        const float* kappa = batch->panes[c] + (size_t)eye_index * RF_LANES;
        for ( int i = 0; i < batch->count; ++i )
            out.filter[c][i] *= kappa[i];
    }
    const float* restrict sum = batch->density_sum;
    const uint32_t* restrict seen = batch->seen + ( eye_index / 32 ) * RF_LANES;
    uint32_t bit = 1u << ( eye_index % 32 );
#pragma omp simd
    for ( int i = 0; i < batch->count; ++i )
    {
        float all = RF_FAULT( normalised_frames ) ? sum[i] + ratio[i] : sum[i];
        ratio[i] = ( seen[i] & bit ) != 0 ? weight * rf_mixture_share( ratio[i], all ) : 0.0f;
    }
    rf_note_weights( ratio, batch->count, weight );
}

// Light of a batch in the frame of a film: of dimmed lamps, scaled to it, and the rest.
typedef struct FrameLight
{
    int parts; // of dimmed lamps; by part from 1 on, NULL: it brings none
    const float* radiance[RF_PARTS_MOST];
    const RfDirectionLanes* directions[RF_PARTS_MOST];
    RfVec3 scale[RF_PARTS_MOST];
} FrameLight;

static FrameLight find_light( const RfAccumulation* a, const RfHitBatch* batch, bool removed )
{
    FrameLight light = { .parts = batch->dimmed_count };
    for ( int k = 0; k < light.parts; ++k )
    {
        const RfDimmedLight* of = batch->dimmed + k;
        light.scale[k] = RF_FAULT( part_scales ) ? rf_vec3( 1, 1, 1 ) : a->lights->part_scale[k + 1];
        if ( ( removed && !of->any_removed ) || !( rf_max_component( light.scale[k] ) > 0.0f ) )
            continue;
        light.radiance[k] = removed ? of->removed : of->radiance;
        light.directions[k] = removed ? of->removed_directions : of->directions;
    }
    return light;
}

// Misses and glints of the base parts of light groups, which have the scale 1. Misses may be black.
static void add_others( const RfAccumulation* a, const float* light, const RfHitBatch* batch, float* sum )
{
    int first = batch->count + ( a->shape.own_frame_light ? 0 : batch->miss_count );
    int end = batch->count + batch->miss_count + batch->glint_count;
    for ( int i = 4 * first; i < 4 * end; ++i )
        sum[i] += light[i];
}

static void add_part( const FrameLight* light, int k, int count, float* restrict sum )
{
    const float scale[4] = { light->scale[k].x, light->scale[k].y, light->scale[k].z, 0.0f };
    for ( int i = 0; i < 4 * count; ++i )
        sum[i] += scale[i % 4] * light->radiance[k][i];
}

static size_t listed_bytes( const RfHitBatch* batch )
{
    return 4 * sizeof( float ) * (size_t)( batch->count + batch->miss_count + batch->glint_count );
}

// Adds the radiance of all parts to that of the batch.
static float* add_dimmed( const RfAccumulation* a, const FrameLight* light, const RfHitBatch* batch, RfAccumulateScratch* s )
{
    if ( light->parts == 0 )
        return batch->radiance;
    memcpy( s->radiance, batch->radiance, listed_bytes( batch ) );
    for ( int k = 0; k < light->parts; ++k )
    {
        if ( light->radiance[k] == NULL )
            continue;
        add_part( light, k, batch->count, s->radiance );
        if ( k + 1 < a->lights->group_count )
            add_others( a, light->radiance[k], batch, s->radiance );
    }
    return s->radiance;
}

// Q of a direction, by channel; false where none comes by it.
static bool find_q( const FrameLight* light, const RfHitBatch* batch, int direction, const float* q[3], RfAccumulateScratch* s )
{
    const RfDirectionLanes* lanes = batch->directions + direction;
    int count = rf_glossy_count( batch );
    bool any = false;
    for ( int c = 0; c < 3; ++c )
        q[c] = lanes->q[c];
    for ( int k = 0; k < light->parts; ++k )
    {
        const RfDirectionLanes* of_part = light->directions[k] != NULL ? light->directions[k] + direction : NULL;
        const float scale[3] = { light->scale[k].x, light->scale[k].y, light->scale[k].z };
        if ( of_part == NULL || of_part->dark )
            continue;
        for ( int c = 0; c < 3; ++c )
        {
            float* restrict sum = s->q[c];
            const float* restrict more = of_part->q[c];
            if ( !any && lanes->dark )
                memset( sum, 0, (size_t)count * sizeof *sum );
            else if ( !any )
                memcpy( sum, lanes->q[c], (size_t)count * sizeof *sum );
            for ( int i = 0; i < count; ++i )
                sum[i] += scale[c] * more[i];
            q[c] = sum;
        }
        any = true;
    }
    return any || !lanes->dark;
}

// Radiance of the glossy hits towards the camera, into sum: Σ f Q over the directions.
static void light_glossy( const RfAccumulation* a, int eye, const RfHitBatch* batch, const FrameLight* light,
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
    RfEye at = rf_eye_of( a, eye, batch );
    rf_directions_to( a->mirrors, &at, eye, batch, wo );
    for ( int d = 0; d < rf_direction_count( &a->shape ); ++d )
    {
        const RfDirectionLanes* lanes = batch->directions + d;
        const float* q_of[3];
        if ( !find_q( light, batch, d, q_of, s ) )
            continue;
        const float* wi[3] = { lanes->wi[0], lanes->wi[1], lanes->wi[2] };
        rf_evaluate_glossy( batch, wo_in, wi, f, NULL );
        for ( int c = 0; c < 3; ++c )
        {
            float* restrict sum = s->sum[c];
            const float* restrict q = q_of[c];
            const float* restrict of_lobes = s->f[c];
#pragma omp simd
            for ( int i = 0; i < count; ++i )
                sum[i] += of_lobes[i] * q[i];
        }
    }
}

static bool reaches_rows( const RfAccumulation* a, const RfHitBatch* batch, RfAccumulateJob job )
{
    int beyond = rf_has_filter( a->filter ) ? a->filter->reach : 0, low = batch->rows[2 * job.eye],
        high = batch->rows[2 * job.eye + 1];
    return low <= high && low - beyond < job.end_row && high + beyond >= job.first_row;
}

// The pixels of a job in one of its films. Where own-frame light has sums of its own, they get the glints of groups and the count of
// own samples, but not extra ones.
static RfPixelRange find_range( const RfAccumulation* a, RfAccumulateJob job, const RfFilm* film, int width )
{
    float *half = film->half[job.half], *own = rf_film_own( film, job.half );
    return ( RfPixelRange ){
        .film = half,
        .glints = own != NULL && a->shape.own_light ? own : half,
        .counted = a->extra ? NULL : own,
        .low = job.first_row * width,
        .end = job.end_row * width,
        .sky = job.sky,
    };
}

// Adds what is taken out to a film of its own, whose weights do not matter. Caustics count in their own frame alone.
static void add_removed( const RfAccumulation* a, RfAccumulateJob job, const RfHitBatch* batch, RfAccumulateScratch* scratch )
{
    RfPixelRange range = find_range( a, job, job.films + 1, a->eyes[job.eye].width );
    RfHitBatch removed = *batch;
    bool clamped = a->shape.clamped;
    if ( !clamped && job.eye != batch->eye )
        return;
    FrameLight light = find_light( a, batch, true );
    removed.radiance = batch->removed;
    removed.radiance = add_dimmed( a, &light, &removed, scratch );
    removed.directions = batch->removed_directions;
    range.counted = NULL;
    range.sky = NULL;
    if ( rf_glossy_count( batch ) > 0 && clamped )
        light_glossy( a, job.eye, &removed, &light, scratch );
    for ( int c = 0; c < 3 && !clamped; ++c )
        memset( scratch->sum[c], 0, (size_t)rf_glossy_count( batch ) * sizeof( float ) );
    rf_splat( a, job.eye, &removed, range, scratch );
}

// The light of each group, by base part: s->lit.
static void light_groups( const RfAccumulation* a, const RfHitBatch* batch, const FrameLight* light, RfAccumulateScratch* s )
{
    const RfLights* lights = a->lights;
    for ( int base = 0; base < lights->group_count; ++base )
        s->lit[base] = base == 0 ? batch->radiance : light->radiance[base - 1];
    for ( int k = lights->group_count - 1; k < light->parts; ++k ) // of dimmed lamps
    {
        int base = lights->base_part[k + 1];
        if ( light->radiance[k] == NULL )
            continue;
        if ( s->lit[base] != s->lit_here[base] )
            memcpy( s->lit_here[base], s->lit[base], listed_bytes( batch ) );
        s->lit[base] = s->lit_here[base];
        add_part( light, k, batch->count, s->lit_here[base] );
    }
}

// light_glossy for all groups at once, into s->sums, and all of their light, into s->sum.
static void light_glossy_groups( const RfAccumulation* a, int eye, const RfHitBatch* batch, const FrameLight* light,
                                 RfAccumulateScratch* s )
{
    const RfLights* lights = a->lights;
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = rf_glossy_count( batch );
    float* wo[3] = { s->wo[0], s->wo[1], s->wo[2] };
    const float* wo_in[3] = { wo[0], wo[1], wo[2] };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    for ( int base = 0; base < lights->group_count; ++base )
    {
        for ( int i = 0; i < count; ++i )
        {
            for ( int c = 0; c < 3; ++c )
                s->sums[base][c][i] = s->lit[base][4 * ( first + i ) + c];
        }
    }
    RfEye at = rf_eye_of( a, eye, batch );
    rf_directions_to( a->mirrors, &at, eye, batch, wo );
    for ( int d = 0; d < rf_direction_count( &a->shape ); ++d )
    {
        const RfDirectionLanes* lanes = batch->directions + d;
        const float *wi[3] = { lanes->wi[0], lanes->wi[1], lanes->wi[2] }, *q_of[3];
        if ( !find_q( light, batch, d, q_of, s ) )
            continue;
        rf_evaluate_glossy( batch, wo_in, wi, f, NULL );
        for ( int part = 0; part <= light->parts; ++part )
        {
            const RfDirectionLanes* of_part = part == 0                             ? lanes
                                              : light->directions[part - 1] != NULL ? light->directions[part - 1] + d
                                                                                    : NULL;
            if ( of_part == NULL || of_part->dark )
                continue;
            RfVec3 of_frame = part == 0 ? rf_vec3( 1, 1, 1 ) : light->scale[part - 1];
            const float scale[3] = { of_frame.x, of_frame.y, of_frame.z };
            for ( int c = 0; c < 3; ++c )
            {
                float* restrict sum = s->sums[lights->base_part[part]][c];
                const float* restrict q = of_part->q[c];
                const float* restrict of_lobes = s->f[c];
#pragma omp simd
                for ( int i = 0; i < count; ++i )
                    sum[i] += of_lobes[i] * ( scale[c] * q[i] );
            }
        }
    }
    memset( s->sum, 0, sizeof s->sum );
    for ( int k = 0; k < 3 * lights->group_count; ++k )
    {
        for ( int i = 0; i < count; ++i )
            s->sum[k % 3][i] += s->sums[k / 3][k % 3][i];
    }
}

// Adds the light of each group to its film.
static void add_groups( const RfAccumulation* a, RfAccumulateJob job, const RfHitBatch* batch, RfAccumulateScratch* scratch )
{
    int count = a->lights->group_count;
    for ( int base = 0; base < count; ++base )
    {
        RfHitBatch of_group = *batch;
        of_group.radiance = (float*)(uintptr_t)scratch->lit[base];
        RfPixelRange range = find_range( a, job, job.groups + rf_group_of_part( base, count ), a->eyes[job.eye].width );
        range.counted = NULL;
        range.sky = NULL;
        if ( rf_glossy_count( batch ) > 0 )
            memcpy( scratch->sum, scratch->sums[base], sizeof scratch->sum );
        rf_splat( a, job.eye, &of_group, range, scratch );
    }
}

// Direct light of the glossy hits towards the camera, by light samples and scattered directions, after light_glossy.
static void light_glossy_directly( const RfAccumulation* a, const RfHitBatch* given, const FrameLight* light,
                                   RfAccumulateScratch* s )
{
    int first = given->first[RF_BSDF_FIRST_GLOSSY], count = rf_glossy_count( given ), scattered = rf_first_pairing( &a->shape );
    const float* wo[3] = { s->wo[0], s->wo[1], s->wo[2] };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    for ( int d = 0; d <= scattered; ++d )
    {
        const RfDirectionLanes* lanes = given->directions + d;
        const float *wi[3] = { lanes->wi[0], lanes->wi[1], lanes->wi[2] }, *q_of[3];
        bool sampled = d < rf_light_directions( &a->shape );
        if ( ( !sampled && d < scattered ) || !find_q( light, given, d, q_of, s ) )
            continue;
        rf_evaluate_glossy( given, wo, wi, f, NULL );
        for ( int i = 0; i < 3 * count; ++i )
        {
            int c = i / count, hit = i % count;
            float q = sampled ? q_of[c][hit] : given->passes->direct_q[c][hit];
            for ( int k = 0; k < light->parts && !sampled; ++k )
            {
                const float scale[3] = { light->scale[k].x, light->scale[k].y, light->scale[k].z };
                if ( given->dimmed[k].passes != NULL )
                    q += scale[c] * given->dimmed[k].passes->direct_q[c][hit];
            }
            s->direct[c][first + hit] += s->f[c][hit] * q;
        }
    }
}

// Adds each pass that is asked for to its film. `lit`: the batch with all of its light; of glossy hits it is in s->sum.
static void add_passes( const RfAccumulation* a, RfAccumulateJob job, const RfHitBatch* given, const RfHitBatch* lit,
                        const FrameLight* light, RfAccumulateScratch* s )
{
    RfFilm* film = job.passes;
    rf_begin_pass_light( lit, s );
    rf_add_pass_light( given, given->passes, rf_vec3( 1, 1, 1 ), s );
    for ( int k = 0; k < light->parts; ++k )
    {
        if ( given->dimmed[k].passes != NULL )
            rf_add_pass_light( given, given->dimmed[k].passes, light->scale[k], s );
    }
    if ( rf_glossy_count( given ) > 0 )
        light_glossy_directly( a, given, light, s );
    for ( RfAov pass = RF_AOV_EMISSION; pass <= RF_AOV_TRANSMISSION; ++pass )
    {
        if ( ( a->passes & RF_AOV_BIT( pass ) ) == 0 )
            continue;
        RfHitBatch of_pass = *given;
        RfPixelRange range = find_range( a, job, film++, a->eyes[job.eye].width );
        range.counted = NULL;
        range.sky = NULL;
        rf_light_pass( lit, pass, s );
        of_pass.radiance = s->pass;
        rf_splat( a, job.eye, &of_pass, range, s );
    }
}

static uint64_t add_batch( const RfAccumulation* a, RfAccumulateJob job, const RfHitBatch* given, RfPixelRange range,
                           RfAccumulateScratch* scratch )
{
    RfHitBatch lit = *given, *batch = &lit;
    bool grouped = job.groups != NULL;
    FrameLight light = find_light( a, given, false );
    if ( grouped )
        light_groups( a, given, &light, scratch );
    lit.radiance = add_dimmed( a, &light, given, scratch );
    reproject( a, job.eye, batch, scratch );
    if ( rf_glossy_count( batch ) > 0 && grouped )
        light_glossy_groups( a, job.eye, given, &light, scratch );
    else if ( rf_glossy_count( batch ) > 0 )
        light_glossy( a, job.eye, batch, &light, scratch );
    uint64_t landed = rf_splat( a, job.eye, batch, range, scratch );
    if ( job.covering != NULL )
        rf_cover_rows( a, job, batch, scratch );
    if ( job.passes != NULL )
        add_passes( a, job, given, batch, &light, scratch );
    if ( grouped )
        add_groups( a, job, given, scratch );
    if ( batch->removed != NULL && batch->any_removed )
        add_removed( a, job, given, scratch );
    if ( job.landed != NULL )
        rf_count_landed( batch, scratch, range, job.landed );
    if ( job.landed != NULL && job.eye == batch->eye )
        rf_count_misses( batch, range, job.landed );
    return landed;
}

static RfAccumulation make_accumulation( const RfEstimatorGroup* group, RfAccumulateJob job )
{
    return ( RfAccumulation ){
        .eyes = group->eyes,
        .mirrors = rf_tracer_mirrors( group->tracer ),
        .shape = rf_batch_shape( group ),
        .filter = group->need == NULL ? group->filter : NULL,
        .extra = group->need != NULL,
        .passes = group->settings->aovs,
        .weight = job.weight,
        .lights = rf_tracer_lights( group->tracers != NULL ? group->tracers[job.eye] : group->tracer ),
    };
}

uint64_t rf_accumulate_rows( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                             RfAccumulateScratch* scratch )
{
    RfAccumulation a = make_accumulation( group, job );
    a.batches = batches;
    a.batch_count = batch_count;
    RfPixelRange range = find_range( &a, job, job.films, group->width );
    uint64_t landed = 0;
    for ( int k = 0; k < batch_count; ++k )
    {
        const RfHitBatch* batch = batches[k];
        if ( reaches_rows( &a, batch, job ) )
            landed += add_batch( &a, job, batch, range, scratch );
    }
    return landed;
}

bool rf_keeps_landings( const RfBatchShape* shape )
{
    return shape->groups == 0 && !shape->passes && !shape->clamped && !shape->caustics && !rf_has_covering( shape );
}

void rf_land_batch( const RfEstimatorGroup* group, RfAccumulateJob job, const RfHitBatch* given, RfAccumulateScratch* scratch,
                    void* landing )
{
    RfAccumulation a = make_accumulation( group, job );
    RfLandedHits* hits = rf_place_landing( rf_has_filter( a.filter ), &( RfLayout ){ .memory = landing } );
    RfHitBatch lit = *given;
    if ( !reaches_rows( &a, given, job ) )
        return;
    FrameLight light = find_light( &a, given, false );
    lit.radiance = add_dimmed( &a, &light, given, scratch );
    reproject( &a, job.eye, &lit, scratch );
    if ( rf_glossy_count( &lit ) > 0 )
        light_glossy( &a, job.eye, &lit, &light, scratch );
    rf_keep_landing( &lit, scratch, hits );
}

uint64_t rf_add_landings( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, void* const* landings,
                          int batch_count )
{
    RfAccumulation a = make_accumulation( group, job );
    RfPixelRange range = find_range( &a, job, job.films, group->width );
    uint64_t landed = 0;
    for ( int k = 0; k < batch_count; ++k )
    {
        const RfHitBatch* batch = batches[k];
        if ( !reaches_rows( &a, batch, job ) )
            continue;
        landed += rf_splat_landing( &a, job.eye, batch, landings[k], range );
        if ( job.landed != NULL )
            rf_count_landing( landings[k], range, job.landed );
        if ( job.landed != NULL && job.eye == batch->eye )
            rf_count_misses( batch, range, job.landed );
    }
    return landed;
}
