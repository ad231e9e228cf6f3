// The balance weights of the pairs in a tile: which hits see which second
// vertices, and with what density they would have found them.
#include "reuse/tile_reuse.h"

#include <string.h>

// Directions of a turn, and ρ but for the density and the visibility; 0 where
// the two turn away from each other.
static void look_at_mates( const RfVertexLanes* restrict x, const RfTileReuse* restrict share, RfPairingLanes* restrict turn )
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
        // & of int: the loop stays free of branches
        int sees = (int)( turn->weight[i] > 0.0f ) & (int)( cos_y > 0.0f ) & (int)( rf_dot( n, wi ) > 0.0f ) &
                   (int)( rf_dot( ng, wi ) > 0.0f ) & (int)( geometry < 1e18f );
        // a direction always, be it to no avail: the BSDFs want one
        turn->wi[0][i] = sees ? wi.x : n.x;
        turn->wi[1][i] = sees ? wi.y : n.y;
        turn->wi[2][i] = sees ? wi.z : n.z;
        turn->weight[i] = sees ? geometry : 0.0f;
    }
}

static void multiply_densities( const RfVertexLanes* x, RfPairingLanes* turn, float* pdf )
{
    const float* wo[3] = { x->wo[0], x->wo[1], x->wo[2] };
    const float* wi[3] = { turn->wi[0], turn->wi[1], turn->wi[2] };
    for ( int kind = 0; kind < RF_BSDF_FIRST_UNEVALUABLE; ++kind )
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

static void lift_hits( const RfVertexLanes* x, RfTileReuse* share )
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
static inline void queue_segment( Queue* q, const RfTileReuse* share, RfVec3 from, int hit, float* weight )
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
    q->count += *weight != 0.0f;
    if ( q->count == RF_PATCH_PIXELS )
        test_segments( q );
}

