// Tells the light that is kept apart, since it holds in one frame alone or is a caustic, from the rest.
#include "path/own_light.h"

#include <math.h>
#include <string.h>

// Rays and segments to be tested, packed.
typedef struct Packed
{
    int count;
    int32_t of[RF_LANES];
    RF_ALIGN float o[3][RF_LANES];
    float d[3][RF_LANES];
    uint8_t touched[RF_LANES];
} Packed;

static void pack( Packed* p, int of, const float o[3], const float d[3] )
{
    for ( int c = 0; c < 3; ++c )
    {
        p->o[c][p->count] = o[c];
        p->d[c][p->count] = d[c];
    }
    p->of[p->count++] = of;
}

// Tests what is packed, and marks what it is of.
static void test( const RfTracer* tracer, Packed* p, float length, uint8_t* touched )
{
    if ( p->count == 0 )
        return;
    const float *o[3] = { p->o[0], p->o[1], p->o[2] }, *d[3] = { p->d[0], p->d[1], p->d[2] };
    memset( p->touched, 0, (size_t)p->count );
    rf_find_swept( tracer, p->count, o, d, length, p->touched );
    for ( int k = 0; k < p->count; ++k )
        touched[p->of[k]] |= p->touched[k];
}

// The ways of the rays to their vertices, which end off the surface: light samples and the connections of tiles end there too,
// and all must class a segment alike.
static void pack_ways( const RfTracer* tracer, const RfRayLanes* rays, const RfVertexLanes* v, const uint32_t* triangle,
                       uint8_t* touched, Packed* out )
{
    out->count = 0;
    for ( int i = 0; i < v->count; ++i )
    {
        int r = v->ray[i], slot = v->slot[i];
        touched[slot] |= rf_is_moving( tracer, triangle[r] );
        if ( touched[slot] )
            continue;
        float o[3], d[3];
        for ( int c = 0; c < 3; ++c )
        {
            o[c] = rays->o[c][r];
            d[c] = v->p[c][i] + v->ng[c][i] * v->offset[i] - o[c];
        }
        pack( out, slot, o, d );
    }
}

static void pack_misses( const RfRayLanes* rays, const uint32_t* triangle, const uint8_t* touched, Packed* out )
{
    out->count = 0;
    for ( int r = 0; r < rays->count; ++r )
    {
        if ( triangle[r] != RF_MISS || touched[rays->slot[r]] )
            continue;
        pack( out, rays->slot[r], ( float[3] ){ rays->o[0][r], rays->o[1][r], rays->o[2][r] },
              ( float[3] ){ rays->d[0][r], rays->d[1][r], rays->d[2][r] } );
    }
}

void rf_touch_by_rays( const RfTracer* tracer, const RfRayLanes* rays, const RfVertexLanes* vertices, const uint32_t* triangle,
                       uint8_t* touched )
{
    Packed packed;
    pack_ways( tracer, rays, vertices, triangle, touched, &packed );
    test( tracer, &packed, 1.0f, touched );
    if ( !rf_has_sky( rf_tracer_lights( tracer ) ) )
        return;
    pack_misses( rays, triangle, touched, &packed );
    test( tracer, &packed, INFINITY, touched );
}

void rf_touch_by_segments( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], float length,
                           const float* visible, uint8_t* touched )
{
    for ( int k = 0; k < count; ++k )
        touched[k] = !( visible[k] > 0.0f ); // is not tested
    rf_find_swept( tracer, count, o, d, length, touched );
    for ( int k = 0; k < count; ++k )
        touched[k] = visible[k] > 0.0f ? touched[k] : 0;
}

void rf_begin_caustics( int count, RfOwnLight* own )
{
    own->caustics = true;
    memset( own->touched, 0, (size_t)count );
    memset( own->seen, 1, (size_t)count );
}

void rf_note_caustics( const RfVertexLanes* v, const float* pdf, RfOwnLight* own )
{
    for ( int kind = 0; kind < RF_BSDF_KIND_COUNT; ++kind )
    {
        for ( int i = v->first[kind]; i < v->first[kind + 1]; ++i )
        {
            int slot = v->slot[i];
            bool delta = kind >= RF_BSDF_FIRST_SPECULAR && pdf[i] >= RF_DELTA_PDF; // glass over a base
            bool throws = delta || rf_throws_caustics( v, (RfBsdfKind)kind, i );
            own->seen[slot] = ( throws || kind >= RF_BSDF_FIRST_SPECULAR ) && own->seen[slot];
            own->touched[slot] = throws && !own->seen[slot];
        }
    }
}

void rf_find_lit_caustics( const RfOwnLight* own, const RfVertexLanes* v, uint8_t* touched )
{
    for ( int kind = 0; kind < RF_BSDF_KIND_COUNT; ++kind )
    {
        for ( int i = v->first[kind]; i < v->first[kind + 1]; ++i )
            touched[i] = !own->seen[v->slot[i]] && rf_throws_caustics( v, (RfBsdfKind)kind, i );
    }
}

void rf_split_arrival( const uint8_t* touched, int count, RfArrivalLanes* held, RfArrivalLanes* own )
{
    memcpy( own->light_pdf, held->light_pdf, (size_t)count * sizeof( float ) );
    own->scattered = held->scattered;
    for ( int c = 0; c < 3; ++c )
    {
        float* restrict a = held->a[c], * restrict b = held->b[c], * restrict own_a = own->a[c], * restrict own_b = own->b[c];
#pragma omp simd
        for ( int i = 0; i < count; ++i )
        {
            own_a[i] = touched[i] ? a[i] : 0.0f;
            own_b[i] = touched[i] ? b[i] : 0.0f;
            a[i] = touched[i] ? 0.0f : a[i];
            b[i] = touched[i] ? 0.0f : b[i];
        }
    }
}

bool rf_any_arrives( const RfArrivalLanes* arrival, int first, int end )
{
    for ( int i = first; i < end; ++i )
    {
        if ( arrival->a[0][i] + arrival->a[1][i] + arrival->a[2][i] + arrival->b[0][i] + arrival->b[1][i] + arrival->b[2][i] !=
             0.0f ) // not a number counts, too
            return true;
    }
    return false;
}
