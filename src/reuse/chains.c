#include "reuse/chain_steps.h"
#include "reuse/coats.h"

#include <string.h>

// Light samples where chains are. Vertices that are split have theirs.
static void light_chains( const RfPathSettings* path, int vertex, RfWavefront* wavefront, RfChains* chains )
{
    const RfVertexLanes* at = &chains->at;
    RfVertexLanes* unlit = &chains->hits; // not in use yet
    for ( int kind = 0; kind <= RF_BSDF_KIND_COUNT; ++kind )
        unlit->first[kind] = 0;
    unlit->count = 0;
    for ( int i = 0; i < at->count; ++i )
    {
        if ( chains->split[at->slot[i]] )
            continue;
        rf_copy_vertices( at, i, 1, rf_bsdf_model( RF_BSDF_GLASS )->params, unlit, unlit->count++ );
    }
    for ( int kind = RF_BSDF_FIRST_SPECULAR + 1; kind <= RF_BSDF_KIND_COUNT; ++kind )
        unlit->first[kind] = unlit->count;
    if ( unlit->count > 0 )
        rf_light_chains( path, vertex, unlit, wavefront, chains );
}

// What chains see of lights at their vertices.
static void find_lights( const RfPathSettings* path, int vertex, RfWavefront* wavefront, RfChains* chains )
{
    for ( int i = 0; vertex > RF_MOST_SPLIT && i < chains->at.count; ++i )
        chains->split[chains->at.slot[i]] = 0;
    if ( vertex > 1 && vertex <= RF_MOST_SPLIT )
        rf_split_reflections( path, vertex, NULL, wavefront, chains );
    light_chains( path, vertex, wavefront, chains );
}

static void note_panes_at( const RfPathSettings* path, RfChains* chains )
{
    const RfVertexLanes* at = &chains->at;
    for ( int i = 0; i < at->count; ++i )
        chains->pane[at->slot[i]] = rf_is_at_pane( path->tracer, at, i );
}

// Sorts the chains by what happened: what is behind panes is seen straight, flat mirrors show what one reflection sees,
// and the light that split reflections see is counted already.
static void note_events( int vertex, RfWavefront* wavefront, RfChains* chains )
{
    const RfRayLanes* rays = &wavefront->rays;
    for ( int r = 0; r < rays->count; ++r )
    {
        int slot = rays->slot[r];
        bool reflected = chains->reflected[slot], passed = chains->pane[slot] && !reflected;
        bool straight = passed && ( vertex == 1 || chains->view[slot] == RF_VIEW_DIRECT );
        chains->straight[slot] += passed;
        chains->counted[slot] |= chains->split[slot] && reflected;
        if ( straight )
            chains->view[slot] = RF_VIEW_DIRECT;
        else if ( vertex > 1 || !reflected || rays->pdf_solid_angle[r] < RF_DELTA_PDF )
            chains->view[slot] = RF_VIEW_CHAIN;
    }
}

// Takes the light away that is counted already.
static void drop_counted_light( const RfChains* chains, RfWavefront* wavefront )
{
    RfVertexLanes* found = &wavefront->vertices;
    RfRayLanes* rays = &wavefront->rays;
    for ( int i = 0; i < found->count; ++i )
    {
        if ( !chains->counted[found->slot[i]] )
            continue;
        found->light_pdf_solid_angle[i] = 0.0f;
        for ( int c = 0; c < 3; ++c )
            found->emission[c][i] = 0.0f;
    }
    for ( int r = 0; r < rays->count; ++r )
    {
        for ( int c = 0; c < 3 && chains->counted[rays->slot[r]] && wavefront->scratch.triangle[r] == RF_MISS; ++c )
            rays->throughput[c][r] = 0.0f;
    }
}

// True if max_depth leaves no vertex after the chain's `vertex`.
static bool is_last( const RfPathSettings* path, const RfChains* chains, int slot, int vertex )
{
    return vertex - chains->straight[slot] >= path->max_depth;
}

// Adds the light that the rays hit. What only the chain can find stays with the vertex if the chain ends there, so
// that it is reused with it.
static void add_emission( const RfPathSettings* path, const float* pane_probability, int vertex, RfWavefront* wavefront,
                          const RfChains* chains )
{
    RfVertexLanes* found = &wavefront->vertices;
    const RfRayLanes* rays = &wavefront->rays;
    bool kept[RF_LANES];
    for ( int i = 0; i < rf_record_count( found ); ++i )
    {
        kept[i] = !is_last( path, chains, found->slot[i], vertex + 1 ) && rays->pdf_solid_angle[found->ray[i]] >= RF_DELTA_PDF;
        found->light_pdf_solid_angle[i] = kept[i] ? 0.0f : found->light_pdf_solid_angle[i];
    }
    rf_add_emission_hits( path, rays, found, wavefront->scratch.triangle, pane_probability, false, NULL, &wavefront->arrivals );
    for ( int i = 0; i < rf_record_count( found ); ++i )
    {
        for ( int c = 0; c < 3 && !kept[i]; ++c )
            found->emission[c][i] = 0.0f;
    }
}

// True where an eye in front of the pane would draw the base or the lobe of a coat.
static bool is_coat_behind_pane( const RfChains* chains, int slot, const RfVertexLanes* found, int kind, int i )
{
    return chains->view[slot] == RF_VIEW_DIRECT && kind == RF_BSDF_GGX && rf_is_smooth_coat( found, i );
}

