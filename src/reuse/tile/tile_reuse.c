// The steps of tile reuse, and the pairing of hits with second vertices.
#include "reuse/tile/tile_reuse.h"

#include "reuse/tile/tile_chains.h"
#include "reuse/tile/tile_paths.h"

#include <string.h>

RfTileReuse* rf_place_tile_reuse( int light_lanes, int tile_pixels, bool panes, bool own, const RfLayerSet* layers,
                                  RfLayout* layout )
{
    if ( tile_pixels == 1 )
        return NULL;
    RfTileReuse* reuse = rf_take( layout, 1, sizeof *reuse );
    RF_PLACE( layout, reuse->second.direct, light_lanes );
    RF_PLACE( layout, reuse->pairings, tile_pixels );
    RF_PLACE( layout, reuse->own, own );
    RF_PLACE( layout, reuse->at_second, layers->parts );
    for ( int s = 0; s < tile_pixels; ++s )
    {
        RF_PLACE( layout, reuse->pairings[s].pane_weight, panes ? 3 : 0 );
        RF_PLACE( layout, reuse->pairings[s].of_part, layers->parts );
        RF_PLACE( layout, reuse->pairings[s].own, own ? layers->base_parts : 0 );
        RF_PLACE( layout, reuse->pairings[s].touched, own ? RF_LANES : 0 );
    }
    if ( own )
    {
        RF_PLACE( layout, reuse->own->groups, layers->base_parts );
        RF_PLACE( layout, reuse->own->beyond.of_groups, layers->base_parts - 1 );
    }
    if ( reuse != NULL )
        reuse->split = false;
    return reuse;
}

// Sorts the hits that become records by tile.
static void list_members( const RfTileReuseSettings* settings, const RfVertexLanes* hits, RfTileReuse* reuse )
{
    int32_t end[RF_LANES] = { 0 };
    int count = rf_record_count( hits );
    for ( int i = 0; i < count; ++i )
        end[settings->tile_of[hits->slot[i]]] += 1;
    for ( int i = 0; i < count; ++i )
        reuse->hits.size[i] = end[settings->tile_of[hits->slot[i]]];
    int sum = 0;
    for ( int t = 0; t < settings->tile_count; ++t )
    {
        int size = end[t];
        end[t] = sum;
        sum += size;
    }
    for ( int i = 0; i < count; ++i )
    {
        int place = end[settings->tile_of[hits->slot[i]]]++;
        reuse->hits.member[place] = i;
    }
    for ( int place = 0; place < count; )
    {
        int begin = place, size = reuse->hits.size[reuse->hits.member[begin]];
        for ( ; place < begin + size; ++place )
        {
            reuse->hits.begin[reuse->hits.member[place]] = begin;
            reuse->hits.rank[reuse->hits.member[place]] = place - begin;
        }
    }
}

// Whether max_depth ends the path at second vertex a. Its throughput does not show it: panes may have absorbed all of it, and
// other hits may see the vertex without them.
static bool is_spent( const RfTileReuseSettings* settings, const RfTileReuse* reuse, int a )
{
    const int32_t* spent = settings->path->spent;
    return spent != NULL && spent[reuse->second.lanes.slot[a]] + 2 >= settings->path->max_depth;
}

