#include "reuse/chains.h"

#include <string.h>

// Chains this long end by Russian roulette.
#define ROULETTE_AFTER 4

static uint32_t dimension_of( const RfPathSettings* path, int vertex )
{
    return RF_DIMENSION_CHAINS + rf_vertex_dimension( vertex, path->light_samples );
}

static RfVec3 throughput_of( const RfChains* chains, int slot )
{
    return rf_vec3( chains->throughput[0][slot], chains->throughput[1][slot], chains->throughput[2][slot] );
}

static void set_throughput( RfChains* chains, int slot, RfVec3 t )
{
    chains->throughput[0][slot] = t.x;
    chains->throughput[1][slot] = t.y;
    chains->throughput[2][slot] = t.z;
}

// Makes the unevaluable lanes of `found` the vertices where chains are.
static void go_to( const RfVertexLanes* found, RfVertexLanes* at )
{
    int first = rf_record_count( found );
    at->count = found->count - first;
    for ( int kind = 0; kind <= RF_BSDF_KIND_COUNT; ++kind )
    {
        at->first[kind] = kind <= RF_BSDF_FIRST_UNEVALUABLE ? 0 : found->first[kind] - first;
        if ( kind < RF_BSDF_FIRST_UNEVALUABLE || kind == RF_BSDF_KIND_COUNT )
            continue;
        int begin = found->first[kind], count = found->first[kind + 1] - begin;
        rf_copy_vertices( found, begin, count, rf_bsdf_model( (RfBsdfKind)kind )->params, at, begin - first );
    }
}

// The view of a chain that starts here, if it is reflected and then ends.
static uint8_t view_of( const RfPathSettings* path, const RfVertexLanes* v, int i, uint32_t triangle, RfVec3 throughput )
{
    uint16_t mirror = rf_tracer_triangles( path->tracer )[triangle].mirror;
    float cos_o = v->n[0][i] * v->wo[0][i] + v->n[1][i] * v->wo[1][i] + v->n[2][i] * v->wo[2][i];
    bool inside =
        rf_max_component( throughput ) < 1.0f || ( v->param[RF_PARAM_IOR][i] > 0.0f && v->param[RF_PARAM_IOR][i] < 1.0f );
    return mirror == RF_NO_MIRROR || cos_o < RF_MIN_COS || inside ? RF_VIEW_CHAIN : (uint8_t)( mirror + 1 );
}

// What the eyes see of the first vertices themselves: their emission, absorbed on the way if the eye is inside a body.
static void start( const RfPathSettings* path, const RfVertexLanes* first, const RfRayLanes* rays, RfWavefront* wavefront,
                   RfChains* chains )
{
    memset( chains->length, 0, sizeof chains->length );
    memset( chains->view, RF_VIEW_DIRECT, sizeof chains->view );
    memset( &wavefront->arrivals, 0, sizeof wavefront->arrivals );
    chains->ends.count = 0;
    for ( int i = 0; i < rays->count; ++i )
        set_throughput( chains, i, rf_vec3( 1, 1, 1 ) );
    go_to( first, &chains->at );
    const RfVertexLanes* v = &chains->at;
    for ( int i = 0; i < v->count; ++i )
    {
        int slot = v->slot[i];
        RfVec3 t = rf_transmittance_from( v, i, rf_vec3( rays->o[0][slot], rays->o[1][slot], rays->o[2][slot] ) );
        float left[3] = { t.x, t.y, t.z };
        set_throughput( chains, slot, t );
        chains->view[slot] = view_of( path, v, i, wavefront->scratch.triangle[v->ray[i]], t );
        for ( int c = 0; c < 3; ++c )
            wavefront->arrivals.rest[c][slot] += left[c] * v->emission[c][i];
    }
}

// True if light sampling can find light at a vertex: some of its lobes are no deltas.
static bool is_lit( const RfVertexLanes* v, int i )
{
    float base = v->param[RF_PARAM_DIFFUSE][i] + v->param[RF_PARAM_DIFFUSE + 1][i] + v->param[RF_PARAM_DIFFUSE + 2][i];
    return v->param[RF_PARAM_SHAPE][i] > 0.0f || base > 0.0f;
}

