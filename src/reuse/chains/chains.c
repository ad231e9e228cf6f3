// Specular chains from the camera. A chain starts at a mirror, glass or a very smooth coat and ends at the first
// non-specular vertex, which becomes a hit record. Reflections at its first vertices are always followed to lights
// (split reflections).
#include "reuse/chains/chains.h"

#include "path/roulette.h"
#include "reuse/chains/coats.h"
#include "reuse/chains/mirrored.h"

#include <string.h>

// Up to this vertex of a chain, reflections are split and thin panes are vertices.
#define MOST_SPLIT 4
// Reflections more likely than this are not split: they would be followed twice.
#define SELDOM 0.5f

static inline RfVec3 throughput_of( const RfChains* chains, int slot ) { return RF_GET3( chains->throughput, slot ); }

static inline void set_throughput( RfChains* chains, int slot, RfVec3 t ) { RF_PUT3( chains->throughput, slot, t ); }

_Static_assert( RF_CHAIN_ROULETTE_BEYOND >= MOST_SPLIT, "chains that may pass panes straight have no roulette" );

// Advances the chains to the specular lanes of `found`.
static void go_to( const RfVertexLanes* found, RfVertexLanes* at )
{
    int first = rf_record_count( found );
    at->count = found->count - first;
    for ( int kind = 0; kind <= RF_BSDF_KIND_COUNT; ++kind )
    {
        at->first[kind] = kind <= RF_BSDF_FIRST_SPECULAR ? 0 : found->first[kind] - first;
        if ( kind < RF_BSDF_FIRST_SPECULAR || kind == RF_BSDF_KIND_COUNT )
            continue;
        int begin = found->first[kind], count = found->first[kind + 1] - begin;
        rf_copy_vertices( found, begin, count, rf_bsdf_model( (RfBsdfKind)kind )->params, at, begin - first );
    }
}

static uint32_t dimension_of( const RfPathSettings* path, int vertex )
{
    return RF_DIMENSION_CHAINS + rf_vertex_dimension( vertex, path->light_samples );
}

// Whether light sampling contributes at a vertex: some lobe is not a delta.
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

// What arrives by chains of a base part with this first event, where events are told apart.
static RfArrivals* arrivals_by( const RfChains* chains, int base, int event, RfWavefront* wavefront )
{
    return rf_arrivals_of_part( wavefront, base * chains->events + ( chains->events > 1 ? event : 0 ) );
}

// The first event of a chain that lane i of its vertex sends to wi; `reflects`: it only reflects.
static int event_towards( const RfChains* chains, const RfVertexLanes* v, int i, const float* const wi[3], bool reflects )
{
    int before = chains->event[v->slot[i]];
    float cos_g = v->ng[0][i] * wi[0][i] + v->ng[1][i] * wi[1][i] + v->ng[2][i] * wi[2][i];
    return before != RF_EVENT_NONE ? before : reflects || cos_g > 0.0f ? RF_EVENT_REFLECTION : RF_EVENT_TRANSMISSION;
}

// Next event estimation at chain vertices, for lobes that are not deltas, into wavefront->arrivals. `reflects`: they only reflect.
static void light_lobes( const RfPathSettings* path, int vertex, const RfVertexLanes* v, bool reflects, RfWavefront* wavefront,
                         RfChains* chains )
{
    RfLightLanes* lights = &wavefront->lights;
    RfLaneScratch* s = &wavefront->scratch;
    float k = (float)path->light_samples, *f[3] = { s->f[0], s->f[1], s->f[2] };
    if ( !any_is_lit( v ) )
        return;
    for ( int j = 0; j < path->light_samples; ++j )
    {
        uint32_t dimension = dimension_of( path, vertex ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)j;
        wavefront->shadow_rays +=
            (uint64_t)rf_sample_lights( path, wavefront, v, ( RfLightSample ){ dimension, path->frame }, lights, s );
        const float* wi[3] = { lights->wi[0], lights->wi[1], lights->wi[2] };
        rf_evaluate_lanes( v, wi, f, s->pdf );
        for ( int i = 0; i < v->count; ++i )
        {
            int slot = v->slot[i];
            float scale = rf_balance_scale( k * lights->pdf_solid_angle[i], s->pdf[i] );
            int event = chains->events > 1 ? event_towards( chains, v, i, wi, reflects ) : RF_EVENT_NONE;
            RfArrivals* to = arrivals_by( chains, path->grouped ? lights->part[i] : 0, event, wavefront );
            for ( int c = 0; c < 3; ++c )
                to->rest[c][slot] += chains->throughput[c][slot] * s->f[c][i] * lights->radiance_cos[c][i] * scale;
        }
    }
}