// Finds the second vertices that are reused: the hit must be non-specular, and the vertex, too, unless it begins a chain that
// found light. All hits of the tile could have sampled them, even those whose own path has no second vertex.
static void list_owners( const RfTileReuseSettings* settings, const RfVertexLanes* hits, RfTileReuse* reuse )
{
    int32_t hit_of_slot[RF_LANES];
    int count = rf_record_count( hits );
    for ( int i = 0; i < hits->count; ++i )
        hit_of_slot[hits->slot[i]] = i < count ? i : -1;
    for ( int i = 0; i < count; ++i )
        reuse->hits.second[i] = -1;
    RfVertexLanes* y = &reuse->second.lanes;
    for ( int a = 0; a < y->count; ++a )
    {
        int i = hit_of_slot[y->slot[a]];
        if ( i >= 0 ) // connections end here: the rounding of where they begin counts, too
            y->offset[a] = rf_maxf( y->offset[a], rf_ray_offset( rf_largest_coordinate( RF_GET3( hits->p, i ) ) ) );
        reuse->second.owner[a] = -1;
        reuse->second.hit[a] = i;
        if ( i < 0 || !( a < rf_record_count( y ) || rf_has_chain_light( settings, reuse, a ) ) ||
             is_spent( settings, reuse, a ) )
            continue;
        float way2 = 0.0f, cos_y = 0.0f;
        for ( int c = 0; c < 3; ++c )
        {
            float way = y->p[c][a] - ( hits->p[c][i] + hits->ng[c][i] * hits->offset[i] );
            way2 += way * way;
            cos_y += y->ng[c][a] * y->wo[c][a];
        }
        float distance2_cos = cos_y > 0.0f ? way2 / cos_y : 0.0f;
        if ( !( distance2_cos > 0.0f && distance2_cos < 1e30f ) ) // too close or edge-on
            continue;
        reuse->second.own_distance2_cos[a] = distance2_cos;
        reuse->second.owner[a] = i;
        reuse->hits.second[i] = a;
    }
}

static float sum_of( const RfArrivals* arrivals, int slot )
{
    return arrivals->emitted[0][slot] + arrivals->emitted[1][slot] + arrivals->emitted[2][slot] + arrivals->rest[0][slot] +
           arrivals->rest[1][slot] + arrivals->rest[2][slot];
}

// Finds the second vertices at which no light arrives, in many rooms most of them: connections to them bring nothing.
static void find_dark( const RfPathSettings* path, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    float sum[RF_LANES];
    for ( int a = 0; a < y->count; ++a )
    {
        int slot = y->slot[a];
        sum[a] = 0.0f;
        for ( int part = 0; part < reuse->part_count; ++part )
            sum[a] += sum_of( reuse->at_second + part, slot );
        for ( int base = 0; reuse->split && base < reuse->base_parts; ++base )
            sum[a] += sum_of( rf_own_arrivals( &reuse->own->beyond, base ), slot );
    }
    for ( int j = 0; j < rf_light_lanes_count( path ); ++j )
    {
        const RfLightLanes* direct = reuse->second.direct + j;
#pragma omp simd
        for ( int a = 0; a < y->count; ++a )
            sum[a] += direct->radiance_cos[0][a] + direct->radiance_cos[1][a] + direct->radiance_cos[2][a];
    }
    for ( int a = 0; a < y->count; ++a )
        reuse->second.dark[a] = a < rf_record_count( y ) && sum[a] == 0.0f;
}

// The second vertex of each hit in a pairing; its `weight` is 1 where light arrives at it, else 0.
static void find_neighbours( const RfTileReuse* reuse, int pairing, int count, RfPairingLanes* out )
{
    memset( out->vertex, 0, (size_t)count * sizeof out->vertex[0] );
    memset( out->weight, 0, (size_t)count * sizeof out->weight[0] );
    for ( int a = 0; a < reuse->second.lanes.count; ++a )
    {
        if ( reuse->second.owner[a] < 0 || reuse->second.dark[a] || pairing >= reuse->hits.size[reuse->second.owner[a]] )
            continue;
        int i = rf_receiver( reuse, a, pairing );
        out->vertex[i] = a;
        out->weight[i] = 1.0f;
    }
}

static void copy_throughput( const RfRayLanes* rays, RfTileReuse* reuse )
{
    const RfVertexLanes* y = &reuse->second.lanes;
    for ( int c = 0; c < 3; ++c )
    {
        for ( int a = 0; a < y->count; ++a )
            reuse->second.throughput[c][a] = rays->throughput[c][y->ray[a]];
    }
}

// Notes the panes that paths passed on the way to their own second vertex.
static void note_panes( const RfRayLanes* rays, const float* pane_probability, RfTileReuse* reuse )
{
    for ( int r = 0; r < rays->count && pane_probability != NULL; ++r )
        reuse->slots.pane_probability[rays->slot[r]] = pane_probability[r];
}

