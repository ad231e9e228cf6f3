#include "trace/occluders.h"

#include "trace/tracer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BLOCK 16

// For each unit of length of ray and extent: how far from the plane both ends are, at least, and how far from the edges the ray
// crosses it. Some hundred roundings, and far above those of Embree. Rays at less than a degree from the plane are left to Embree.
#define PLANE_MARGIN 2e-5f
#define EDGE_MARGIN 1e-4f
#define LEAST_SINE 0.02f

// An occluder pays where it blocks one of RAYS_EACH rays that those before it do not; all of them, where they block one of RAYS_ALL.
#define RAYS_EACH 40
#define RAYS_ALL 8

#define MOST_CANDIDATES 256

// It learns after so many rays, then after twice as many, and so on.
#define FIRST_PERIOD 4096
#define LONGEST_PERIOD 262144
#define SAMPLE_RAYS 64 // the least number of rays for a sample of each call

// Corners of parallelograms meet up to as much of their extent.
#define CLOSED 1e-6f

// Segments, one in each lane. In the lanes beyond the last one that of lane 0.
typedef struct Lanes
{
    _Alignas( 64 ) float o[3][BLOCK], d[3][BLOCK];
    float length[BLOCK];
    int blocked[BLOCK];
} Lanes;

static void load( const float* const o[3], const float* const d[3], int first, int count, Lanes* s )
{
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( s->o[c], o[c] + first, (size_t)count * sizeof( float ) );
        memcpy( s->d[c], d[c] + first, (size_t)count * sizeof( float ) );
        for ( int i = count; i < BLOCK; ++i )
        {
            s->o[c][i] = s->o[c][0];
            s->d[c][i] = s->d[c][0];
        }
    }
#pragma omp simd
    for ( int i = 0; i < BLOCK; ++i )
    {
        s->length[i] = sqrtf( s->d[0][i] * s->d[0][i] + s->d[1][i] * s->d[1][i] + s->d[2][i] * s->d[2][i] );
        s->blocked[i] = i >= count;
    }
}

static inline float dot( RfVec3 a, float x, float y, float z ) { return a.x * x + a.y * y + a.z * z; }

// Marks the lanes that the occluder blocks. Returns how many lanes are blocked by now.
static int block( const RfOccluder* k, Lanes* s )
{
    int blocked = 0;
    RfVec3 p = k->p, n = k->n, a = k->a, b = k->b;
    float extent = k->extent, margin = k->margin, skew = k->skew;
#pragma omp simd reduction( + : blocked )
    for ( int i = 0; i < BLOCK; ++i )
    {
        float dx = s->d[0][i], dy = s->d[1][i], dz = s->d[2][i];
        float x = s->o[0][i] - p.x, y = s->o[1][i] - p.y, z = s->o[2][i] - p.z;
        float before = -dot( n, x, y, z ), way = dot( n, dx, dy, dz ); // distances along n
        before = way < 0.0f ? -before : before;
        way = fabsf( way );
        float reach = s->length[i] + extent, away = PLANE_MARGIN * reach;
        int crosses = ( way > LEAST_SINE * s->length[i] ) & ( before > away ) & ( way - before > away );
        float t = ( crosses ? before : 0.0f ) / ( crosses ? way : 1.0f );
        x += t * dx;
        y += t * dy;
        z += t * dz;
        float u = dot( a, x, y, z ), v = dot( b, x, y, z ), least = margin * reach;
        float most = rf_maxf( u + skew * v, v + skew * u );
        s->blocked[i] |= crosses & ( u > least ) & ( v > least ) & ( most < 1.0f - least );
        blocked += s->blocked[i];
    }
    return blocked;
}

int rf_list_open_segments( const RfOccluders* occluders, int count, const float* const o[3], const float* const d[3],
                           int32_t* open )
{
    int listed = 0;
    for ( int first = 0; first < count; first += BLOCK )
    {
        Lanes s;
        int lanes = count - first < BLOCK ? count - first : BLOCK, blocked = BLOCK - lanes;
        load( o, d, first, lanes, &s );
        for ( int k = 0; k < occluders->count && blocked < BLOCK; ++k )
            blocked = block( occluders->list + k, &s );
        for ( int i = 0; i < lanes; ++i )
        {
            open[listed] = first + i;
            listed += s.blocked[i] == 0;
        }
    }
    return listed;
}

// Whether hits on a triangle of the world are not looked at. Opaque ones stand first in the order, by number.
static bool is_opaque( const RfMeshBvh* mesh, uint32_t triangle )
{
    uint32_t from = 0, to = mesh->masked_first;
    if ( mesh->order == NULL )
        return true;
    while ( from < to )
    {
        uint32_t middle = from + ( to - from ) / 2;
        if ( mesh->order[middle] == triangle )
            return true;
        from = mesh->order[middle] < triangle ? middle + 1 : from;
        to = mesh->order[middle] < triangle ? to : middle;
    }
    return false;
}

static bool may_occlude( const RfTracer* tracer, uint32_t triangle )
{
    return triangle < tracer->known.count && is_opaque( &tracer->bvh.base, triangle );
}

