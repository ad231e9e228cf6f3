// The balance weights inside a tile: which hits see which second vertices, and with what density they would have sampled them.
#include "reuse/tile/tile_reuse.h"

#include "base/fault.h"
#include "reuse/tile/tile.h"
#include "reuse/tile/tile_chains.h"

#include <float.h>
#include <string.h>

// Sets the direction of hit i in a pairing, and ρ but for BSDF density and visibility; 0 where hit and vertex face away from
// each other.
static inline void connect( const RfVertexLanes* restrict x, const RfTileReuse* restrict reuse, RfPairingLanes* restrict pairing,
                            int i )
{
    const RfVertexLanes* restrict y = &reuse->second.lanes;
    int a = pairing->vertex[i];
    RfVec3 ng = RF_GET3( x->ng, i );
    RfVec3 n = RF_GET3( x->n, i );
    RfVec3 from = rf_madd( RF_GET3( x->p, i ), ng, x->offset[i] );
    RfVec3 to_vertex = rf_sub( RF_GET3( y->p, a ), from );
    float d2 = rf_maxf( rf_dot( to_vertex, to_vertex ), FLT_MIN );
    RfVec3 wi = rf_scale( to_vertex, 1.0f / sqrtf( d2 ) );
    float cos_y = -rf_dot( RF_GET3( y->ng, a ), wi );
    float geometry = cos_y / d2 * reuse->second.own_distance2_cos[a];
    // & of int: the loop stays free of branches
    int sees = (int)( pairing->weight[i] > 0.0f ) & (int)( cos_y > 0.0f ) & (int)( rf_dot( n, wi ) > 0.0f ) &
               (int)( rf_dot( ng, wi ) > 0.0f ) & (int)( geometry < 1e18f );
    // the BSDFs need a valid direction in every lane
    pairing->wi[0][i] = sees ? wi.x : n.x;
    pairing->wi[1][i] = sees ? wi.y : n.y;
    pairing->wi[2][i] = sees ? wi.z : n.z;
    pairing->weight[i] = sees ? geometry : 0.0f;
}

static void connect_neighbours( const RfVertexLanes* restrict x, const RfTileReuse* restrict reuse,
                                RfPairingLanes* restrict pairing )
{
    int count = rf_record_count( x );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
        connect( x, reuse, pairing, i );
}

// The same for pairing s where roulette has left few second vertices.
static void connect_few( const RfVertexLanes* x, RfTileReuse* reuse, int s )
{
    RfPairingLanes* pairing = reuse->pairings + s;
    for ( int c = 0; c < 3; ++c )
        memcpy( pairing->wi[c], x->n[c], (size_t)rf_record_count( x ) * sizeof( float ) );
    for ( int a = 0; a < rf_record_count( &reuse->second.lanes ); ++a )
    {
        if ( reuse->second.owner[a] >= 0 && s < reuse->hits.size[reuse->second.owner[a]] )
            connect( x, reuse, pairing, rf_receiver( reuse, a, s ) );
    }
}

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
    for ( int i = 0; i < x->first[RF_BSDF_FIRST_GLOSSY] && x->guide != NULL; ++i )
    {
        float cosine = rf_maxf( rf_dot( RF_GET3( x->n, i ), RF_GET3( pairing->wi, i ) ), 0.0f );
        pairing->guided[i] = pdf[i] > 0.0f ? RF_INV_PI * cosine / pdf[i] : 0.0f;
    }
}

// Connections to be tested: each is a segment in the scratch, whose visibility multiplies the weight of a hit in a pairing.
typedef struct Queue
{
    const RfTracer* tracer;
    RfLaneScratch* scratch;
    RfTileReuse* reuse;
    uint64_t tested;
    int count;
    int32_t pairing[RF_PATCH_PIXELS], hit[RF_PATCH_PIXELS];
} Queue;

// Connections through panes have the part q of the density, and what they carry is multiplied by κ.
static void test_past_panes( Queue* q, const float* const o[3], const float* const d[3] )
{
    RfLaneScratch* s = q->scratch;
    RfPaneLanes panes = { .probability = s->pdf, .weight = { s->f[0], s->f[1], s->f[2] } };
    rf_trace_segments_past_panes( q->tracer, q->count, o, d, s->visible, &panes );
    for ( int k = 0; k < q->count; ++k )
    {
        s->visible[k] *= panes.probability[k];
        for ( int c = 0; c < 3; ++c )
            q->reuse->pairings[q->pairing[k]].pane_weight[c][q->hit[k]] = panes.weight[c][k];
    }
}

static void touch_connections( Queue* q, const float* const o[3], const float* const d[3] )
{
    uint8_t touched[RF_LANES];
    rf_touch_by_segments( q->tracer, q->count, o, d, 1.0f, q->scratch->visible, touched );
    for ( int k = 0; k < q->count; ++k )
    {
        if ( !touched[k] )
            continue;
        RfPairingLanes* t = q->reuse->pairings + q->pairing[k];
        t->touched[q->hit[k]] = 1;
        t->any_touched = true;
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
    if ( q->reuse->split && !q->reuse->own->beyond.caustics )
        touch_connections( q, o, d );
    for ( int k = 0; k < q->count; ++k )
        q->reuse->pairings[q->pairing[k]].weight[q->hit[k]] *= s->visible[k];
    q->tested += (uint64_t)q->count;
    q->count = 0;
}

static inline RfVec3 lifted( const RfVertexLanes* v, int i )
{
    RfVec3 ng = RF_GET3( v->ng, i );
    return rf_madd( RF_GET3( v->p, i ), ng, v->offset[i] );
}

static void lift_hits( const RfVertexLanes* x, RfTileReuse* reuse )
{
    int count = rf_record_count( x );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 p = lifted( x, i );
        RF_PUT3( reuse->hits.lifted, i, p );
    }
}