// A vertex of chains that scatters.
typedef struct Scattering
{
    const RfPathSettings* path;
    int vertex; // of its chains
    bool roulette;
    const RfVertexLanes* v;
    const RfLaneScratch* s;
} Scattering;

// Whether panes are vertices to the ray that leaves lane i on this side: to those of delta lobes, which no light sample competes
// with, that have room for one within max_depth.
static bool ends_at_panes( const Scattering* at, const RfChains* chains, int i, float side )
{
    int slot = at->v->slot[i], passed = chains->straight[slot] + ( chains->pane[slot] && side < 0.0f );
    return at->s->pdf[i] >= RF_DELTA_PDF && at->vertex + 1 - passed < at->path->max_depth;
}

// Appends the rays that end at panes, or the others.
static void append_rays( const Scattering* at, bool end_at_panes, RfChains* chains, RfRayLanes* rays )
{
    const RfVertexLanes* v = at->v;
    const RfLaneScratch* s = at->s;
    for ( int i = 0; i < v->count; ++i )
    {
        float direction[3] = { s->wi[0][i], s->wi[1][i], s->wi[2][i] };
        float side = rf_leaving_side( v, i, direction );
        RfVec3 t = rf_mul( throughput_of( chains, v->slot[i] ), RF_GET3( s->f, i ) );
        float survival = at->roulette ? rf_survival( rf_max_component( t ), at->vertex ) : 1.0f;
        if ( side == 0.0f || !( rf_max_component( t ) > 0.0f ) || s->random[0][i] >= survival ||
             ends_at_panes( at, chains, i, side ) != end_at_panes )
            continue;
        chains->reflected[v->slot[i]] = side > 0.0f;
        int to = rays->count++;
        t = rf_scale( t, 1.0f / survival );
        RF_PUT3( rays->throughput, to, t );
        rf_write_ray( v, i, direction, side, s->pdf[i], rays, to );
    }
}

// Scatters vertices of chains: wavefront->rays gets the rays, with the throughput of their chains, first those to which panes
// may be vertices. Returns how many these are. How many vertices they were `followed` over decides about roulette.
static int scatter_chains( const RfPathSettings* path, int vertex, int followed, const RfVertexLanes* v, RfWavefront* wavefront,
                           RfChains* chains )
{
    RfLaneScratch* s = &wavefront->scratch;
    float* wi[3] = { s->wi[0], s->wi[1], s->wi[2] };
    rf_scatter_lanes( wavefront, v, dimension_of( path, vertex ) + RF_DIMENSION_SCATTER, wi, s );
    rf_draw_lanes( wavefront, v->count, v->slot, dimension_of( path, vertex ) + RF_DIMENSION_ROULETTE, 1, s->random );
    Scattering at = { .path = path, .vertex = vertex, .roulette = followed > RF_CHAIN_ROULETTE_BEYOND, .v = v, .s = s };
    wavefront->rays.count = 0;
    append_rays( &at, true, chains, &wavefront->rays );
    int end_at_panes = wavefront->rays.count;
    append_rays( &at, false, chains, &wavefront->rays );
    return end_at_panes;
}

// Makes room for another lane of a specular model; returns which it is.
static int append( RfBsdfKind model, RfVertexLanes* lanes )
{
    int at = lanes->first[model + 1];
    if ( at < lanes->count ) // lanes of the only other model: their order does not matter
        rf_copy_vertices( lanes, at, 1, rf_bsdf_model( RF_BSDF_SPECTRAL )->params, lanes, lanes->count );
    lanes->count += 1;
    for ( int kind = (int)model + 1; kind <= RF_BSDF_KIND_COUNT; ++kind )
        lanes->first[kind] += 1;
    return at;
}

