// Traces chain samples: short rays by the cosine that end at anything but mirrors and smooth glass, and what they find there.
#include "path/chain_samples.h"

#include "math/fastmath.h"

#include <math.h>
#include <string.h>

// A sequence of low discrepancy (Roberts, R2).
#define STEP_U 0.75487766624669276f
#define STEP_V 0.56984029099805327f

static uint32_t dimension_of( int sample, int vertex )
{
    return RF_DIMENSION_CHAIN_SAMPLES + 3u * (uint32_t)( sample * ( RF_MAX_CHAIN_LIGHT + 3 ) + vertex );
}

static float step( float u, float by )
{
    u += by;
    return rf_minf( u - floorf( u ), 0x1.fffffep-1f );
}

#define LANE( array, i ) rf_vec3( ( array )[0][i], ( array )[1][i], ( array )[2][i] )

// A cosine-weighted direction.
static RfVec3 direction_by( RfVec3 n, float u0, float u1 )
{
    RfVec3 t, b;
    float s, c;
    rf_basis( n, &t, &b );
    rf_sincos_2pi( u1, &s, &c );
    RfVec3 across = rf_madd( rf_scale( t, c ), b, s );
    return rf_madd( rf_scale( across, sqrtf( u0 ) ), n, sqrtf( 1.0f - u0 ) );
}

// Random numbers for the hits in their list.
static void draw( const RfVertexLanes* v, int sample, int first, int numbers, RfWavefront* wavefront,
                  const RfChainSamples* samples )
{
    int32_t* slot = wavefront->scratch.index;
    for ( int k = 0; k < samples->count; ++k )
        slot[k] = v->slot[samples->hit[k]];
    rf_draw_lanes( wavefront, samples->count, slot, dimension_of( sample, 0 ) + (uint32_t)first, numbers,
                   wavefront->scratch.random );
}

// The rays of one sample of all hits.
static void leave( const RfVertexLanes* v, int sample, RfWavefront* wavefront, RfChainSamples* samples )
{
    RfRayLanes* rays = &wavefront->rays;
    float( *random )[RF_LANES] = wavefront->scratch.random;
    draw( v, 0, 0, 2, wavefront, samples );
    rays->count = 0;
    for ( int k = 0; k < samples->count; ++k )
    {
        int i = samples->hit[k];
        float u0 = step( random[0][k], (float)sample * STEP_U ), u1 = step( random[1][k], (float)sample * STEP_V );
        RfVec3 n = LANE( v->n, i ), ng = LANE( v->ng, i );
        RfVec3 d = direction_by( n, u0, u1 );
        int slot = v->slot[i], at = rays->count;
        RF_PUT3( samples->way, slot, d );
        RF_PUT3( samples->light, slot, rf_vec3( 0, 0, 0 ) );
        RF_PUT3( rays->o, at, rf_madd( LANE( v->p, i ), ng, v->offset[i] ) );
        RF_PUT3( rays->d, at, d );
        RF_PUT3( rays->throughput, at, rf_vec3( 1, 1, 1 ) );
        rays->slot[at] = slot;
        rays->count += rf_dot( d, ng ) > 0.0f && rf_dot( d, n ) > 0.0f;
    }
}

// Compacts the rays to those that are wanted.
static void compact( const float* wanted, RfRayLanes* rays )
{
    int count = 0;
    for ( int r = 0; r < rays->count; ++r )
    {
        RF_PUT3( rays->o, count, LANE( rays->o, r ) );
        RF_PUT3( rays->d, count, LANE( rays->d, r ) );
        rays->slot[count] = rays->slot[r];
        count += wanted[r] > 0.0f;
    }
    rays->count = count;
}

// Keeps the few rays that hit a mirror or glass first, before the costlier lookup of their vertices.
static void keep_chains( const RfPathSettings* settings, RfWavefront* wavefront )
{
    RfRayLanes* rays = &wavefront->rays;
    RfLaneScratch* s = &wavefront->scratch;
    const float *o[3] = { rays->o[0], rays->o[1], rays->o[2] }, *d[3] = { rays->d[0], rays->d[1], rays->d[2] };
    const RfMaterial* materials = rf_tracer_scene( settings->tracer )->materials;
    rf_meet_chain_bounds( rf_tracer_chain_bounds( settings->tracer ), rays->count, o, d, s->visible );
    compact( s->visible, rays );
    wavefront->path_rays += (uint64_t)rays->count; // not by slot: most lead to no vertex, and cost little beside others
    rf_trace_nearest( settings->tracer, rays->count, o, d, false, s->triangle, s->u, s->v );
    for ( int r = 0; r < rays->count; ++r )
        s->visible[r] = s->triangle[r] != RF_MISS &&
                        materials[rf_triangle_material( settings->tracer, s->triangle[r] )].kind == RF_BSDF_GLASS;
    compact( s->visible, rays );
}

