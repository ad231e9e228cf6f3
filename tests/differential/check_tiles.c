// The weights of tile reuse: whether the path that found a vertex or a neighbour would have, by density and geometry term
// (src/reuse/estimators.md, E4), down to hits and vertices that almost touch.
#include "differential/differential.h"
#include "differential/reference.h"

#include "reuse/tile/tile_reuse.h"
#include "support/render_support.h"
#include "support/scene_builder.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>

#define PAIRS 500 // tiles of two hits

// x = the own hit and its normal, the neighbour's, the vertex and its normal; y = weights of both for the vertex.
static void reference( const double* x, double* y )
{
    double density[2];
    D3 vertex = d3_at( x + 12 ), normal = d3_unit( d3_at( x + 15 ) );
    for ( int k = 0; k < 2; ++k )
    {
        D3 n = d3_unit( d3_at( x + 6 * k + 3 ) ), way = d3_sum( vertex, -1.0, d3_at( x + 6 * k ) );
        double distance = d3_length( way ), cos_x = cos( d3_angle( n, way ) ), cos_y = -cos( d3_angle( normal, way ) );
        // per area at the vertex, of a cosine lobe; the code's own range of G / G_own ends at 1e18
        density[k] = cos_x > 0.0 && cos_y > 0.0 ? cos_x * cos_y / ( distance * distance ) : 0.0;
    }
    y[0] = density[0] / ( density[0] + density[1] );
    y[1] = density[1] / ( density[0] + density[1] );
}

static void describe( const double* x, char* text, size_t size )
{
    D3 own = d3_sum( d3_at( x + 12 ), -1.0, d3_at( x ) ), other = d3_sum( d3_at( x + 12 ), -1.0, d3_at( x + 6 ) );
    D3 n = d3_at( x + 15 ), back = { -n.x, -n.y, -n.z };
    snprintf( text, size, "own distance %.3g m at %.6g°, neighbour's %.3g m at %.6g°, %.2g m from the origin", d3_length( own ),
              57.29577951308232 * d3_angle( own, back ), d3_length( other ), 57.29577951308232 * d3_angle( other, back ),
              d3_length( d3_at( x + 12 ) ) );
}

static void put3( float ( *to )[RF_LANES], int i, RfVec3 v )
{
    to[0][i] = v.x;
    to[1][i] = v.y;
    to[2][i] = v.z;
}

static RfVec3 get3( float ( *from )[RF_LANES], int i ) { return rf_vec3( from[0][i], from[1][i], from[2][i] ); }

// A hit that sees the vertex, at a random distance in a random direction.
static void put_hit( RfVertexLanes* hits, int i, RfVec3 vertex, RfVec3 normal, uint32_t stream, long k )
{
    RfVec3 way = random_around( normal, stream, k, 10 );
    if ( rf_dot( way, normal ) < 0.0f )
        way = rf_scale( way, -1.0f );
    RfVec3 n = random_around( rf_scale( way, -1.0f ), stream, k, 20 );
    put3( hits->p, i, rf_madd( vertex, way, (float)random_wide( 1e-12, 1e3, stream, k, 30 ) ) );
    put3( hits->n, i, n );
    put3( hits->ng, i, n );
    put3( hits->wo, i, n );
    put3( hits->param + RF_PARAM_DIFFUSE, i, rf_vec3( 0.5f, 0.5f, 0.5f ) );
    hits->offset[i] = 0.0f;
    hits->slot[i] = i;
}

// The tile's vertex, found by the path of hit 2i. The quantity that src/reuse/tile/tile_reuse.c keeps for it is an input here.
static void put_vertex( RfTileReuse* reuse, const RfVertexLanes* hits, int i, RfVec3 vertex, RfVec3 normal )
{
    RfVec3 own = rf_vec3( hits->p[0][2 * i], hits->p[1][2 * i], hits->p[2][2 * i] ), way = rf_sub( vertex, own );
    RfVec3 wo = rf_normalize( rf_scale( way, -1.0f ) );
    put3( reuse->second.lanes.p, i, vertex );
    put3( reuse->second.lanes.n, i, normal );
    put3( reuse->second.lanes.ng, i, normal );
    put3( reuse->second.lanes.wo, i, wo );
    reuse->second.lanes.offset[i] = 0.0f;
    reuse->second.lanes.slot[i] = 2 * i;
    reuse->second.owner[i] = 2 * i;
    double cos_y = -cos( d3_angle( ( D3 ){ (double)normal.x, (double)normal.y, (double)normal.z },
                                   ( D3 ){ (double)way.x, (double)way.y, (double)way.z } ) );
    double d2 = (double)way.x * (double)way.x + (double)way.y * (double)way.y + (double)way.z * (double)way.z;
    reuse->second.own_distance2_cos[i] = (float)( d2 / cos_y );
    for ( int k = 0; k < 2; ++k )
    {
        int hit = 2 * i + k;
        reuse->hits.member[hit] = hit;
        reuse->hits.begin[hit] = 2 * i;
        reuse->hits.size[hit] = 2;
        reuse->hits.rank[hit] = k;
        reuse->hits.second[hit] = k == 0 ? i : -1;
        // pairing 0 is the own path; in pairing 1 the second hit meets the vertex of the first
        for ( int s = 0; s < 2; ++s )
        {
            reuse->pairings[s].vertex[hit] = s == k ? i : 0;
            reuse->pairings[s].weight[hit] = s == k ? 1.0f : 0.0f;
        }
    }
}

static void set_models( RfVertexLanes* v, int count )
{
    v->count = count;
    v->first[0] = 0;
    for ( int kind = 1; kind <= RF_BSDF_KIND_COUNT; ++kind )
        v->first[kind] = count;
}