// Whether reflection at lane i, of a specular model, is one of the things that may happen there, and a rare one. At flat mirrors
// (`mirrored`) at normal incidence: the hits that they show are reused, so all cameras must agree about whose emission is
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
    RfBsdfKind kind = rf_specular_kind( v, i );
    RfBsdfLanes lanes = rf_vertex_bsdf_lanes( v, kind, 0 );
    RfVec3 wo = mirrored ? RF_GET3( v->n, i ) : RF_GET3( v->wo, i );
    return rf_reflection_probability_of_lane( kind, &lanes, i, wo ) < SELDOM;
}

// Lists reflections to split: at vertices that also transmit, unless the chain's light is counted already.
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
        RfBsdfKind kind = rf_specular_kind( at, i );
        int to = append( kind, out );
        rf_copy_vertices( at, i, 1, rf_bsdf_model( kind )->params, out, to );
        for ( int c = 0; c < 3; ++c )
            out->param[RF_PARAM_TINT + c][to] = 0.0f;
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
        rf_make_lobe( first, i, out, append( RF_BSDF_GLASS, out ) );
    }
}

// Adds emission that rays hit, of surfaces and of the sky. `reflected`: ways without an event so far have one now.
static void add_met_emission( const RfPathSettings* path, const RfVertexLanes* found, const float* pane_probability,
                              bool reflected, RfWavefront* wavefront, RfChains* chains )
{
    const RfRayLanes* rays = &wavefront->rays;
    uint8_t event[RF_LANES]; // by slot
    RfReceiver to = { .arrivals = &wavefront->arrivals, .dimmed = wavefront->dimmed };
    for ( int r = 0; r < rays->count && chains->events > 1; ++r )
    {
        int slot = rays->slot[r], before = chains->event[slot];
        event[slot] = (uint8_t)( before == RF_EVENT_NONE && reflected ? RF_EVENT_REFLECTION : before );
    }
    to.events = chains->events;
    to.event = chains->events > 1 ? event : NULL;
    rf_add_emission_hits( path, rays, found, wavefront->scratch.triangle, pane_probability, to );
}

// Adds what unlit surfaces show to those that see them by mirrors and glass alone, unless it is kept with the vertices.
static void add_unlit( const RfPathSettings* path, const RfVertexLanes* found, const bool* kept, bool reflected,
                       RfWavefront* wavefront, const RfChains* chains )
{
    const RfMaterial* materials = rf_tracer_scene( path->tracer )->materials;
    const RfRayLanes* rays = &wavefront->rays;
    for ( int i = 0; i < rf_record_count( found ); ++i )
    {
        int r = found->ray[i], slot = found->slot[i],
            part = rf_material_part( rf_tracer_lights( path->tracer ), found->material[i] );
        if ( !materials[found->material[i]].unlit || ( kept != NULL && kept[i] ) || rays->pdf_solid_angle[r] < RF_DELTA_PDF )
            continue;
        int event = chains->event[slot] == RF_EVENT_NONE && reflected ? RF_EVENT_REFLECTION : chains->event[slot];
        RfArrivals* to = arrivals_by( chains, rf_counts_in( path, part ), event, wavefront );
        for ( int c = 0; c < 3; ++c )
            to->rest[c][slot] += found->emission[c][i] * rays->throughput[c][r];
    }
}

// Adds emission that split reflections hit.
static void add_reflected_emission( const RfPathSettings* path, RfWavefront* wavefront, RfChains* chains )
{
    rf_count_path_rays( wavefront, &wavefront->rays );
    const float* pane_probability =
        rf_find_vertices_past_panes( path, &wavefront->rays, 0, &wavefront->vertices, &wavefront->scratch );
    rf_absorb( &wavefront->vertices, &wavefront->rays );
    add_met_emission( path, &wavefront->vertices, pane_probability, true, wavefront, chains );
    add_unlit( path, &wavefront->vertices, NULL, true, wavefront, chains );
}

// Advances the reflections to the mirrors and glass that they hit, the `vertex`-th vertices of their chains.
static void follow_reflections( const RfPathSettings* path, int vertex, const RfWavefront* wavefront, RfVertexLanes* at,
                                RfChains* chains )
{
    const RfRayLanes* rays = &wavefront->rays;
    for ( int r = 0; r < rays->count; ++r )
    {
        bool last = vertex - chains->straight[rays->slot[r]] >= path->max_depth;
        RfVec3 t = RF_GET3( rays->throughput, r );
        set_throughput( chains, rays->slot[r], last ? rf_vec3( 0, 0, 0 ) : t );
    }
    go_to( &wavefront->vertices, at );
}