static void note_light( const RfPathSettings* settings, int slot, RfVec3 light, int part, RfChainSamples* samples )
{
    RF_PUT3( samples->light, slot, light );
    if ( settings->grouped )
        samples->part[slot] = (uint8_t)rf_counts_in( settings, part );
}

// The emission that rays have met behind a chain.
static void add_emission( const RfPathSettings* settings, const RfWavefront* wavefront, const RfRayLanes* rays,
                          RfChainSamples* samples )
{
    const RfLights* lights = rf_tracer_lights( settings->tracer );
    const RfVertexLanes* v = &wavefront->vertices;
    for ( int i = 0; i < v->count; ++i )
    {
        if ( v->light_pdf_solid_angle[i] > 0.0f )
            note_light( settings, v->slot[i],
                        rf_mul( LANE( rays->throughput, v->ray[i] ), rf_emission_in_frame( settings, v, i ) ),
                        rf_material_part( lights, v->material[i] ), samples );
    }
    for ( int r = 0; r < rays->count && rf_has_sky( lights ); ++r )
    {
        if ( wavefront->scratch.triangle[r] == RF_MISS )
            note_light( settings, rays->slot[r],
                        rf_mul( LANE( rays->throughput, r ), rf_sky_in_frame( settings, LANE( rays->d, r ) ) ),
                        rf_light_part( lights, rf_sky_number( lights ) ), samples );
    }
}

static bool emits( const RfPathSettings* settings, const RfVertexLanes* v, int i )
{
    return v->light_pdf_solid_angle[i] > 0.0f && rf_max_component( rf_emission_in_frame( settings, v, i ) ) > 0.0f;
}

// Continues the rays at mirrors and smooth glass; all others end.
static void scatter( const RfPathSettings* settings, const RfRayLanes* rays, int sample, int vertex, RfWavefront* wavefront,
                     RfRayLanes* next )
{
    RfVertexLanes* v = &wavefront->vertices;
    RfLaneScratch* s = &wavefront->scratch;
    float* wi[3] = { s->wi[0], s->wi[1], s->wi[2] };
    int first = rf_record_count( v );
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
        v->first[kind] = first; // the others need no direction
    v->guide = NULL;
    next->count = 0;
    if ( first == v->count )
        return;
    rf_scatter_lanes( wavefront, v, dimension_of( sample, vertex - 1 ), wi, s );
    for ( int i = first; i < v->count; ++i )
    {
        float way[3] = { s->wi[0][i], s->wi[1][i], s->wi[2][i] };
        float side = rf_leaving_side( v, i, way );
        RfVec3 t = rf_mul( LANE( rays->throughput, v->ray[i] ), LANE( s->f, i ) );
        if ( !rf_is_chain_event( v, i, s->pdf[i] ) || emits( settings, v, i ) || side == 0.0f ||
             !( rf_max_component( t ) > 0.0f ) )
            continue;
        int at = next->count++;
        RF_PUT3( next->o, at, rf_madd( LANE( v->p, i ), LANE( v->ng, i ), side * v->offset[i] ) );
        RF_PUT3( next->d, at, LANE( s->wi, i ) );
        RF_PUT3( next->throughput, at, t );
        next->slot[at] = v->slot[i];
    }
}

// Follows the chains of one sample.
static void follow( const RfPathSettings* settings, int sample, RfWavefront* wavefront, RfChainSamples* samples )
{
    RfRayLanes *rays = &wavefront->rays, *next = &wavefront->next;
    int most = settings->max_depth + ( settings->spent != NULL && rf_tracer_has_panes( settings->tracer ) );
    most = most < RF_MAX_CHAIN_LIGHT + 2 ? most : RF_MAX_CHAIN_LIGHT + 2;
    for ( int vertex = 2; vertex <= most && rays->count > 0; ++vertex )
    {
        if ( vertex > 2 )
            rf_count_path_rays( wavefront, rays );
        rf_find_vertices_past_panes( settings, rays, 0, &wavefront->vertices, &wavefront->scratch );
        rf_absorb( &wavefront->vertices, rays );
        if ( vertex > 2 )
            add_emission( settings, wavefront, rays, samples );
        if ( vertex == most )
            break;
        rf_end_spent_paths( settings, vertex, rays );
        scatter( settings, rays, sample, vertex, wavefront, next );
        RfRayLanes* swap = rays;
        rays = next;
        next = swap;
    }
}