// Where nothing is alpha-blended, the probability of passing them is the V of a path's own connection, which is not traced
// again.
static void pass_own_panes( const RfTracer* tracer, RfTileReuse* reuse )
{
    bool passed = rf_tracer_has_panes( tracer ) && !rf_tracer_is_blended( tracer );
    for ( int a = 0; passed && a < reuse->second.lanes.count; ++a )
    {
        if ( reuse->second.owner[a] >= 0 )
            reuse->pairings[0].weight[reuse->second.owner[a]] *= reuse->slots.pane_probability[reuse->second.lanes.slot[a]];
    }
}

static void clear_arrival( RfArrivals* arrivals, int slot )
{
    for ( int c = 0; c < 3; ++c )
        arrivals->emitted[c][slot] = arrivals->rest[c][slot] = 0.0f;
    arrivals->light_pdf_solid_angle[slot] = 0.0f;
}

// Begins the paths anew at their second vertices, which `triangle` lists by ray: what moves may touch those themselves. Caustics
// begin at hits: those of a tile are alike (rf_throws_caustics).
static void begin_beyond( const RfPathSettings* path, const uint32_t* triangle, RfTileReuse* reuse )
{
    bool caustics = path->own->caustics;
    reuse->own->beyond.caustics = caustics;
    const RfVertexLanes* y = &reuse->second.lanes;
    for ( int a = 0; a < y->count; ++a )
    {
        int slot = y->slot[a];
        for ( int base = 0; base < reuse->base_parts; ++base )
            clear_arrival( rf_own_arrivals( &reuse->own->beyond, base ), slot );
        reuse->own->beyond.seen[slot] = path->own->seen[slot];
        reuse->own->moving[slot] = reuse->own->beyond.touched[slot] =
            !caustics && rf_is_moving( path->tracer, triangle[y->ray[a]] );
    }
}

// All slots of the vertices are below it.
static int end_of_slots( const RfVertexLanes* v )
{
    int32_t end = 0;
    for ( int i = 0; i < v->count; ++i )
        end = v->slot[i] >= end ? v->slot[i] + 1 : end;
    return end;
}

// Takes light samples at the second vertices and continues the paths from there.
static void trace_beyond( const RfPathSettings* path, RfWavefront* wavefront, RfTileReuse* reuse )
{
    RfPathSettings beyond = *path;
    beyond.own = reuse->split ? &reuse->own->beyond : NULL;
    const RfPathSettings* settings = &beyond;
    rf_draw_sides( wavefront, 2, &reuse->second.lanes );
    int samples = settings->light_samples, k = rf_light_set_count( settings, samples );
    uint32_t dimension = rf_vertex_dimension( 2, samples ) + RF_DIMENSION_LIGHTS;
    for ( int j = 0; j < k; ++j )
    {
        RfLightSample at = { dimension + 3u * (uint32_t)( j % samples ), rf_frame_of_sample( settings, samples, j ) };
        wavefront->shadow_rays += (uint64_t)rf_sample_lights( settings, wavefront, &reuse->second.lanes, at,
                                                              reuse->second.direct + j, &wavefront->scratch );
    }
    for ( int j = 0; j < samples; ++j )
        rf_note_lit( settings, wavefront, reuse->second.direct + j, j, reuse->second.lanes.count );
    if ( settings->connector != NULL )
        settings->connector->sample( settings->connector, wavefront, NULL, &reuse->second.lanes, 2, reuse->second.direct + k,
                                     reuse->second.connection_area );
    RfArrivals *arrivals = &wavefront->arrivals, *dimmed = wavefront->dimmed;
    int slots = end_of_slots( &reuse->second.lanes );
    rf_copy_arrivals( slots, arrivals, &reuse->slots.at_hits );
    wavefront->dimmed = reuse->at_second + 1;
    for ( int part = 0; part < reuse->part_count; ++part )
        rf_clear_arrivals( slots, rf_arrivals_of_part( wavefront, part ) );
    float* wi[3] = { reuse->second.wi[0], reuse->second.wi[1], reuse->second.wi[2] };
    rf_scatter_deferred( settings, wavefront, &reuse->second.lanes, 2, wi );
    memcpy( reuse->second.pdf, wavefront->scratch.pdf, (size_t)reuse->second.lanes.count * sizeof( float ) );
    rf_face_rays( &reuse->second.lanes ); // where the hits of the tile are
    rf_trace_tails( settings, wavefront, 3 );
    rf_copy_arrivals( slots, arrivals, reuse->at_second );
    rf_copy_arrivals( slots, &reuse->slots.at_hits, arrivals );
    wavefront->dimmed = dimmed;
}