// Its own path found the vertex; where surfaces let a part of the light through, it
// did so with a chance, which is not nothing.
static void test_own( Queue* q, int hits, RfTileReuse* share )
{
    float* weight = share->turns[0].weight;
    float least[RF_LANES];
    for ( int i = 0; i < hits; ++i )
        least[i] = 1e-12f * weight[i];
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

// Connections to hits that would hardly have found the vertex are worth little,
// yet cost a ray as the others do. Where their density is below this part of
// the largest they are left out of the balance heuristic (Veach's cutoff heuristic,
// by densities that know of no visibility, so that it can be said before a ray is
// traced) and take what the others find there by Russian roulette (PR section 3.6).
#define CUTOFF 0.1f

// The pairs of one vertex: member k of the tile, whose own path found it last.
typedef struct Pairs
{
    int count;
    const int32_t* hit;
    float* weight[RF_MAX_TILE_PIXELS];
} Pairs;

static Pairs list_pairs( RfTileReuse* share, int a )
{
    int own = share->owner[a];
    Pairs p = { share->size[own], share->member + share->begin[own], { NULL } };
    for ( int k = 0, s = share->rank[own]; k<p.count; ++k, s = s> 0 ? s - 1 : p.count - 1 )
        p.weight[k] = share->turns[s].weight + p.hit[k];
    return p;
}

static float largest( const Pairs* p )
{
    float most = 0.0f;
    for ( int k = 0; k < p->count; ++k )
        most = rf_maxf( most, *p->weight[k] );
    return most;
}

static void queue_pair( Queue* q, const RfTileReuse* share, const Pairs* p, RfVec3 from, int k, int own )
{
    if ( k != own )
        queue_segment( q, share, from, p->hit[k], p->weight[k] );
}

// Weights of pairs that are left out become negative, or 0 where the roulette
// takes them.
static void play_roulette( Queue* q, RfRandomKey key, RfTileReuse* share, int a )
{
    Pairs p = list_pairs( share, a );
    float limit = CUTOFF * largest( &p );
    RfVec3 from = lifted( &share->second, a );
    int own = share->rank[share->owner[a]];
    bool own_counts = *p.weight[own] >= limit;
    share->late[a] = own_counts ? 0.0f : limit;
    for ( int k = 0; k < p.count; ++k )
    {
        float w = *p.weight[k];
        if ( w < limit && !own_counts )
            continue; // see look_again
        if ( w < limit )
            *p.weight[k] = rf_random( key, RF_DIMENSION_CONNECTIONS + (uint32_t)k ) * limit < w ? -limit : 0.0f;
        queue_pair( q, share, &p, from, k, own );
    }
}

// A vertex whose own path was left out itself: it serves nobody if one that counts
// sees it, for that one finds such vertices as well; else all count.
static void look_again( Queue* q, RfTileReuse* share, int a )
{
    Pairs p = list_pairs( share, a );
    RfVec3 from = lifted( &share->second, a );
    int own = share->rank[share->owner[a]];
    bool served = false;
    for ( int k = 0; k < p.count; ++k )
        served |= *p.weight[k] >= share->late[a];
    for ( int k = 0; k < p.count; ++k )
    {
        if ( served )
            *p.weight[k] = 0.0f;
        else
            queue_pair( q, share, &p, from, k, own );
    }
}

static void queue_all( Queue* q, RfTileReuse* share, int a )
{
    RfVec3 from = lifted( &share->second, a );
    int own = share->owner[a], size = share->size[own];
    const int32_t* member = share->member + share->begin[own];
    for ( int k = 0, s = share->rank[own]; k<size; ++k, s = s> 0 ? s - 1 : size - 1 )
    {
        if ( s > 0 )
            queue_segment( q, share, from, member[k], share->turns[s].weight + member[k] );
    }
}

// All connections of a tile once, from each second vertex in turn. Shiny
// vertices have no roulette: what they send to a hit that is left out would not
// be bounded by what they send to the others.
static uint64_t test_connections( const RfTileReuseSettings* settings, const RfVertexLanes* x, RfWavefront* walk,
                                  RfTileReuse* share )
{
    Queue q = { .tracer = settings->walk->tracer, .scratch = &walk->scratch };
    const RfVertexLanes* y = &share->second;
    bool blended = rf_tracer_is_blended( q.tracer );
    int gamble = settings->roulette && !blended ? y->first[RF_BSDF_PHONG] : 0;
    lift_hits( x, share );
    if ( blended )
        test_own( &q, rf_record_count( x ), share );
    for ( int a = 0; a < rf_record_count( y ); ++a )
    {
        if ( share->owner[a] < 0 )
            continue;
        RfRandomKey key = { walk->key_a[y->slot[a]], walk->key_b[y->slot[a]] };
        if ( a < gamble )
            play_roulette( &q, key, share, a );
        else
            queue_all( &q, share, a );
    }
    test_segments( &q );
    for ( int a = 0; a < gamble; ++a )
    {
        if ( share->owner[a] >= 0 && share->late[a] > 0.0f )
            look_again( &q, share, a );
    }
    test_segments( &q );
    return q.tested;
}

// ρ ↦ ρ / Σ ρ over the hits that could have found the vertex.
static void normalize( int tile_pixels, int hits, RfTileReuse* share )
{
    float* restrict sum = share->sum;
    memset( sum, 0, ( (size_t)share->second.count + 1 ) * sizeof( float ) );
    for ( int s = 0; s < tile_pixels; ++s )
    {
        const RfPairingLanes* turn = share->turns + s;
        for ( int i = 0; i < hits; ++i )
            sum[turn->mate[i]] += rf_maxf( turn->weight[i], 0.0f );
    }
    for ( int s = 0; s < tile_pixels; ++s )
    {
        RfPairingLanes* turn = share->turns + s;
#pragma omp simd
        for ( int i = 0; i < hits; ++i )
            turn->weight[i] = turn->weight[i] != 0.0f ? fabsf( turn->weight[i] ) / sum[turn->mate[i]] : 0.0f;
    }
}

uint64_t rf_weight_pairings( const RfTileReuseSettings* settings, const RfVertexLanes* hits, float* const scattered[3],
                             RfWavefront* walk, RfTileReuse* share )
{
    int count = rf_record_count( hits );
    // turn 0 is the path as it was drawn
    for ( int c = 0; c < 3; ++c )
        memcpy( share->turns[0].wi[c], scattered[c], (size_t)count * sizeof( float ) );
    for ( int s = 0; s < settings->tile_pixels; ++s )
    {
        if ( s > 0 )
            look_at_mates( hits, share, share->turns + s );
        multiply_densities( hits, share->turns + s, walk->scratch.pdf );
    }
    uint64_t tested = test_connections( settings, hits, walk, share );
    normalize( settings->tile_pixels, count, share );
    return tested;
}