// Splits the reflections at the chains' `vertex`-th vertices: adds the light that they find to wavefront->arrivals, and marks
// them in chains->split. With `coats`, smooth coats among these first vertices as well; NULL: later ones.
static void split_reflections( const RfPathSettings* path, int vertex, const RfVertexLanes* coats, RfWavefront* wavefront,
                               RfChains* chains )
{
    RfVertexLanes* at = &chains->hits; // not in use yet
    list_reflections( vertex, chains, at );
    if ( coats != NULL )
        list_coats( coats, chains, at );
    if ( at->count == 0 )
        return;
    light_lobes( path, vertex, at, true, wavefront, chains );
    float throughput[3][RF_LANES];
    memcpy( throughput, chains->throughput, sizeof throughput );
    for ( int followed = 1; at->count > 0; ++followed )
    {
        scatter_chains( path, vertex, followed, at, wavefront, chains );
        if ( wavefront->rays.count == 0 )
            break;
        add_reflected_emission( path, wavefront, chains );
        follow_reflections( path, ++vertex, wavefront, at, chains );
    }
    memcpy( chains->throughput, throughput, sizeof throughput );
}

bool rf_has_chains( const RfVertexLanes* first )
{
    if ( rf_record_count( first ) < first->count )
        return true;
    for ( int i = first->first[RF_BSDF_GGX]; i < first->first[RF_BSDF_GGX + 1]; ++i )
    {
        if ( rf_is_smooth_coat( first, i ) )
            return true;
    }
    return false;
}

// The view of a chain that starts here, if it is reflected and then ends.
static uint8_t view_of( const RfPathSettings* path, const RfVertexLanes* v, int i, uint32_t triangle, RfVec3 throughput )
{
    unsigned mirror = rf_triangle_mirror( path->tracer, triangle );
    float cos_o = v->n[0][i] * v->wo[0][i] + v->n[1][i] * v->wo[1][i] + v->n[2][i] * v->wo[2][i], ior = v->param[RF_PARAM_IOR][i];
    bool inside = rf_max_component( throughput ) < 1.0f || ( ior > 0.0f && ior < 1.0f );
    return mirror == RF_NO_MIRROR || cos_o < RF_MIN_COS || inside ? RF_VIEW_CHAIN : (uint8_t)( RF_VIEW_FIRST_MIRROR + mirror );
}

bool rf_is_at_pane( const RfTracer* tracer, const RfVertexLanes* v, int i )
{
    if ( !rf_tracer_has_panes( tracer ) || !( v->param[RF_PARAM_IOR][i] < 0.0f ) )
        return false;
    RfBsdfKind kind = rf_specular_kind( v, i );
    RfBsdfLanes lanes = rf_vertex_bsdf_lanes( v, kind, 0 );
    return rf_pane_of_lane( kind, &lanes, i, RF_GET3( v->wo, i ) ).probability > 0.0f;
}

// What arrives of the light group of a material's emission, before any event.
static RfArrivals* arrivals_of_material( const RfPathSettings* path, const RfChains* chains, RfWavefront* wavefront,
                                         int32_t material )
{
    int part = rf_material_part( rf_tracer_lights( path->tracer ), material );
    return arrivals_by( chains, rf_counts_in( path, part ), RF_EVENT_NONE, wavefront );
}

// Mirrors and glass: what the cameras see of their emission, absorbed on the way if the camera is inside a body.
static void start_at_glass( const RfPathSettings* path, const RfRayLanes* rays, RfWavefront* wavefront, RfChains* chains )
{
    const RfVertexLanes* v = &chains->at;
    for ( int i = 0; i < v->count; ++i )
    {
        int slot = v->slot[i];
        RfVec3 t = rf_transmittance_from( v, i, RF_GET3( rays->o, slot ) );
        float left[3] = { t.x, t.y, t.z };
        set_throughput( chains, slot, t );
        chains->view[slot] = view_of( path, v, i, wavefront->scratch.triangle[v->ray[i]], t );
        RfVec3 emission = rf_emission_in_frame( path, v, i );
        const float light[3] = { emission.x, emission.y, emission.z };
        RfArrivals* to = arrivals_of_material( path, chains, wavefront, v->material[i] );
        for ( int c = 0; c < 3; ++c )
            to->rest[c][slot] += left[c] * light[c];
    }
}