static bool any_is_lit( const RfVertexLanes* v )
{
    for ( int i = 0; i < v->count; ++i )
    {
        if ( is_lit( v, i ) )
            return true;
    }
    return false;
}

static void add_light_samples( const RfPathSettings* path, int vertex, RfWavefront* wavefront, RfChains* chains )
{
    const RfVertexLanes* v = &chains->at;
    RfLightLanes* lights = &wavefront->lights;
    RfLaneScratch* s = &wavefront->scratch;
    float k = (float)path->light_samples, *f[3] = { s->f[0], s->f[1], s->f[2] };
    if ( !any_is_lit( v ) )
        return;
    for ( int j = 0; j < path->light_samples; ++j )
    {
        uint32_t dimension = dimension_of( path, vertex ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)j;
        wavefront->shadow_rays += (uint64_t)rf_sample_lights( path, wavefront, v, dimension, lights, s );
        const float* wi[3] = { lights->wi[0], lights->wi[1], lights->wi[2] };
        rf_evaluate_lanes( v, wi, f, s->pdf );
        for ( int i = 0; i < v->count; ++i )
        {
            int slot = v->slot[i];
            float scale = 1.0f / ( k * lights->pdf_solid_angle[i] + s->pdf[i] );
            for ( int c = 0; c < 3; ++c )
                wavefront->arrivals.rest[c][slot] +=
                    chains->throughput[c][slot] * s->f[c][i] * lights->radiance_cos[c][i] * scale;
        }
    }
}

// Writes the ray that leaves lane i to lane `to` of the rays.
static void write_ray( const RfVertexLanes* v, int i, const RfLaneScratch* s, float side, RfVec3 t, RfRayLanes* rays, int to )
{
    for ( int c = 0; c < 3; ++c )
    {
        rays->o[c][to] = v->p[c][i] + v->ng[c][i] * ( side * v->offset[i] );
        rays->d[c][to] = s->wi[c][i];
        rays->n[c][to] = v->n[c][i];
    }
    rays->throughput[0][to] = t.x;
    rays->throughput[1][to] = t.y;
    rays->throughput[2][to] = t.z;
    rays->pdf_solid_angle[to] = s->pdf[i];
    rays->slot[to] = v->slot[i];
}

static void scatter( const RfPathSettings* path, int vertex, RfWavefront* wavefront, RfChains* chains )
{
    const RfVertexLanes* v = &chains->at;
    RfRayLanes* rays = &wavefront->rays;
    RfLaneScratch* s = &wavefront->scratch;
    float* wi[3] = { s->wi[0], s->wi[1], s->wi[2] };
    rf_scatter_lanes( wavefront, v, dimension_of( path, vertex ) + RF_DIMENSION_SCATTER, wi, s );
    rf_draw_lanes( wavefront, v->count, v->slot, dimension_of( path, vertex ) + RF_DIMENSION_ROULETTE, 1, s->random );
    int kept = 0;
    for ( int i = 0; i < v->count; ++i )
    {
        float direction[3] = { s->wi[0][i], s->wi[1][i], s->wi[2][i] };
        float side = rf_leaving_side( v, i, direction );
        RfVec3 t = rf_mul( throughput_of( chains, v->slot[i] ), rf_vec3( s->f[0][i], s->f[1][i], s->f[2][i] ) );
        float survival = vertex < ROULETTE_AFTER ? 1.0f : rf_minf( rf_max_component( t ), 1.0f );
        if ( side == 0.0f || !( rf_max_component( t ) > 0.0f ) || s->random[0][i] >= survival )
            continue;
        if ( vertex > 1 || side < 0.0f || s->pdf[i] < RF_DELTA_PDF )
            chains->view[v->slot[i]] = RF_VIEW_CHAIN;
        write_ray( v, i, s, side, rf_scale( t, 1.0f / survival ), rays, kept++ );
    }
    rays->count = kept;
}

