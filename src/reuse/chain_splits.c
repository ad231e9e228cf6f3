// Split reflections: what the reflection at a chain's vertex shows of lights, in mirrors and through glass as well, is always
// traced, rather than only when a ray happens to reflect.
#include "reuse/chain_steps.h"
#include "reuse/coats.h"
#include "reuse/mirrored.h"

#include <string.h>

static void append( RfVertexLanes* lanes, int count )
{
    lanes->count += count;
    for ( int kind = RF_BSDF_GLASS + 1; kind <= RF_BSDF_KIND_COUNT; ++kind )
        lanes->first[kind] += count;
}

// Reflections that are drawn more often than this are left to chance: splitting them would follow them twice.
#define SELDOM 0.5f

// Whether reflection at lane i of GLASS is one of the things that may happen there, and a rare one. At flat mirrors
// (`mirrored`) at normal incidence: the hits that they show are reused, so all eyes must agree about whose emission is
// counted, whatever their angle.
static bool reflects_seldom( const RfVertexLanes* v, int i, bool mirrored )
{
    float base = 0.0f, tint = 0.0f;
    for ( int c = 0; c < 3; ++c )
    {
        base += v->param[RF_PARAM_DIFFUSE + c][i];
        tint += v->param[RF_PARAM_TINT + c][i];
    }
    if ( base > 0.0f || tint == 0.0f )
        return false;
    const float *n[3] = { v->n[0], v->n[1], v->n[2] }, *param[RF_PARAM_COUNT];
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
        param[p] = v->param[p];
    RfBsdfLanes lanes = rf_bsdf_lanes( RF_BSDF_GLASS, n, param, 0 );
    RfVec3 wo = mirrored ? rf_vec3( n[0][i], n[1][i], n[2][i] ) : rf_vec3( v->wo[0][i], v->wo[1][i], v->wo[2][i] );
    return rf_reflection_probability_of_lane( &lanes, i, wo ) < SELDOM;
}

// The reflecting lobes of vertices that do other things as well, but for chains whose light is counted already.
static void list_reflections( int vertex, RfChains* chains, RfVertexLanes* out )
{
    const RfVertexLanes* at = &chains->at;
    for ( int kind = 0; kind <= RF_BSDF_KIND_COUNT; ++kind )
        out->first[kind] = 0;
    out->count = 0;
    for ( int i = 0; i < at->count; ++i )
    {
        int slot = at->slot[i];
        bool mirrored = vertex == 1 && rf_is_mirrored( chains->view[slot] );
        chains->split[slot] = !chains->counted[slot] && reflects_seldom( at, i, mirrored );
        if ( !chains->split[slot] )
            continue;
        rf_copy_vertices( at, i, 1, rf_bsdf_model( RF_BSDF_GLASS )->params, out, out->count );
        for ( int c = 0; c < 3; ++c )
            out->param[RF_PARAM_TINT + c][out->count] = 0.0f;
        append( out, 1 );
    }
}

static void list_coats( const RfVertexLanes* first, RfChains* chains, RfVertexLanes* out )
{
    for ( int i = first->first[RF_BSDF_GGX]; i < first->first[RF_BSDF_GGX + 1]; ++i )
    {
        int slot = first->slot[i];
        if ( !rf_is_smooth_coat( first, i ) || rf_base_probability_of( first, i ) == 0.0f )
            continue;
        chains->split[slot] = 1;
        rf_make_lobe( first, i, out, out->count );
        append( out, 1 );
    }
}

// Adds emission that the rays hit.
static void add_emission( const RfPathSettings* path, RfWavefront* wavefront )
{
    rf_count_path_rays( wavefront, &wavefront->rays );
    const float* pane_probability =
        rf_find_vertices_past_panes( path, &wavefront->rays, 0, &wavefront->vertices, &wavefront->scratch );
    rf_absorb( &wavefront->vertices, &wavefront->rays );
    rf_add_emission_hits( path, &wavefront->rays, &wavefront->vertices, wavefront->scratch.triangle, pane_probability, false,
                          NULL, &wavefront->arrivals );
}

// Makes the mirrors and glass that the rays hit the reflections' next vertices, the `vertex`-th of their chains.
static void go_on( const RfPathSettings* path, int vertex, const RfWavefront* wavefront, RfVertexLanes* at, RfChains* chains )
{
    const RfRayLanes* rays = &wavefront->rays;
    for ( int r = 0; r < rays->count; ++r )
    {
        bool last = vertex - chains->straight[rays->slot[r]] >= path->max_depth;
        RfVec3 t = rf_vec3( rays->throughput[0][r], rays->throughput[1][r], rays->throughput[2][r] );
        rf_set_throughput( chains, rays->slot[r], last ? rf_vec3( 0, 0, 0 ) : t );
    }
    rf_go_to( &wavefront->vertices, at );
}

void rf_split_reflections( const RfPathSettings* path, int vertex, const RfVertexLanes* coats, RfWavefront* wavefront,
                           RfChains* chains )
{
    RfVertexLanes* at = &chains->hits; // not in use yet
    list_reflections( vertex, chains, at );
    if ( coats != NULL )
        list_coats( coats, chains, at );
    if ( at->count == 0 )
        return;
    rf_light_chains( path, vertex, at, wavefront, chains );
    float throughput[3][RF_LANES];
    memcpy( throughput, chains->throughput, sizeof throughput );
    for ( int followed = 1; at->count > 0; ++followed )
    {
        rf_scatter_chains( path, vertex, followed, at, wavefront, chains );
        if ( wavefront->rays.count == 0 )
            break;
        add_emission( path, wavefront );
        go_on( path, ++vertex, wavefront, at, chains );
    }
    memcpy( chains->throughput, throughput, sizeof throughput );
}