// Glossy hits keep one of the directions, drawn by the luminance found there.
static void keep_one( const RfVertexLanes* v, int i, float random, int base_parts, RfChainSamples* samples )
{
    RfLightLanes* found = &samples->found;
    int slot = v->slot[i];
    RfVec3 light = LANE( samples->light, slot );
    float luminance = rf_luminance( light );
    samples->sum[slot] += luminance;
    if ( !( luminance > 0.0f && random * samples->sum[slot] < luminance ) )
        return;
    RF_PUT3( found->wi, i, LANE( samples->way, slot ) );
    for ( int part = 1; part < base_parts; ++part )
        RF_PUT3( rf_chain_samples_of( samples, part ), i, rf_vec3( 0, 0, 0 ) );
    RF_PUT3( found->radiance_cos, i, rf_vec3( 0, 0, 0 ) );
    RF_PUT3( rf_chain_samples_of( samples, base_parts > 1 ? samples->part[slot] : 0 ), i, rf_scale( light, 1.0f / luminance ) );
}

static void keep( const RfVertexLanes* v, int sample, int base_parts, RfWavefront* wavefront, RfChainSamples* samples )
{
    draw( v, sample, 2, 1, wavefront, samples );
    for ( int k = 0; k < samples->count; ++k )
    {
        int i = samples->hit[k];
        if ( i >= v->first[RF_BSDF_FIRST_GLOSSY] )
            keep_one( v, i, wavefront->scratch.random[0][k], base_parts, samples );
        float( *sum )[RF_LANES] = rf_chain_samples_of( samples, base_parts > 1 ? samples->part[v->slot[i]] : 0 );
        for ( int c = 0; c < 3 && i < v->first[RF_BSDF_FIRST_GLOSSY]; ++c )
            sum[c][i] += samples->light[c][v->slot[i]];
    }
}

static void clear( const RfVertexLanes* v, int base_parts, RfChainSamples* samples )
{
    for ( int part = 1; part < base_parts; ++part )
        memset( samples->of_groups[part - 1], 0, sizeof *samples->of_groups );
    if ( base_parts > 1 )
        memset( samples->part, 0, RF_LANES );
    for ( int i = 0; i < v->count; ++i )
    {
        RF_PUT3( samples->found.wi, i, LANE( v->n, i ) );
        RF_PUT3( samples->found.radiance_cos, i, rf_vec3( 0, 0, 0 ) );
        samples->found.pdf_solid_angle[i] = 0.0f;
        samples->sum[v->slot[i]] = 0.0f;
    }
}

void rf_trace_chain_samples( const RfPathSettings* settings, RfChainSampling sampling, const RfVertexLanes* v,
                             RfWavefront* wavefront, RfChainSamples* samples )
{
    RfLightLanes* found = &samples->found;
    int base_parts = rf_base_parts( settings );
    clear( v, base_parts, samples );
    for ( int k = 0; k < sampling.count && samples->count > 0; ++k )
    {
        leave( v, k, wavefront, samples );
        keep_chains( settings, wavefront );
        follow( settings, k, wavefront, samples );
        keep( v, k, base_parts, wavefront, samples );
    }
    for ( int k = 0; k < samples->count; ++k )
    {
        int i = samples->hit[k];
        float cosine = rf_maxf( rf_dot( LANE( v->n, i ), LANE( found->wi, i ) ), 0.0f );
        float scale = ( i < v->first[RF_BSDF_FIRST_GLOSSY] ? 1.0f : samples->sum[v->slot[i]] ) * cosine / sampling.worth;
        for ( int c = 0; c < 3 * base_parts; ++c )
            rf_chain_samples_of( samples, c / 3 )[c % 3][i] *= scale;
        found->pdf_solid_angle[i] = rf_chain_sample_pdf( sampling, cosine );
    }
}