// Smooth coats: draws the base or the lobe.
static void start_at_coats( const RfPathSettings* path, const RfVertexLanes* first, RfWavefront* wavefront, RfChains* chains )
{
    RfVertexLanes* at = &chains->at;
    int ggx = first->first[RF_BSDF_GGX], count = first->first[RF_BSDF_GGX + 1] - ggx;
    float u[1][RF_LANES];
    rf_draw_lanes( wavefront, count, first->slot + ggx, RF_DIMENSION_CHAINS, 1, u );
    for ( int i = ggx; i < ggx + count; ++i )
    {
        if ( !rf_is_smooth_coat( first, i ) )
            continue;
        int slot = first->slot[i];
        float base = rf_base_probability_of( first, i );
        chains->view[slot] = u[0][i - ggx] < base ? RF_VIEW_BASE : RF_VIEW_CHAIN;
        if ( chains->view[slot] == RF_VIEW_BASE )
            continue;
        RfVec3 emission = rf_emission_in_frame( path, first, i );
        const float light[3] = { emission.x, emission.y, emission.z };
        RfArrivals* to = arrivals_of_material( path, chains, wavefront, first->material[i] );
        for ( int c = 0; c < 3 && base == 0.0f; ++c ) // otherwise the base has it
            to->rest[c][slot] += light[c];
        chains->lobe_weight[slot] = 1.0f / ( 1.0f - base );
        rf_make_lobe( first, i, at, append( RF_BSDF_GLASS, at ) );
    }
}

// Fills view, throughput and split, and makes the first vertices of chains those where they are. With `lit`, adds
// what their reflections see of lights to wavefront->arrivals.
static void start_chains( const RfPathSettings* path, const RfVertexLanes* first, const RfRayLanes* camera_rays, bool lit,
                          RfWavefront* wavefront, RfChains* chains )
{
    memset( chains->length, 0, sizeof chains->length );
    memset( chains->view, RF_VIEW_DIRECT, sizeof chains->view );
    memset( chains->split, 0, sizeof chains->split );
    memset( chains->counted, 0, sizeof chains->counted );
    memset( chains->pane, 0, sizeof chains->pane );
    memset( chains->straight, 0, sizeof chains->straight );
    for ( int i = 0; chains->triangle != NULL && i < camera_rays->count; ++i )
        chains->triangle[i] = RF_MISS;
    memset( chains->event, RF_EVENT_NONE, sizeof chains->event );
    for ( int k = 0; k < rf_base_parts( path ) * chains->events; ++k )
        memset( rf_arrivals_of_part( wavefront, k ), 0, sizeof wavefront->arrivals );
    for ( int i = 0; i < camera_rays->count; ++i )
    {
        set_throughput( chains, i, rf_vec3( 1, 1, 1 ) );
        chains->lobe_weight[i] = 1.0f;
    }
    go_to( first, &chains->at );
    start_at_glass( path, camera_rays, wavefront, chains );
    start_at_coats( path, first, wavefront, chains );
    for ( int k = 0; k < rf_base_parts( path ) * chains->events && chains->clamped; ++k )
        memcpy( chains->finds[k].light, rf_arrivals_of_part( wavefront, k )->rest, sizeof chains->finds->light );
    if ( lit && path->max_depth > 1 )
        split_reflections( path, 1, first, wavefront, chains );
    for ( int i = 0; i < chains->at.count; ++i )
    {
        int slot = chains->at.slot[i];
        set_throughput( chains, slot, rf_scale( throughput_of( chains, slot ), chains->lobe_weight[slot] ) );
    }
    chains->ends.count = 0;
}

// Next event estimation at the chains' current vertices; split ones have had theirs.
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
        RfBsdfKind kind = rf_specular_kind( at, i );
        rf_copy_vertices( at, i, 1, rf_bsdf_model( kind )->params, unlit, append( kind, unlit ) );
    }
    if ( unlit->count > 0 )
        light_lobes( path, vertex, unlit, false, wavefront, chains );
}