// Notes the chains that have reached a non-specular vertex, and the throughputs of all.
static void note_ends( const RfPathSettings* path, const RfVertexLanes* found, const RfRayLanes* rays, int vertex,
                       RfChains* chains )
{
    RfVertexLanes* ends = &chains->ends;
    for ( int r = 0; r < rays->count; ++r )
        rf_set_throughput( chains, rays->slot[r],
                           rf_vec3( rays->throughput[0][r], rays->throughput[1][r], rays->throughput[2][r] ) );
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        for ( int i = found->first[kind]; i < found->first[kind + 1]; ++i )
        {
            int slot = found->slot[i];
            if ( is_last( path, chains, slot, vertex + 1 ) )
                continue;
            if ( is_coat_behind_pane( chains, slot, found, kind, i ) )
                chains->view[slot] = RF_VIEW_CHAIN;
            chains->kind[ends->count] = (uint8_t)kind;
            chains->length[slot] = vertex - chains->straight[slot];
            rf_copy_vertices( found, i, 1, rf_bsdf_model( (RfBsdfKind)kind )->params, ends, ends->count++ );
        }
    }
}

// Ends the chains that have no vertex left.
static void end_last( const RfPathSettings* path, int vertex, RfChains* chains )
{
    for ( int i = 0; i < chains->at.count; ++i )
    {
        int slot = chains->at.slot[i];
        if ( is_last( path, chains, slot, vertex ) )
            rf_set_throughput( chains, slot, rf_vec3( 0, 0, 0 ) );
    }
}

// Appends the non-specular first hits of a model; coats that were split leave their base.
static void append_first( const RfVertexLanes* first, int kind, const RfChains* chains, RfVertexLanes* hits )
{
    uint32_t params = rf_bsdf_model( (RfBsdfKind)kind )->params;
    int begin = first->first[kind], count = first->first[kind + 1] - begin;
    if ( kind != RF_BSDF_GGX )
    {
        rf_copy_vertices( first, begin, count, params, hits, hits->count );
        hits->count += count;
        return;
    }
    for ( int i = begin; i < begin + count; ++i )
    {
        uint8_t view = chains->view[first->slot[i]];
        if ( rf_is_smooth_coat( first, i ) && view != RF_VIEW_BASE )
            continue;
        rf_copy_vertices( first, i, 1, params, hits, hits->count );
        if ( view == RF_VIEW_BASE )
            rf_make_base( hits, hits->count );
        hits->count += 1;
    }
}

// Merges the non-specular first hits and the ends of chains.
static void merge_hits( const RfVertexLanes* first, RfChains* chains )
{
    RfVertexLanes* hits = &chains->hits;
    hits->count = 0;
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        hits->first[kind] = hits->count;
        append_first( first, kind, chains, hits );
        for ( int end = 0; end < chains->ends.count; ++end )
        {
            if ( chains->kind[end] == kind )
                rf_copy_vertices( &chains->ends, end, 1, rf_bsdf_model( (RfBsdfKind)kind )->params, hits, hits->count++ );
        }
    }
    for ( int kind = RF_BSDF_FIRST_SPECULAR; kind <= RF_BSDF_KIND_COUNT; ++kind )
        hits->first[kind] = hits->count;
}

void rf_follow_chains( const RfPathSettings* path, const RfVertexLanes* first, const RfRayLanes* camera_rays, bool lit,
                       RfWavefront* wavefront, RfChains* chains )
{
    rf_start_chains( path, first, camera_rays, lit, wavefront, chains );
    int end = path->max_depth == 1 ? 1 : path->max_depth + RF_MOST_SPLIT * rf_tracer_has_panes( path->tracer );
    for ( int vertex = 1; vertex < end && chains->at.count > 0; ++vertex )
    {
        end_last( path, vertex, chains );
        note_panes_at( path, chains );
        if ( lit )
            find_lights( path, vertex, wavefront, chains );
        int end_at_panes = rf_scatter_chains( path, vertex, vertex, &chains->at, wavefront, chains );
        if ( wavefront->rays.count == 0 )
            break;
        note_events( vertex, wavefront, chains );
        rf_count_path_rays( wavefront, &wavefront->rays );
        int first_past = vertex < RF_MOST_SPLIT ? end_at_panes : 0;
        const float* pane_probability =
            rf_find_vertices_past_panes( path, &wavefront->rays, first_past, &wavefront->vertices, &wavefront->scratch );
        rf_absorb( &wavefront->vertices, &wavefront->rays );
        drop_counted_light( chains, wavefront );
        add_emission( path, pane_probability, vertex, wavefront, chains );
        note_ends( path, &wavefront->vertices, &wavefront->rays, vertex, chains );
        rf_go_to( &wavefront->vertices, &chains->at );
    }
    memcpy( chains->light, wavefront->arrivals.rest, sizeof chains->light );
    merge_hits( first, chains );
}

void rf_split_tiles( const RfChains* chains, RfTileReuse* tiles )
{
    int32_t head[RF_LANES]; // by old tile: its first new one
    int32_t slot_of[RF_LANES], next[RF_LANES];
    int32_t count = 0;
    memset( head, -1, (size_t)tiles->tile_count * sizeof *head );
    for ( int i = 0; i < chains->hits.count; ++i )
    {
        int slot = chains->hits.slot[i];
        int32_t* tile = head + tiles->tile_of[slot];
        while ( *tile >= 0 && chains->length[slot_of[*tile]] != chains->length[slot] )
            tile = next + *tile;
        if ( *tile < 0 )
        {
            *tile = count;
            slot_of[count] = slot;
            next[count++] = -1;
        }
        tiles->tile_of[slot] = *tile;
    }
    tiles->tile_count = count;
}
