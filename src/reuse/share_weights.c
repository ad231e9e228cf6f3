// The balance weights of the pairs in a tile: which hits see which second
// vertices, and with what density they would have found them.
#include "reuse/share.h"

#include <string.h>

// Directions of a turn, and ρ but for the density and the visibility; 0 where
// the two turn away from each other.
static void look_at_mates( const RfVertexLanes* restrict x, const RfShare* restrict share, RfTurnLanes* restrict turn )
{
    const RfVertexLanes* restrict y = &share->second;
    int count = rf_record_count( x );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        int a = turn->mate[i];
        RfVec3 ng = rf_vec3( x->ng[0][i], x->ng[1][i], x->ng[2][i] );
        RfVec3 n = rf_vec3( x->n[0][i], x->n[1][i], x->n[2][i] );
        RfVec3 from = rf_madd( rf_vec3( x->p[0][i], x->p[1][i], x->p[2][i] ), ng, x->offset[i] );
        RfVec3 way = rf_sub( rf_vec3( y->p[0][a], y->p[1][a], y->p[2][a] ), from );
        float d2 = rf_dot( way, way );
        RfVec3 wi = rf_scale( way, 1.0f / sqrtf( d2 ) );
        float cos_y = -rf_dot( rf_vec3( y->ng[0][a], y->ng[1][a], y->ng[2][a] ), wi );
        float geometry = cos_y / d2 * share->own_distance2_cos[a];
        int sees = ( turn->weight[i] > 0.0f ) & ( cos_y > 0.0f ) & ( rf_dot( n, wi ) > 0.0f ) & ( rf_dot( ng, wi ) > 0.0f ) &
                   ( geometry < 1e18f );
        // a direction always, be it to no avail: the BSDFs want one
        turn->wi[0][i] = sees ? wi.x : n.x;
        turn->wi[1][i] = sees ? wi.y : n.y;
        turn->wi[2][i] = sees ? wi.z : n.z;
        turn->weight[i] = sees ? geometry : 0.0f;
    }
}

static void multiply_densities( const RfVertexLanes* x, RfTurnLanes* turn, float* pdf )
{
    const float* wo[3] = { x->wo[0], x->wo[1], x->wo[2] };
    const float* wi[3] = { turn->wi[0], turn->wi[1], turn->wi[2] };
    for ( int kind = 0; kind < RF_BSDF_FIRST_NATIVE; ++kind )
        rf_evaluate_seen_from( x, (RfBsdfKind)kind, wo, wi, NULL, pdf );
    int count = rf_record_count( x );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
        turn->weight[i] *= pdf[i];
}

// Segments that wait to be tested, and the weights they are of.
typedef struct Queue
{
    const RfTracer* tracer;
    RfLaneScratch* scratch;
    int count;
    uint64_t tested;
    float* weight[RF_PATCH_PIXELS];
} Queue;

static void test_segments( Queue* q )
{
    RfLaneScratch* s = q->scratch;
    const float* o[3] = { s->o[0], s->o[1], s->o[2] };
    const float* d[3] = { s->d[0], s->d[1], s->d[2] };
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

static void lift_hits( const RfVertexLanes* x, RfShare* share )
{
    int count = rf_record_count( x );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 p = lifted( x, i );
        share->lifted[0][i] = p.x;
        share->lifted[1][i] = p.y;
        share->lifted[2][i] = p.z;
    }
}

// From a point to a hit; a weight of 0 is overwritten by the next.
static inline void queue_segment( Queue* q, const RfShare* share, RfVec3 from, int hit, float* weight )
{
    RfLaneScratch* s = q->scratch;
    int k = q->count;
    s->o[0][k] = from.x;
    s->o[1][k] = from.y;
    s->o[2][k] = from.z;
    s->d[0][k] = share->lifted[0][hit] - from.x;
    s->d[1][k] = share->lifted[1][hit] - from.y;
    s->d[2][k] = share->lifted[2][hit] - from.z;
    q->weight[k] = weight;
    q->count += *weight > 0.0f;
    if ( q->count == RF_PATCH_PIXELS )
        test_segments( q );
}

// Its own path found the vertex; where surfaces let a part of the light through, it
// did so with a chance, which is not nothing.
static void test_own( Queue* q, int hits, RfShare* share )
{
    float* weight = share->turns[0].weight;
    float least[RF_LANES];
    for ( int i = 0; i < hits; ++i )
        least[i] = 1e-4f * weight[i];
    for ( int a = 0; a < rf_record_count( &share->second ); ++a )
    {
        int i = share->owner[a];
        if ( i >= 0 )
            queue_segment( q, share, lifted( &share->second, a ), i, weight + i );
    }
    test_segments( q );
    for ( int i = 0; i < hits; ++i )
        weight[i] = rf_maxf( weight[i], least[i] );
}

// All connections of a tile once, from each second vertex in turn.
static uint64_t test_connections( const RfTracer* tracer, const RfVertexLanes* x, RfLaneScratch* scratch, RfShare* share )
{
    Queue q = { .tracer = tracer, .scratch = scratch };
    lift_hits( x, share );
    if ( rf_tracer_is_blended( tracer ) )
        test_own( &q, rf_record_count( x ), share );
    const RfVertexLanes* y = &share->second;
    for ( int a = 0; a < rf_record_count( y ); ++a )
    {
        int own = share->owner[a];
        if ( own < 0 )
            continue;
        RfVec3 from = lifted( y, a );
        const int32_t* member = share->member + share->begin[own];
        int size = share->size[own], rank = share->rank[own];
        for ( int k = 0, s = rank; k < size; ++k, s = s > 0 ? s - 1 : size - 1 )
        {
            if ( s > 0 )
                queue_segment( &q, share, from, member[k], share->turns[s].weight + member[k] );
        }
    }
    test_segments( &q );
    return q.tested;
}

// ρ ↦ ρ / Σ ρ over the hits that could have found the vertex.
static void normalize( int tile_pixels, int hits, RfShare* share )
{
    float* restrict sum = share->sum;
    memset( sum, 0, ( (size_t)share->second.count + 1 ) * sizeof( float ) );
    for ( int s = 0; s < tile_pixels; ++s )
    {
        const RfTurnLanes* turn = share->turns + s;
        for ( int i = 0; i < hits; ++i )
            sum[turn->mate[i]] += turn->weight[i];
    }
    for ( int s = 0; s < tile_pixels; ++s )
    {
        RfTurnLanes* turn = share->turns + s;
#pragma omp simd
        for ( int i = 0; i < hits; ++i )
            turn->weight[i] = turn->weight[i] > 0.0f ? turn->weight[i] / sum[turn->mate[i]] : 0.0f;
    }
}

uint64_t rf_weigh_turns( const RfWalkSettings* settings, int tile_pixels, const RfVertexLanes* hits, float* const scattered[3],
                         RfLaneScratch* scratch, RfShare* share )
{
    // turn 0 is the path as it was drawn
    for ( int c = 0; c < 3; ++c )
        memcpy( share->turns[0].wi[c], scattered[c], (size_t)rf_record_count( hits ) * sizeof( float ) );
    for ( int s = 0; s < tile_pixels; ++s )
    {
        if ( s > 0 )
            look_at_mates( hits, share, share->turns + s );
        multiply_densities( hits, share->turns + s, scratch->pdf );
    }
    uint64_t tested = test_connections( settings->tracer, hits, scratch, share );
    normalize( tile_pixels, rf_record_count( hits ), share );
    return tested;
}