// The light that chains find at their vertices.
static void find_lights( const RfPathSettings* path, int vertex, RfWavefront* wavefront, RfChains* chains )
{
    for ( int i = 0; vertex > MOST_SPLIT && i < chains->at.count; ++i )
        chains->split[chains->at.slot[i]] = 0;
    if ( vertex > 1 && vertex <= MOST_SPLIT )
        split_reflections( path, vertex, NULL, wavefront, chains );
    light_chains( path, vertex, wavefront, chains );
}

static void note_panes_at( const RfPathSettings* path, RfChains* chains )
{
    const RfVertexLanes* at = &chains->at;
    for ( int i = 0; i < at->count; ++i )
        chains->pane[at->slot[i]] = rf_is_at_pane( path->tracer, at, i );
}

// Classifies the chains by their last event: transmission through panes counts as direct view, one reflection in a flat mirror
// as the view of its image, all else as a chain that no other camera can follow.
static void note_events( int vertex, RfWavefront* wavefront, RfChains* chains )
{
    const RfRayLanes* rays = &wavefront->rays;
    for ( int r = 0; r < rays->count; ++r )
    {
        int slot = rays->slot[r];
        bool reflected = chains->reflected[slot], passed = chains->pane[slot] && !reflected;
        bool straight = passed && ( vertex == 1 || chains->view[slot] == RF_VIEW_DIRECT );
        chains->straight[slot] += passed;
        if ( chains->event[slot] == RF_EVENT_NONE && !straight )
            chains->event[slot] = reflected ? RF_EVENT_REFLECTION : RF_EVENT_TRANSMISSION;
        chains->counted[slot] |= chains->split[slot] && reflected;
        if ( straight )
            chains->view[slot] = RF_VIEW_DIRECT;
        else if ( vertex > 1 || !reflected || rays->pdf_solid_angle[r] < RF_DELTA_PDF )
            chains->view[slot] = RF_VIEW_CHAIN;
    }
}

// Drops emission that a split reflection has counted already.
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
                          RfChains* chains )
{
    RfVertexLanes* found = &wavefront->vertices;
    const RfRayLanes* rays = &wavefront->rays;
    bool kept[RF_LANES];
    for ( int i = 0; i < rf_record_count( found ); ++i )
    {
        kept[i] = !is_last( path, chains, found->slot[i], vertex + 1 ) && rays->pdf_solid_angle[found->ray[i]] >= RF_DELTA_PDF;
        found->light_pdf_solid_angle[i] = kept[i] ? 0.0f : found->light_pdf_solid_angle[i];
    }
    add_met_emission( path, found, pane_probability, false, wavefront, chains );
    add_unlit( path, found, kept, false, wavefront, chains );
    for ( int i = 0; i < rf_record_count( found ); ++i )
    {
        for ( int c = 0; c < 3 && !kept[i]; ++c )
            found->emission[c][i] = 0.0f;
    }
}

// True where a camera in front of the pane would draw the base or the lobe of a coat.
static bool is_coat_behind_pane( const RfChains* chains, int slot, const RfVertexLanes* found, int kind, int i )
{
    return chains->view[slot] == RF_VIEW_DIRECT && kind == RF_BSDF_GGX && rf_is_smooth_coat( found, i );
}

// Records the chains that have reached a non-specular vertex, and the throughputs of all. `triangle`: that rays hit. No other camera
// sees what moves.
static void note_ends( const RfPathSettings* path, const RfVertexLanes* found, const RfRayLanes* rays, const uint32_t* triangle,
                       int vertex, RfChains* chains )
{
    bool swept = rf_tracer_has_swept( path->tracer );
    RfVertexLanes* ends = &chains->ends;
    for ( int r = 0; r < rays->count; ++r )
        set_throughput( chains, rays->slot[r], RF_GET3( rays->throughput, r ) );
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        for ( int i = found->first[kind]; i < found->first[kind + 1]; ++i )
        {
            int slot = found->slot[i];
            if ( is_last( path, chains, slot, vertex + 1 ) )
                continue;
            bool moving = swept && rf_is_moving( path->tracer, triangle[found->ray[i]] );
            if ( moving || is_coat_behind_pane( chains, slot, found, kind, i ) )
                chains->view[slot] = RF_VIEW_CHAIN;
            chains->kind[ends->count] = (uint8_t)kind;
            if ( chains->triangle != NULL )
                chains->triangle[slot] = triangle[found->ray[i]];
            chains->length[slot] = vertex - chains->straight[slot];
            rf_copy_vertices( found, i, 1, rf_bsdf_model( (RfBsdfKind)kind )->params, ends, ends->count++ );
        }
    }
}