static bool is_same( RfVec3 a, RfVec3 b ) { return a.x == b.x && a.y == b.y && a.z == b.z; }

// Whether another triangle shares an edge with the one of these corners, and makes a parallelogram of both. Then corner[0] becomes
// the one opposite that edge.
static bool completes( const RfTracer* tracer, uint32_t other, RfVec3 corner[3] )
{
    RfVec3 q[3];
    if ( !may_occlude( tracer, other ) )
        return false;
    for ( int k = 0; k < 3; ++k )
        q[k] = rf_triangle_corner( tracer->scene, other, k );
    for ( int i = 0; i < 9; ++i )
    {
        RfVec3 p = corner[i / 3], e1 = corner[( i / 3 + 1 ) % 3], e2 = corner[( i / 3 + 2 ) % 3], far = q[i % 3];
        RfVec3 r1 = q[( i + 1 ) % 3], r2 = q[( i + 2 ) % 3];
        bool shared = ( is_same( r1, e1 ) && is_same( r2, e2 ) ) || ( is_same( r1, e2 ) && is_same( r2, e1 ) );
        RfVec3 gap = rf_sub( rf_sub( far, e1 ), rf_sub( e2, p ) );
        float extent = rf_maxf( rf_length( rf_sub( e1, p ) ), rf_length( rf_sub( e2, p ) ) );
        if ( !shared || !( rf_length( gap ) <= CLOSED * extent ) )
            continue;
        corner[0] = p;
        corner[1] = e1;
        corner[2] = e2;
        return true;
    }
    return false;
}

static bool make_occluder( const RfTracer* tracer, uint32_t triangle, RfOccluder* k )
{
    if ( !may_occlude( tracer, triangle ) )
        return false;
    RfVec3 corner[3];
    for ( int c = 0; c < 3; ++c )
        corner[c] = rf_triangle_corner( tracer->scene, triangle, c );
    *k = ( RfOccluder ){ .skew = 1.0f, .triangle = { triangle, triangle } };
    for ( uint32_t other = triangle - 1; other != triangle + 3; other += 2 )
    {
        if ( k->skew > 0.0f && completes( tracer, other, corner ) )
        {
            k->skew = 0.0f;
            k->triangle[1] = other;
        }
    }
    RfVec3 e1 = rf_sub( corner[1], corner[0] ), e2 = rf_sub( corner[2], corner[0] );
    double twice;
    k->p = corner[0];
    k->n = rf_unit_cross( e1, e2, &twice );
    if ( !( twice > 0.0 ) )
        return false;
    k->a = rf_scale( rf_cross( e2, k->n ), (float)( 1.0 / twice ) );
    k->b = rf_scale( rf_cross( k->n, e1 ), (float)( 1.0 / twice ) );
    k->extent = rf_length( e1 ) + rf_length( e2 );
    k->margin = EDGE_MARGIN * ( rf_length( k->a ) + rf_length( k->b ) );
    return k->margin * k->extent < 0.1f; // slivers block nothing
}

static float area_of( const RfTracer* tracer, uint32_t triangle )
{
    const RfTriangleRecord* t = tracer->known.records + triangle;
    return rf_length( rf_cross( t->e1, t->e2 ) );
}

typedef struct Candidate
{
    float area;
    uint32_t triangle;
} Candidate;

static bool is_smaller( Candidate a, Candidate b ) { return a.area < b.area; }

// The smallest of a heap is its first.
static void sift_down( Candidate* heap, int count, Candidate in )
{
    int at = 0;
    for ( int child = 1; child < count; child = 2 * at + 1 )
    {
        child += child + 1 < count && is_smaller( heap[child + 1], heap[child] );
        if ( !is_smaller( heap[child], in ) )
            break;
        heap[at] = heap[child];
        at = child;
    }
    heap[at] = in;
}

static int compare_areas( const void* a, const void* b )
{
    const Candidate *x = a, *y = b;
    if ( x->area != y->area )
        return x->area > y->area ? -1 : 1;
    return ( x->triangle > y->triangle ) - ( x->triangle < y->triangle );
}

static int find_largest( const RfTracer* tracer, Candidate largest[MOST_CANDIDATES] )
{
    for ( int i = 0; i < MOST_CANDIDATES; ++i )
        largest[i] = ( Candidate ){ 0.0f, 0 };
    for ( uint32_t t = 0; t < tracer->known.count; ++t )
    {
        Candidate c = { area_of( tracer, t ), t };
        if ( is_smaller( largest[0], c ) && may_occlude( tracer, t ) )
            sift_down( largest, MOST_CANDIDATES, c );
    }
    qsort( largest, MOST_CANDIDATES, sizeof *largest, compare_areas );
    int count = 0;
    while ( count < MOST_CANDIDATES && largest[count].area > 0.0f )
        ++count;
    return count;
}

static bool has_triangle( const RfOccluderList* list, uint32_t triangle )
{
    bool has = false;
    for ( int i = 0; i < list->count; ++i )
        has = has || list->list[i].triangle[0] == triangle || list->list[i].triangle[1] == triangle;
    return has;
}