// Whether max_depth ends all paths at their second vertex. Where the camera ray passed a pane, they may have one more.
static bool all_end_at_second( const RfPathSettings* path, const RfWavefront* wavefront )
{
    if ( path->max_depth > 2 )
        return false;
    for ( int r = 0; r < wavefront->rays.count && path->spent != NULL; ++r )
    {
        if ( path->spent[wavefront->rays.slot[r]] < 0 )
            return false;
    }
    return true;
}

// No pairing brings light. The directions stay valid, as BSDFs need them.
static void clear_pairings( int tile_pixels, RfTileReuse* reuse )
{
    const RfVertexLanes* hits = reuse->hits.lanes;
    reuse->second.lanes.first[RF_BSDF_FIRST_GLOSSY] = 0;
    for ( int s = 0; s < tile_pixels; ++s )
    {
        RfPairingLanes* pairing = reuse->pairings + s;
        memset( pairing->weight, 0, sizeof pairing->weight );
        memset( pairing->vertex, 0, sizeof pairing->vertex );
        if ( reuse->split )
            pairing->any_touched = false;
        for ( int c = 0; c < 3; ++c )
            memcpy( pairing->wi[c], hits->n[c], (size_t)hits->count * sizeof( float ) );
    }
}

uint64_t rf_trace_tile_tails( const RfTileReuseSettings* settings, const RfVertexLanes* hits, float* const scattered[3],
                              RfWavefront* wavefront, RfTileReuse* reuse )
{
    int tile_pixels = settings->tile_pixels;
    reuse->second.lanes.count = reuse->thinned = reuse->kept = reuse->second.shared = 0;
    reuse->hits.lanes = hits;
    reuse->split = settings->path->own != NULL;
    reuse->part_count = 1 + rf_dimmed_parts( settings->path );
    reuse->base_parts = rf_base_parts( settings->path );
    for ( int base = 0; reuse->split && base < reuse->base_parts; ++base )
        reuse->own->groups[base].any = false;
    if ( wavefront->rays.count > 0 )
        note_panes( &wavefront->rays,
                    rf_find_lit_vertices( settings->path, wavefront, &wavefront->rays, true, &reuse->second.lanes ), reuse );
    if ( reuse->split )
        begin_beyond( settings->path, wavefront->scratch.triangle, reuse );
    if ( all_end_at_second( settings->path, wavefront ) || reuse->second.lanes.count == 0 )
    {
        clear_pairings( tile_pixels, reuse );
        return 0;
    }
    rf_end_spent_paths( settings->path, 2, &wavefront->rays );
    copy_throughput( &wavefront->rays, reuse );
    if ( settings->source != NULL )
    {
        list_owners( settings, hits, reuse );
        rf_drop_copies( settings->source, wavefront, reuse );
    }
    trace_beyond( settings->path, wavefront, reuse );
    if ( settings->source != NULL )
        rf_restore_copies( settings->source, settings->path->light_samples, wavefront, reuse );
    list_members( settings, hits, reuse );
    list_owners( settings, hits, reuse );
    if ( settings->path_roulette )
        rf_thin_paths( settings->path, wavefront, reuse );
    find_dark( settings->path, reuse );
    if ( settings->chain_light )
        rf_sort_chains( reuse );
    for ( int s = 0; s < tile_pixels; ++s )
        find_neighbours( reuse, s, rf_record_count( hits ), reuse->pairings + s );
    pass_own_panes( settings->path->tracer, reuse );
    uint64_t tested = rf_weight_pairings( settings, hits, scattered, wavefront, reuse );
    rf_light_pairings( settings, wavefront, reuse );
    if ( settings->path->chain_light != NULL )
        rf_weight_chain_light( settings->path, reuse );
    return tested;
}
