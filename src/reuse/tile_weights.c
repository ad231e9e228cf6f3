// The balance weights of the pairs in a tile: which hits see which second
// vertices, and with what density they would have sampled them.
#include "base/fault.h"
#include "reuse/tile_reuse.h"

#include "reuse/tile.h"
#include "reuse/tile_chains.h"
#include "reuse/tile_connect.h"
#include "reuse/weight_range.h"

#include <stddef.h>
#include <string.h>

static void multiply_densities( const RfVertexLanes* x, RfPairingLanes* pairing, float* pdf )
{
    const float* wo[3] = { x->wo[0], x->wo[1], x->wo[2] };
    const float* wi[3] = { pairing->wi[0], pairing->wi[1], pairing->wi[2] };
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        if ( rf_is_model_built( (RfBsdfKind)kind ) )
            rf_evaluate_seen_from( x, (RfBsdfKind)kind, wo, wi, NULL, pdf );
    }
    int count = rf_record_count( x );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
        pairing->weight[i] *= pdf[i];
}

// Segments to be tested, and the weights that their visibility multiplies.
typedef struct Queue
{
    const RfTracer* tracer;
    RfLaneScratch* scratch;
    int count;
    uint64_t tested;
    float* weight[RF_PATCH_PIXELS];
    RfTileReuse* reuse; // whose weights they are
} Queue;

// Connections through panes: they have a part of the density, q, and carry light times κ.
static void test_past_panes( Queue* q, const float* const o[3], const float* const d[3] )
{
    RfLaneScratch* s = q->scratch;
    RfPaneLanes panes = { s->pdf, { s->f[0], s->f[1], s->f[2] } };
    rf_trace_segments_past_panes( q->tracer, q->count, o, d, s->visible, &panes );
    for ( int k = 0; k < q->count; ++k )
    {
        s->visible[k] *= panes.probability[k];
        size_t pairing = (size_t)( (char*)q->weight[k] - (char*)q->reuse->pairings ) / sizeof( RfPairingLanes );
        ptrdiff_t hit = q->weight[k] - q->reuse->pairings[pairing].weight;
        for ( int c = 0; c < 3; ++c )
            q->reuse->pane_weight[pairing][c][hit] = panes.weight[c][k];
    }
}

static void test_segments( Queue* q )
{
    RfLaneScratch* s = q->scratch;
    const float* o[3] = { s->o[0], s->o[1], s->o[2] };
    const float* d[3] = { s->d[0], s->d[1], s->d[2] };
    if ( rf_tracer_has_panes( q->tracer ) )
        test_past_panes( q, o, d );
    else
        rf_trace_segments( q->tracer, q->count, o, d, s->visible );
    for ( int k = 0; k < q->count; ++k )
        *q->weight[k] *= s->visible[k];
    q->tested += (uint64_t)q->count;
    q->count = 0;
}

static inline RfVec3 lifted( const RfVertexLanes* v, int i )
{
    RfVec3 ng = rf_vec3( v->ng[0][i], v->ng[1][i], v->ng[2][i] );
    return rf_madd( rf_vec3( v->p[0][i], v->p[1][i], v->p[2][i] ), ng, v->offset[i] );
}

static void lift_hits( const RfVertexLanes* x, RfTileReuse* reuse )
{
    int count = rf_record_count( x );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 p = lifted( x, i );
        reuse->lifted[0][i] = p.x;
        reuse->lifted[1][i] = p.y;
        reuse->lifted[2][i] = p.z;
    }
}

// Queues the segment from a point to a hit, unless its weight is 0.
static inline void queue_segment( Queue* q, const RfTileReuse* reuse, RfVec3 from, int hit, float* weight )
{
    RfLaneScratch* s = q->scratch;
    int k = q->count;
    s->o[0][k] = from.x;
    s->o[1][k] = from.y;
    s->o[2][k] = from.z;
    s->d[0][k] = reuse->lifted[0][hit] - from.x;
    s->d[1][k] = reuse->lifted[1][hit] - from.y;
    s->d[2][k] = reuse->lifted[2][hit] - from.z;
    q->weight[k] = weight;
    q->count += *weight != 0.0f;
    if ( q->count == RF_PATCH_PIXELS )
        test_segments( q );
}