// Ends the chains that max_depth leaves no vertex.
static void end_last( const RfPathSettings* path, int vertex, RfChains* chains )
{
    for ( int i = 0; i < chains->at.count; ++i )
    {
        int slot = chains->at.slot[i];
        if ( is_last( path, chains, slot, vertex ) )
            set_throughput( chains, slot, rf_vec3( 0, 0, 0 ) );
    }
}

// Appends the non-specular first hits of a model; coats that were split leave their base.
static void append_first( const RfVertexLanes* first, int kind, const RfChains* chains, RfVertexLanes* hits )
{
    RfBsdfParams params = rf_bsdf_model( (RfBsdfKind)kind )->params;
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

// What has arrived, with a clamp since the chains started.
static void note_finds( const RfArrivals* arrivals, bool clamped, RfChainFinds* finds )
{
    if ( !clamped )
        memcpy( finds->light, arrivals->rest, sizeof finds->light );
    for ( int k = 0; k < 3 * RF_LANES && clamped; ++k )
    {
        int c = k / RF_LANES, slot = k % RF_LANES;
        finds->found[c][slot] = arrivals->rest[c][slot] - finds->light[c][slot];
    }
}

void rf_follow_chains( const RfPathSettings* path, const RfVertexLanes* first, const RfRayLanes* camera_rays, bool lit,
                       RfWavefront* wavefront, RfChains* chains )
{
    start_chains( path, first, camera_rays, lit, wavefront, chains );
    int end = path->max_depth == 1 ? 1 : path->max_depth + MOST_SPLIT * rf_tracer_has_panes( path->tracer );
    for ( int vertex = 1; vertex < end && chains->at.count > 0; ++vertex )
    {
        end_last( path, vertex, chains );
        note_panes_at( path, chains );
        if ( lit )
            find_lights( path, vertex, wavefront, chains );
        int end_at_panes = scatter_chains( path, vertex, vertex, &chains->at, wavefront, chains );
        if ( wavefront->rays.count == 0 )
            break;
        note_events( vertex, wavefront, chains );
        rf_count_path_rays( wavefront, &wavefront->rays );
        int first_past = vertex < MOST_SPLIT ? end_at_panes : 0;
        const float* pane_probability =
            rf_find_vertices_past_panes( path, &wavefront->rays, first_past, &wavefront->vertices, &wavefront->scratch );
        rf_absorb( &wavefront->vertices, &wavefront->rays );
        drop_counted_light( chains, wavefront );
        add_emission( path, pane_probability, vertex, wavefront, chains );
        note_ends( path, &wavefront->vertices, &wavefront->rays, wavefront->scratch.triangle, vertex, chains );
        go_to( &wavefront->vertices, &chains->at );
    }
    for ( int k = 0; k < rf_base_parts( path ) * chains->events; ++k )
        note_finds( rf_arrivals_of_part( wavefront, k ), chains->clamped, chains->finds + k );
    merge_hits( first, chains );
}

void rf_split_tiles( const RfVertexLanes* hits, const int32_t* key, int32_t* tile_of, int* tile_count )
{
    int32_t head[RF_LANES]; // by old tile: its first new one
    int32_t slot_of[RF_LANES], next[RF_LANES];
    int32_t count = 0;
    memset( head, -1, (size_t)*tile_count * sizeof *head );
    for ( int i = 0; i < rf_record_count( hits ); ++i )
    {
        int slot = hits->slot[i];
        int32_t* tile = head + tile_of[slot];
        while ( *tile >= 0 && key[slot_of[*tile]] != key[slot] )
            tile = next + *tile;
        if ( *tile < 0 )
        {
            *tile = count;
            slot_of[count] = slot;
            next[count++] = -1;
        }
        tile_of[slot] = *tile;
    }
    *tile_count = count;
}
