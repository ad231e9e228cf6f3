// Splits the mirrors and glass of a scene into a few boxes by the surface area they save.
#include "scene/chain_bounds.h"

#include "scene/moments.h"

#include <math.h>
#include <stdlib.h>

#define MARGIN 1e-5f   // of a box, over its distance from the origin and its size
#define LEAST_LESS 0.9 // area of the halves over that of the whole, where a box is split

// A box with its triangles.
typedef struct Part
{
    uint32_t begin, end;
    RfVec3 low, high;
    bool whole; // splitting it leaves out little
} Part;

static float component( RfVec3 v, int axis ) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static double area( const Part* part )
{
    RfVec3 e = rf_sub( part->high, part->low );
    return (double)e.x * (double)e.y + (double)e.y * (double)e.z + (double)e.z * (double)e.x;
}

// At one of the moments of the shutter.
static void get_corners( const RfScene* scene, int moment, uint32_t triangle, RfVec3 corners[3] )
{
    RfTriangleAt at = rf_locate_triangle( scene, triangle );
    for ( int k = 0; k < 3; ++k )
        corners[k] = at.placement == NULL ? rf_corner( at.triangles, triangle, k ) : rf_corner_at( scene, moment, &at, k );
}

static void bound( const RfScene* scene, const uint32_t* triangle, Part* part )
{
    RfVec3 low = { INFINITY, INFINITY, INFINITY }, high = { -INFINITY, -INFINITY, -INFINITY };
    for ( uint32_t i = part->begin; i < part->end; ++i )
    {
        RfVec3 p[3];
        for ( int k = 0; k < 3 * rf_moment_count( scene ); ++k )
        {
            if ( k % 3 == 0 )
                get_corners( scene, k / 3, triangle[i], p );
            low = rf_vec3( rf_minf( low.x, p[k % 3].x ), rf_minf( low.y, p[k % 3].y ), rf_minf( low.z, p[k % 3].z ) );
            high = rf_vec3( rf_maxf( high.x, p[k % 3].x ), rf_maxf( high.y, p[k % 3].y ), rf_maxf( high.z, p[k % 3].z ) );
        }
    }
    part->low = low;
    part->high = high;
}

// Splits a part in the middle of its longest side. False: that leaves out little.
static bool split( const RfScene* scene, uint32_t* triangle, Part* part, Part* other )
{
    RfVec3 e = rf_sub( part->high, part->low );
    int axis = e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
    float middle = 0.5f * ( component( part->low, axis ) + component( part->high, axis ) );
    uint32_t at = part->begin;
    for ( uint32_t i = part->begin; i < part->end; ++i )
    {
        RfVec3 p[3];
        get_corners( scene, 0, triangle[i], p );
        RfVec3 sum = rf_add( p[0], rf_add( p[1], p[2] ) );
        if ( component( sum, axis ) >= 3.0f * middle )
            continue;
        uint32_t swap = triangle[i];
        triangle[i] = triangle[at];
        triangle[at++] = swap;
    }
    if ( at == part->begin || at == part->end )
        return false;
    Part low = { .begin = part->begin, .end = at }, high = { .begin = at, .end = part->end };
    bound( scene, triangle, &low );
    bound( scene, triangle, &high );
    if ( area( &low ) + area( &high ) > LEAST_LESS * area( part ) )
        return false;
    *part = low;
    *other = high;
    return true;
}

// Splits the largest part, again and again.
static int split_all( const RfScene* scene, uint32_t* triangle, Part* parts )
{
    int count = 1;
    while ( count < RF_MAX_CHAIN_BOUNDS )
    {
        int largest = -1;
        for ( int k = 0; k < count; ++k )
            largest = !parts[k].whole && ( largest < 0 || area( parts + k ) > area( parts + largest ) ) ? k : largest;
        if ( largest < 0 )
            break;
        if ( split( scene, triangle, parts + largest, parts + count ) )
            count += 1;
        else
            parts[largest].whole = true;
    }
    return count;
}

static bool is_chain( const RfMaterial* m ) { return m->kind == RF_BSDF_GLASS && !m->thin; }

RfResult rf_bound_chains( const RfScene* scene, RfChainBounds* bounds, RfError* error )
{
    *bounds = ( RfChainBounds ){ 0 };
    uint32_t found = rf_list_triangles( scene, is_chain, NULL );
    if ( found == 0 )
        return RF_OK;
    uint32_t* triangle = malloc( found * sizeof *triangle );
    if ( triangle == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the bounds of %u triangles of mirrors and glass", found );
    Part parts[RF_MAX_CHAIN_BOUNDS] = { { .begin = 0, .end = found } };
    rf_list_triangles( scene, is_chain, triangle );
    bound( scene, triangle, parts );
    bounds->count = split_all( scene, triangle, parts );
    free( triangle );
    for ( int k = 0; k < bounds->count; ++k )
    {
        bounds->low[k] = parts[k].low;
        bounds->high[k] = parts[k].high;
    }
    return RF_OK;
}

// The interval in which a ray is between two planes, cut to [*near, *far].
static inline void cut( float low, float high, float o, float inverse, float* near, float* far )
{
    float a = ( low - o ) * inverse, b = ( high - o ) * inverse;
    *near = rf_maxf( *near, rf_minf( a, b ) );
    *far = rf_minf( *far, rf_maxf( a, b ) );
}

static inline float inverse_of( float d ) { return 1.0f / ( fabsf( d ) > 1e-12f ? d : 1e-12f ); }

static void meet( RfVec3 low, RfVec3 high, int count, const float* const o[3], const float* const d[3], float* restrict meets )
{
    const float* restrict ox = o[0], * restrict oy = o[1], * restrict oz = o[2];
    const float* restrict dx = d[0], * restrict dy = d[1], * restrict dz = d[2];
    float size = rf_length( rf_sub( high, low ) );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 from = rf_vec3( ox[i], oy[i], oz[i] );
        float margin = MARGIN * ( size + fabsf( from.x - low.x ) + fabsf( from.y - low.y ) + fabsf( from.z - low.z ) +
                                  fabsf( from.x ) + fabsf( from.y ) + fabsf( from.z ) );
        float near = 0.0f, far = 1e30f;
        cut( low.x - margin, high.x + margin, from.x, inverse_of( dx[i] ), &near, &far );
        cut( low.y - margin, high.y + margin, from.y, inverse_of( dy[i] ), &near, &far );
        cut( low.z - margin, high.z + margin, from.z, inverse_of( dz[i] ), &near, &far );
        meets[i] = near <= far ? 1.0f : meets[i];
    }
}

void rf_meet_chain_bounds( const RfChainBounds* bounds, int count, const float* const o[3], const float* const d[3],
                           float* meets )
{
    for ( int i = 0; i < count; ++i )
        meets[i] = 0.0f;
    for ( int k = 0; k < bounds->count; ++k )
        meet( bounds->low[k], bounds->high[k], count, o, d, meets );
}
