// The order of a shared walk, and who shares with whom.
#include "reuse/tile_reuse.h"

#include <string.h>

static size_t struct_bytes( void ) { return ( sizeof( RfTileReuse ) + 63 ) / 64 * 64; }

size_t rf_tile_reuse_bytes( int light_samples, int tile_pixels )
{
    if ( tile_pixels == 1 )
        return 0;
    return struct_bytes() + (size_t)light_samples * sizeof( RfLightLanes ) + (size_t)tile_pixels * sizeof( RfPairingLanes );
}

RfTileReuse* rf_lay_out_tile_reuse( int light_samples, int tile_pixels, void* memory )
{
    if ( tile_pixels == 1 )
        return NULL;
    RfTileReuse* share = memory;
    share->direct = (RfLightLanes*)( (char*)memory + struct_bytes() );
    share->turns = (RfPairingLanes*)( share->direct + light_samples );
    return share;
}

// Hits that records are made of, tile after tile.
static void list_members( const RfVertexLanes* hits, RfTileReuse* share )
{
    int32_t end[RF_LANES] = { 0 };
    int count = rf_record_count( hits );
    for ( int i = 0; i < count; ++i )
        end[share->tile_of[hits->slot[i]]] += 1;
    for ( int i = 0; i < count; ++i )
        share->size[i] = end[share->tile_of[hits->slot[i]]];
    int sum = 0;
    for ( int t = 0; t < share->tile_count; ++t )
    {
        int size = end[t];
        end[t] = sum;
        sum += size;
    }
    for ( int i = 0; i < count; ++i )
    {
        int place = end[share->tile_of[hits->slot[i]]]++;
        share->member[place] = i;
    }
    for ( int place = 0; place < count; )
    {
        int begin = place, size = share->size[share->member[begin]];
        for ( ; place < begin + size; ++place )
        {
            share->begin[share->member[place]] = begin;
            share->rank[share->member[place]] = place - begin;
        }
    }
}

// Which second vertices are shared: those of hits and surfaces whose densities
// can be asked for. All hits of the tile could have found them, also those
// whose own path found nothing.
static void list_owners( const RfVertexLanes* hits, RfTileReuse* share )
{
    int32_t hit_of_slot[RF_LANES];
    int count = rf_record_count( hits );
    for ( int i = 0; i < hits->count; ++i )
        hit_of_slot[hits->slot[i]] = i < count ? i : -1;
    for ( int i = 0; i < count; ++i )
        share->found[i] = -1;
    const RfVertexLanes* y = &share->second;
    for ( int a = 0; a < y->count; ++a )
    {
        int i = hit_of_slot[y->slot[a]];
        share->owner[a] = -1;
        if ( i < 0 || a >= rf_record_count( y ) )
            continue;
        float way2 = 0.0f, cos_y = 0.0f;
        for ( int c = 0; c < 3; ++c )
        {
            float way = y->p[c][a] - ( hits->p[c][i] + hits->ng[c][i] * hits->offset[i] );
            way2 += way * way;
            cos_y += y->ng[c][a] * y->wo[c][a];
        }
        float distance2_cos = way2 / cos_y;
        if ( !( distance2_cos > 0.0f && distance2_cos < 1e30f ) ) // too close or edge-on to be compared
            continue;
        share->own_distance2_cos[a] = distance2_cos;
        share->owner[a] = i;
        share->found[i] = a;
    }
}

// Who looks at whom in a turn; `weight` 1 where there is a vertex to look at.
static void find_mates( const RfTileReuse* share, int turn, int count, RfPairingLanes* out )
{
    for ( int i = 0; i < count; ++i )
    {
        int size = share->size[i], at = share->rank[i] + turn;
        at -= at >= size ? size : 0;
        at = turn < size ? at : 0;
        int mate = share->found[share->member[share->begin[i] + at]];
        bool there = ( turn < size ) & ( mate >= 0 );
        out->mate[i] = there ? mate : 0;
        out->weight[i] = there ? 1.0f : 0.0f;
    }
}

static void note_throughput( const RfRayLanes* rays, RfTileReuse* share )
{
    const RfVertexLanes* y = &share->second;
    for ( int c = 0; c < 3; ++c )
    {
        for ( int a = 0; a < y->count; ++a )
            share->throughput[c][a] = rays->throughput[c][y->ray[a]];
    }
}

// The walk beyond the second vertices: light samples there, and what arrives
// along the directions scattered there.
static void go_on( const RfPathSettings* settings, RfWavefront* walk, RfTileReuse* share )
{
    int k = settings->light_samples;
    uint32_t dimension = rf_vertex_dimension( 2, k ) + RF_DIMENSION_LIGHTS;
    for ( int j = 0; j < k; ++j )
        walk->shadow_rays += (uint64_t)rf_sample_lights( settings, walk, &share->second, dimension + 3u * (uint32_t)j,
                                                         share->direct + j, &walk->scratch );
    memcpy( &share->found_light, &walk->arrivals, sizeof walk->arrivals );
    memset( &walk->arrivals, 0, sizeof walk->arrivals );
    float* wi[3] = { share->wi[0], share->wi[1], share->wi[2] };
    rf_scatter_deferred( settings, walk, &share->second, 2, wi );
    memcpy( share->pdf, walk->scratch.pdf, (size_t)share->second.count * sizeof( float ) );
    rf_trace_tails( settings, walk, 3 );
    memcpy( &share->beyond, &walk->arrivals, sizeof walk->arrivals );
    memcpy( &walk->arrivals, &share->found_light, sizeof walk->arrivals );
}

uint64_t rf_trace_tile_tails( const RfTileReuseSettings* settings, const RfVertexLanes* hits, float* const scattered[3],
                              RfWavefront* walk, RfTileReuse* share )
{
    int tile_pixels = settings->tile_pixels;
    share->second.count = 0;
    if ( walk->rays.count > 0 )
        rf_find_lit_vertices( settings->walk, walk, &walk->rays, true, &share->second );
    if ( settings->walk->max_depth == 2 || share->second.count == 0 )
    {
        for ( int s = 0; s < tile_pixels; ++s )
            memset( share->turns[s].weight, 0, sizeof share->turns[s].weight );
        for ( int s = 1; s < tile_pixels; ++s )
        {
            for ( int c = 0; c < 3; ++c )
                memcpy( share->turns[s].wi[c], hits->n[c], (size_t)hits->count * sizeof( float ) );
        }
        share->second.first[RF_BSDF_PHONG] = 0;
        for ( int s = 1; s < tile_pixels; ++s )
            memset( share->turns[s].mate, 0, sizeof share->turns[s].mate );
        return 0;
    }
    note_throughput( &walk->rays, share );
    go_on( settings->walk, walk, share );
    list_members( hits, share );
    list_owners( hits, share );
    for ( int s = 0; s < tile_pixels; ++s )
        find_mates( share, s, rf_record_count( hits ), share->turns + s );
    uint64_t tested = rf_weight_pairings( settings, hits, scattered, walk, share );
    rf_light_pairings( settings, walk, share );
    return tested;
}