// Adds the light that the rays hit. What only the chain can find stays with the vertex if the chain ends there, so
// that it is reused with it.
static void add_emission( const RfPathSettings* path, bool last, RfWavefront* wavefront )
{
    RfVertexLanes* found = &wavefront->vertices;
    const RfRayLanes* rays = &wavefront->rays;
    bool kept[RF_LANES];
    for ( int i = 0; i < rf_record_count( found ); ++i )
    {
        kept[i] = !last && rays->pdf_solid_angle[found->ray[i]] >= RF_DELTA_PDF;
        found->light_pdf_solid_angle[i] = kept[i] ? 0.0f : found->light_pdf_solid_angle[i];
    }
    rf_add_emission_hits( path, rays, found, wavefront->scratch.triangle, false, &wavefront->arrivals );
    for ( int i = 0; i < rf_record_count( found ); ++i )
    {
        for ( int c = 0; c < 3 && !kept[i]; ++c )
            found->emission[c][i] = 0.0f;
    }
}

// Notes the chains that have reached an evaluable vertex, and the throughputs of all.
static void note_ends( const RfVertexLanes* found, const RfRayLanes* rays, int length, bool last, RfChains* chains )
{
    RfVertexLanes* ends = &chains->ends;
    for ( int r = 0; r < rays->count; ++r )
        set_throughput( chains, rays->slot[r],
                        rf_vec3( rays->throughput[0][r], rays->throughput[1][r], rays->throughput[2][r] ) );
    for ( int kind = 0; kind < RF_BSDF_FIRST_UNEVALUABLE && !last; ++kind )
    {
        int begin = found->first[kind], count = found->first[kind + 1] - begin;
        rf_copy_vertices( found, begin, count, rf_bsdf_model( (RfBsdfKind)kind )->params, ends, ends->count );
        for ( int i = 0; i < count; ++i )
        {
            int end = ends->count + i, slot = ends->slot[end];
            chains->kind[end] = (uint8_t)kind;
            chains->length[slot] = length;
        }
        ends->count += count;
    }
}

// Merges the evaluable first hits and the ends of chains.
static void merge_hits( const RfVertexLanes* first, RfChains* chains )
{
    RfVertexLanes* hits = &chains->hits;
    hits->count = 0;
    for ( int kind = 0; kind < RF_BSDF_FIRST_UNEVALUABLE; ++kind )
    {
        uint32_t params = rf_bsdf_model( (RfBsdfKind)kind )->params;
        int count = first->first[kind + 1] - first->first[kind];
        hits->first[kind] = hits->count;
        rf_copy_vertices( first, first->first[kind], count, params, hits, hits->count );
        hits->count += count;
        for ( int end = 0; end < chains->ends.count; ++end )
        {
            if ( chains->kind[end] == kind )
                rf_copy_vertices( &chains->ends, end, 1, params, hits, hits->count++ );
        }
    }
    for ( int kind = RF_BSDF_FIRST_UNEVALUABLE; kind <= RF_BSDF_KIND_COUNT; ++kind )
        hits->first[kind] = hits->count;
}

void rf_follow_chains( const RfPathSettings* path, const RfVertexLanes* first, const RfRayLanes* camera_rays, bool lit,
                       RfWavefront* wavefront, RfChains* chains )
{
    start( path, first, camera_rays, wavefront, chains );
    for ( int vertex = 1; vertex < path->max_depth && chains->at.count > 0; ++vertex )
    {
        if ( lit )
            add_light_samples( path, vertex, wavefront, chains );
        scatter( path, vertex, wavefront, chains );
        if ( wavefront->rays.count == 0 )
            break;
        bool last = vertex + 1 == path->max_depth;
        wavefront->path_rays += (uint64_t)wavefront->rays.count;
        rf_find_vertices( path, &wavefront->rays, false, &wavefront->vertices, &wavefront->scratch );
        rf_absorb( &wavefront->vertices, &wavefront->rays );
        add_emission( path, last, wavefront );
        note_ends( &wavefront->vertices, &wavefront->rays, vertex, last, chains );
        go_to( &wavefront->vertices, &chains->at );
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