RfOccluderList* rf_find_occluders( const RfTracer* tracer )
{
    Candidate largest[MOST_CANDIDATES];
    // other scales are those of scenes whose products leave the range of floats
    int count = tracer->bvh.base.scale == 1.0f ? find_largest( tracer, largest ) : 0;
    RfOccluderList* found = malloc( sizeof *found + (size_t)count * sizeof *found->list );
    if ( found == NULL )
        return NULL;
    found->count = 0;
    for ( int i = 0; i < count; ++i )
    {
        if ( !has_triangle( found, largest[i].triangle ) )
            found->count += make_occluder( tracer, largest[i].triangle, found->list + found->count );
    }
    return found;
}

// Which of the samples an occluder blocks.
static uint64_t block_samples( const RfOccluder* k, Lanes s[RF_OCCLUDER_SAMPLES / BLOCK] )
{
    uint64_t bits = 0;
    for ( int b = 0; b < RF_OCCLUDER_SAMPLES / BLOCK; ++b )
    {
        memset( s[b].blocked, 0, sizeof s[b].blocked );
        block( k, s + b );
        for ( int i = 0; i < BLOCK; ++i )
            bits |= (uint64_t)( s[b].blocked[i] != 0 ) << ( BLOCK * b + i );
    }
    return bits;
}

// Takes one by one the occluders that block most of the samples that are left.
static void learn( RfOccluders* all )
{
    Lanes s[RF_OCCLUDER_SAMPLES / BLOCK];
    uint64_t blocks[MOST_CANDIDATES], left = ~UINT64_C( 0 );
    const float *o[3] = { all->o[0], all->o[1], all->o[2] }, *d[3] = { all->d[0], all->d[1], all->d[2] };
    for ( int b = 0; b < RF_OCCLUDER_SAMPLES / BLOCK; ++b )
        load( o, d, BLOCK * b, BLOCK, s + b );
    for ( int k = 0; k < all->of->count; ++k )
        blocks[k] = block_samples( all->of->list + k, s );
    float rays_each = (float)all->blocked / (float)all->rays / (float)RF_OCCLUDER_SAMPLES;
    all->count = 0;
    for ( int most = 0; all->count < RF_MOST_OCCLUDERS; most = 0 )
    {
        int best = 0;
        for ( int k = 0; k < all->of->count; ++k )
        {
            int blocked = __builtin_popcountll( blocks[k] & left );
            best = blocked > most ? k : best;
            most = blocked > most ? blocked : most;
        }
        if ( most < 2 || (float)most * rays_each * RAYS_EACH < 1.0f )
            break;
        left &= ~blocks[best];
        all->list[all->count++] = all->of->list[best];
    }
    if ( (float)__builtin_popcountll( ~left ) * rays_each * RAYS_ALL < 1.0f )
        all->count = 0;
}

// Counts, and takes some of the blocked rays as samples: as many of each call.
static void note_blocked( RfOccluders* all, int count, const float* const o[3], const float* const d[3], const float* visible )
{
    int blocked = 0;
    for ( int i = 0; i < count; ++i )
        blocked += visible[i] == 0.0f;
    all->rays += (uint32_t)count;
    all->blocked += (uint32_t)blocked;
    int wanted = ( count + SAMPLE_RAYS - 1 ) / SAMPLE_RAYS;
    for ( int i = 0, n = 0; i < count && all->samples < RF_OCCLUDER_SAMPLES && wanted > 0; ++i )
    {
        if ( visible[i] != 0.0f || n++ % ( blocked / wanted + 1 ) != 0 )
            continue;
        for ( int c = 0; c < 3; ++c )
        {
            all->o[c][all->samples] = o[c][i];
            all->d[c][all->samples] = d[c][i];
        }
        ++all->samples;
    }
}

void rf_trace_shadow_rays( const RfTracer* tracer, RfOccluders* all, int count, const float* const o[3], const float* const d[3],
                           float* visible, const RfPaneLanes* panes )
{
    int32_t open[RF_MOST_SHADOW_RAYS];
    if ( all->of != tracer->occluders )
        *all = ( RfOccluders ){ .of = tracer->occluders, .period = FIRST_PERIOD };
    int listed = all->count > 0 ? rf_list_open_segments( all, count, o, d, open ) : count;
    for ( int i = 0; i < count && listed < count; ++i )
        visible[i] = 0.0f;
    rf_trace_listed_segments( tracer, listed, listed < count ? open : NULL, o, d, visible, panes );
    note_blocked( all, count, o, d, visible );
    if ( all->rays < all->period )
        return;
    if ( all->samples == RF_OCCLUDER_SAMPLES || all->rays >= LONGEST_PERIOD )
    {
        if ( all->samples == RF_OCCLUDER_SAMPLES )
            learn( all );
        else
            all->count = 0;
        all->period = all->period < LONGEST_PERIOD ? 2 * all->period : LONGEST_PERIOD;
        all->rays = all->blocked = 0;
        all->samples = 0;
    }
}
