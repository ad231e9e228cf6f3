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
        int a = share->mate[i] > 0 ? share->mate[i] : 0;
        RfVec3 ng = rf_vec3( x->ng[0][i], x->ng[1][i], x->ng[2][i] );
        RfVec3 n = rf_vec3( x->n[0][i], x->n[1][i], x->n[2][i] );
        RfVec3 from = rf_madd( rf_vec3( x->p[0][i], x->p[1][i], x->p[2][i] ), ng, x->offset[i] );
        RfVec3 way = rf_sub( rf_vec3( y->p[0][a], y->p[1][a], y->p[2][a] ), from );
        float d2 = rf_dot( way, way );
        RfVec3 wi = rf_scale( way, 1.0f / sqrtf( d2 ) );
        float cos_y = -rf_dot( rf_vec3( y->ng[0][a], y->ng[1][a], y->ng[2][a] ), wi );
        float geometry = cos_y / d2 * share->own_distance2_cos[a];
        int sees = ( share->mate[i] >= 0 ) & ( cos_y > 0.0f ) & ( rf_dot( n, wi ) > 0.0f ) & ( rf_dot( ng, wi ) > 0.0f ) &
                   ( geometry < 1e18f );
        // a direction always, be it to no avail: the BSDFs want one
        turn->wi[0][i] = sees ? wi.x : n.x;
        turn->wi[1][i] = sees ? wi.y : n.y;
        turn->wi[2][i] = sees ? wi.z : n.z;
        turn->weight[i] = sees ? geometry : 0.0f;
    }
}

// Turn 0 is the path as it was drawn.
static void look_at_own( int count, float* const scattered[3], const RfShare* share, RfTurnLanes* turn )
{
    for ( int c = 0; c < 3; ++c )
        memcpy( turn->wi[c], scattered[c], (size_t)count * sizeof( float ) );
    for ( int i = 0; i < count; ++i )
        turn->weight[i] = share->mate[i] >= 0 ? 1.0f : 0.0f;
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
    RfTurnLanes* turns;
    int count;
    uint64_t tested;
} Queue;

static void test_segments( Queue* q )
{
    RfLaneScratch* s = q->scratch;
    const float* o[3] = { s->o[0], s->o[1], s->o[2] };
    const float* d[3] = { s->d[0], s->d[1], s->d[2] };
    rf_trace_segments( q->tracer, q->count, o, d, s->visible );
    for ( int k = 0; k < q->count; ++k )
        q->turns[s->index[k] / RF_LANES].weight[s->index[k] % RF_LANES] *= s->visible[k];
    q->tested += (uint64_t)q->count;
    q->count = 0;
}

static inline RfVec3 lifted( const RfVertexLanes* v, int i )
{
    RfVec3 ng = rf_vec3( v->ng[0][i], v->ng[1][i], v->ng[2][i] );
    return rf_madd( rf_vec3( v->p[0][i], v->p[1][i], v->p[2][i] ), ng, v->offset[i] );
}

static void queue_segment( Queue* q, RfVec3 from, RfVec3 to, int turn, int hit )
{
    RfLaneScratch* s = q->scratch;
    RfVec3 d = rf_sub( to, from );
    s->o[0][q->count] = from.x;
    s->o[1][q->count] = from.y;
    s->o[2][q->count] = from.z;
    s->d[0][q->count] = d.x;
    s->d[1][q->count] = d.y;
    s->d[2][q->count] = d.z;
    s->index[q->count] = turn * RF_LANES + hit;
    q->count += 1;
    if ( q->count == RF_PATCH_PIXELS )
        test_segments( q );
}

// The hit that looks at vertex a in a turn.
static inline int looker( const RfShare* share, int a, int turn )
{
    int i = share->owner[a], at = share->rank[i] - turn;
    return share->member[share->begin[i] + at + ( at < 0 ? share->size[i] : 0 )];
}

// Its own path found the vertex; where surfaces let a part of the light through, it
// did so with a chance, which is not nothing.
static void test_own( Queue* q, const RfVertexLanes* x, const RfShare* share )
{
    const RfVertexLanes* y = &share->second;
    float weight[RF_LANES];
    memcpy( weight, q->turns[0].weight, sizeof weight );
    for ( int a = 0; a < rf_record_count( y ); ++a )
    {
        if ( share->owner[a] >= 0 )
            queue_segment( q, lifted( y, a ), lifted( x, share->owner[a] ), 0, share->owner[a] );
    }
    test_segments( q );
    for ( int i = 0; i < rf_record_count( x ); ++i )
        q->turns[0].weight[i] = rf_maxf( q->turns[0].weight[i], 1e-4f * weight[i] );
}

// All connections of a tile once, from each second vertex in turn.
static uint64_t test_connections( const RfTracer* tracer, const RfVertexLanes* x, RfLaneScratch* scratch, RfShare* share )
{
    Queue q = { tracer, scratch, share->turns, 0, 0 };
    if ( rf_tracer_is_blended( tracer ) )
        test_own( &q, x, share );
    const RfVertexLanes* y = &share->second;
    for ( int a = 0; a < rf_record_count( y ); ++a )
    {
        if ( share->owner[a] < 0 )
            continue;
        RfVec3 from = lifted( y, a );
        for ( int s = 1; s < share->size[share->owner[a]]; ++s )
        {
            int i = looker( share, a, s );
            if ( share->turns[s].weight[i] > 0.0f )
                queue_segment( &q, from, lifted( x, i ), s, i );
        }
    }
    test_segments( &q );
    return q.tested;
}

// ρ ↦ ρ / Σ ρ over the hits that could have found the vertex.
static void normalize( int tile_pixels, int hits, RfShare* share )
{
    memset( share->sum, 0, (size_t)share->second.count * sizeof( float ) );
    for ( int s = 0; s < tile_pixels; ++s )
    {
        rf_find_mates( share, s, hits );
        for ( int i = 0; i < hits; ++i )
        {
            if ( share->mate[i] >= 0 )
                share->sum[share->mate[i]] += share->turns[s].weight[i];
        }
    }
    for ( int s = 0; s < tile_pixels; ++s )
    {
        rf_find_mates( share, s, hits );
        float* weight = share->turns[s].weight;
        for ( int i = 0; i < hits; ++i )
            weight[i] = weight[i] > 0.0f ? weight[i] / share->sum[share->mate[i]] : 0.0f;
    }
}

uint64_t rf_weigh_turns( const RfWalkSettings* settings, int tile_pixels, const RfVertexLanes* hits, float* const scattered[3],
                         RfLaneScratch* scratch, RfShare* share )
{
    int count = rf_record_count( hits );
    for ( int s = 0; s < tile_pixels; ++s )
    {
        rf_find_mates( share, s, count );
        if ( s == 0 )
            look_at_own( count, scattered, share, share->turns );
        else
            look_at_mates( hits, share, share->turns + s );
        multiply_densities( hits, share->turns + s, scratch->pdf );
    }
    uint64_t tested = test_connections( settings->tracer, hits, scratch, share );
    normalize( tile_pixels, count, share );
    return tested;
}