// Queues the segment from a point to a hit, unless its weight in the pairing is 0.
static inline void queue_segment( Queue* q, RfVec3 from, int pairing, int hit )
{
    const RfTileReuse* reuse = q->reuse;
    RfLaneScratch* s = q->scratch;
    int k = q->count;
    RF_PUT3( s->o, k, from );
    s->d[0][k] = reuse->hits.lifted[0][hit] - from.x;
    s->d[1][k] = reuse->hits.lifted[1][hit] - from.y;
    s->d[2][k] = reuse->hits.lifted[2][hit] - from.z;
    q->pairing[k] = pairing;
    q->hit[k] = hit;
    q->count += reuse->pairings[pairing].weight[hit] != 0.0f;
    if ( q->count == RF_PATCH_PIXELS )
        test_segments( q );
}

// Tests the connections of paths to their own second vertex, which alpha-blended surfaces may cover. Their rays carry κ
// already. Since the path did get through, no weight becomes 0.
static void test_own_paths( Queue* q, int hits )
{
    const RfSecondVertices* second = &q->reuse->second;
    float* weight = q->reuse->pairings[0].weight;
    float least[RF_LANES];
    for ( int i = 0; i < hits; ++i )
        least[i] = 1e-12f * weight[i];
    for ( int a = 0; a < rf_record_count( &second->lanes ); ++a )
    {
        if ( second->owner[a] >= 0 )
            queue_segment( q, lifted( &second->lanes, a ), 0, second->owner[a] );
    }
    test_segments( q );
    for ( int i = 0; i < hits; ++i )
        weight[i] = rf_maxf( weight[i], least[i] );
}

// Queues the segments from a second vertex to the other hits of its tile.
static void queue_vertex( Queue* q, int a )
{
    const RfTileHits* hits = &q->reuse->hits;
    RfVec3 from = lifted( &q->reuse->second.lanes, a );
    int own = q->reuse->second.owner[a], size = hits->size[own], rank = hits->rank[own];
    const int32_t* member = hits->member + hits->begin[own];
    for ( int k = 0; k < size; ++k )
    {
        int pairing = rank >= k ? rank - k : rank - k + size;
        if ( pairing > 0 )
            queue_segment( q, from, pairing, member[k] );
    }
}

// Tests each connection of a tile once, vertex by vertex.
static uint64_t test_connections( const RfTileReuseSettings* settings, const RfVertexLanes* x, RfWavefront* wavefront,
                                  RfTileReuse* reuse )
{
    Queue q = { .tracer = settings->path->tracer, .scratch = &wavefront->scratch, .reuse = reuse };
    const RfVertexLanes* y = &reuse->second.lanes;
    lift_hits( x, reuse );
    if ( rf_tracer_is_partial( q.tracer ) && rf_tracer_is_blended( q.tracer ) )
        test_own_paths( &q, rf_record_count( x ) );
    for ( int a = 0; a < y->count; ++a )
    {
        if ( reuse->second.owner[a] >= 0 && !rf_is_parallel_chain( reuse, a ) )
            queue_vertex( &q, a );
    }
    test_segments( &q );
    return q.tested;
}

// ρ ↦ ρ / Σ ρ over the hits that could have sampled the vertex.
static void normalize_weights( int tile_pixels, int hits, RfTileReuse* reuse )
{
    float* restrict sum = reuse->second.sum;
    memset( sum, 0, ( (size_t)reuse->second.lanes.count + 1 ) * sizeof( float ) );
    for ( int s = 0; s < tile_pixels; ++s )
    {
        const RfPairingLanes* pairing = reuse->pairings + s;
        for ( int i = 0; i < hits; ++i )
        {
            if ( pairing->weight[i] > 0.0f ) // most are 0 after roulette on paths
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
            all = all > 0.0f && !RF_FAULT( normalised_tiles ) ? all : 1.0f;
            pairing->weight[i] = rf_mixture_share( pairing->weight[i], all );
        }
        rf_note_weights( pairing->weight, hits, 1.0f );
    }
}

uint64_t rf_weight_pairings( const RfTileReuseSettings* settings, const RfVertexLanes* hits, float* const scattered[3],
                             RfWavefront* wavefront, RfTileReuse* reuse )
{
    int count = rf_record_count( hits );
    for ( int s = 0; s < settings->tile_pixels && reuse->split; ++s )
    {
        memset( reuse->pairings[s].touched, 0, (size_t)count );
        reuse->pairings[s].any_touched = false;
    }
    // pairing 0 is the path as it was sampled
    for ( int c = 0; c < 3; ++c )
        memcpy( reuse->pairings[0].wi[c], scattered[c], (size_t)count * sizeof( float ) );
    for ( int s = 0; s < settings->tile_pixels; ++s )
    {
        if ( s > 0 && settings->path_roulette )
            connect_few( hits, reuse, s );
        else if ( s > 0 )
            connect_neighbours( hits, reuse, reuse->pairings + s );
        if ( s > 0 && settings->chain_light )
            rf_aim_at_chains( scattered, s, reuse );
        multiply_densities( hits, reuse->pairings + s, wavefront->scratch.pdf );
    }
    uint64_t tested = test_connections( settings, hits, wavefront, reuse );
    tested += rf_follow_chain_light( settings, wavefront, reuse );
    normalize_weights( settings->tile_pixels, count, reuse );
    return tested;
}