static void fill( RfVertexLanes* hits, RfTileReuse* reuse, float* const scattered[3], long first )
{
    set_models( hits, 2 * PAIRS );
    set_models( &reuse->second.lanes, PAIRS );
    for ( int i = 0; i < PAIRS; ++i )
    {
        long k = first + i;
        RfVec3 normal = random_direction( 60, k, 0 );
        RfVec3 vertex = rf_scale( random_direction( 60, k, 2 ),
                                  random_number( 60, k, 4 ) < 0.5 ? 0.0f : (float)random_wide( 1e-6, 1e3, 60, k, 5 ) );
        put_hit( hits, 2 * i, vertex, normal, 61, k );
        put_hit( hits, 2 * i + 1, vertex, normal, 62, k );
        put_vertex( reuse, hits, i, vertex, normal );
        for ( int h = 2 * i; h < 2 * i + 2; ++h )
        {
            RfVec3 wi = rf_normalize( rf_sub( vertex, get3( hits->p, h ) ) );
            scattered[0][h] = wi.x;
            scattered[1][h] = wi.y;
            scattered[2][h] = wi.z;
        }
    }
}

static float largest_of( RfVec3 p ) { return rf_maxf( fabsf( p.x ), rf_maxf( fabsf( p.y ), fabsf( p.z ) ) ); }

// Whether the tile shares the vertex at all: in the range that src/reuse/tile/tile_reuse.c and tile_weights.c keep to.
static bool is_shared( const RfTileReuse* reuse, const double* x, int i )
{
    double own = (double)reuse->second.own_distance2_cos[i], d[2], c[2];
    for ( int k = 0; k < 2; ++k )
    {
        D3 way = d3_sum( d3_at( x + 12 ), -1.0, d3_at( x + 6 * k ) );
        d[k] = d3_length( way );
        c[k] = -cos( d3_angle( d3_at( x + 15 ), way ) );
        if ( !( cos( d3_angle( d3_at( x + 6 * k + 3 ), way ) ) > 1e-6 ) || !( d[k] * d[k] > 1e3 * (double)FLT_MIN ) )
            return false;
    }
    return own > 0.0 && own < 1e30 && c[1] > 1e-6 && c[1] / ( d[1] * d[1] ) * own < 1e17;
}

static void judge_pair( Check* check, RfVertexLanes* hits, RfTileReuse* reuse, int i )
{
    RfVec3 own = get3( hits->p, 2 * i ), other = get3( hits->p, 2 * i + 1 ), vertex = get3( reuse->second.lanes.p, i );
    float largest = rf_maxf( largest_of( vertex ), rf_maxf( largest_of( own ), largest_of( other ) ) );
    Inputs in = { 0 };
    add_point( &in, own, rf_maxf( largest_of( own ), largest_of( vertex ) ) );
    add_direction( &in, get3( hits->n, 2 * i ) );
    add_point( &in, other, rf_maxf( largest_of( other ), largest_of( vertex ) ) );
    add_direction( &in, get3( hits->n, 2 * i + 1 ) );
    add_point( &in, vertex, largest_of( vertex ) );
    add_direction( &in, get3( reuse->second.lanes.ng, i ) );
    if ( !( largest > 0.0f ) || !is_shared( reuse, in.x, i ) )
        return;
    double got[2] = { (double)reuse->pairings[0].weight[2 * i], (double)reuse->pairings[1].weight[2 * i + 1] };
    judge( check, in.x, in.step, got );
}

int check_tiles( long count )
{
    static Check s_check = {
        18, 2, reference, describe, { { "tile weight: own path", .limit = 16 }, { "tile weight: neighbour", .limit = 16 } }
    };
    SceneBuilder b = { 0 }; // one light far away, which hides nothing
    uint32_t material = add_material( &b, make_light( 1.0f, true ) );
    add_quad( &b, material, rf_vec3( 1e6f, 1e6f, 1e6f ), rf_vec3( 1e6f, 1e6f, 1.001e6f ), rf_vec3( 1e6f, 1.001e6f, 1.001e6f ),
              rf_vec3( 1e6f, 1.001e6f, 1e6f ) );
    AUTO_SCENE scene = finish_scene( &b );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfPathSettings path = { .tracer = tracer, .max_depth = 3, .light_samples = 1, .light_sampling = RF_LIGHTS_BY_POWER };
    RfTileReuseSettings settings = { .path = &path, .tile_pixels = 2 };
    RfLayout layout = { 0 };
    const RfLayerSet layers = { .parts = 1, .base_parts = 1 };
    rf_place_tile_reuse( 1, 2, false, false, &layers, &layout );
    layout = ( RfLayout ){ .memory = aligned_alloc( 64, layout.bytes ) };
    AUTO_FREE RfTileReuse* reuse = rf_place_tile_reuse( 1, 2, false, false, &layers, &layout );
    AUTO_FREE RfVertexLanes* hits = aligned_alloc( 64, ( sizeof *hits + 63 ) / 64 * 64 );
    AUTO_FREE RfWavefront* wavefront = aligned_alloc( 64, ( sizeof *wavefront + 63 ) / 64 * 64 );
    static float s_scattered[3][RF_LANES];
    float* const scattered[3] = { s_scattered[0], s_scattered[1], s_scattered[2] };
    for ( long first = 0; first < count; first += PAIRS )
    {
        fill( hits, reuse, scattered, first );
        TRAPPED( rf_weight_pairings( &settings, hits, scattered, wavefront, reuse ) );
        for ( int i = 0; i < PAIRS; ++i )
            judge_pair( &s_check, hits, reuse, i );
    }
    return print_check( &s_check );
}