// Tests the connections of paths to their own second vertex, which matters only with
// blended surfaces. Their rays carry κ already. The path did get through, so the result is never 0.
static void test_own_paths( Queue* q, int hits, RfTileReuse* reuse )
{
    float* weight = reuse->pairings[0].weight;
    float least[RF_LANES];
    for ( int i = 0; i < hits; ++i )
        least[i] = 1e-12f * weight[i];
    for ( int a = 0; a < rf_record_count( &reuse->second ); ++a )
    {
        int i = reuse->owner[a];
        if ( i >= 0 )
            queue_segment( q, reuse, lifted( &reuse->second, a ), i, weight + i );
    }
    test_segments( q );
    for ( int i = 0; i < hits; ++i )
        weight[i] = rf_maxf( weight[i], least[i] );
}

// Queues the segments from a second vertex to the other hits of its tile.
static void queue_vertex( Queue* q, RfTileReuse* reuse, int a )
{
    RfVec3 from = lifted( &reuse->second, a );
    int own = reuse->owner[a], size = reuse->size[own], rank = reuse->rank[own];
    const int32_t* member = reuse->member + reuse->begin[own];
    for ( int k = 0; k < size; ++k )
    {
        int s = rank >= k ? rank - k : rank - k + size;
        if ( s > 0 )
            queue_segment( q, reuse, from, member[k], reuse->pairings[s].weight + member[k] );
    }
}

// Tests each connection of a tile once, vertex by vertex.
static uint64_t test_connections( const RfTileReuseSettings* settings, const RfVertexLanes* x, RfWavefront* wavefront,
                                  RfTileReuse* reuse )
{
    Queue q = { .tracer = settings->path->tracer, .scratch = &wavefront->scratch, .reuse = reuse };
    const RfVertexLanes* y = &reuse->second;
    lift_hits( x, reuse );
    if ( rf_tracer_is_partial( q.tracer ) && rf_tracer_is_blended( q.tracer ) )
        test_own_paths( &q, rf_record_count( x ), reuse );
    for ( int a = 0; a < y->count; ++a )
    {
        if ( reuse->owner[a] >= 0 && !rf_is_parallel( reuse, a ) )
            queue_vertex( &q, reuse, a );
    }
    test_segments( &q );
    return q.tested;
}

// ρ ↦ ρ / Σ ρ over the hits that could have sampled the vertex.
static void normalize_weights( int tile_pixels, int hits, RfTileReuse* reuse )
{
    float* restrict sum = reuse->sum;
    memset( sum, 0, ( (size_t)reuse->second.count + 1 ) * sizeof( float ) );
    for ( int s = 0; s < tile_pixels; ++s )
    {
        const RfPairingLanes* pairing = reuse->pairings + s;
        for ( int i = 0; i < hits; ++i )
        {
            if ( pairing->weight[i] > 0.0f ) // many are 0
                sum[pairing->vertex[i]] += pairing->weight[i];
        }
    }
    for ( int s = 0; s < tile_pixels; ++s )
    {
        RfPairingLanes* pairing = reuse->pairings + s;
#pragma omp simd
        for ( int i = 0; i < hits; ++i )
        {
            float all = sum[pairing->vertex[i]]; // 0 where all weights are
            pairing->weight[i] /= all > 0.0f && !RF_FAULT( normalised_tiles ) ? all : 1.0f;
        }
        rf_note_weights( pairing->weight, hits, 1.0f );
    }
}

uint64_t rf_weight_pairings( const RfTileReuseSettings* settings, const RfVertexLanes* hits, float* const scattered[3],
                             RfWavefront* wavefront, RfTileReuse* reuse )
{
    int count = rf_record_count( hits );
    // pairing 0 is the path as it was sampled
    for ( int c = 0; c < 3; ++c )
        memcpy( reuse->pairings[0].wi[c], scattered[c], (size_t)count * sizeof( float ) );
    for ( int s = 0; s < settings->tile_pixels; ++s )
    {
        if ( s > 0 && settings->path_roulette )
            rf_connect_few( hits, reuse, s );
        else if ( s > 0 )
            rf_connect_neighbours( hits, reuse, reuse->pairings + s );
        if ( s > 0 && settings->chain_light )
            rf_aim_at_chains( scattered, s, reuse );
        multiply_densities( hits, reuse->pairings + s, wavefront->scratch.pdf );
    }
    uint64_t tested = test_connections( settings, hits, wavefront, reuse );
    tested += rf_follow_chain_light( settings, wavefront, reuse );
    normalize_weights( settings->tile_pixels, count, reuse );
    return tested;
}
