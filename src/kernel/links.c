#include "kernel/links_internal.h"

#include <string.h>

// The light of a solved link before its normalisation; 0 where nothing arrives.
static RfVec3 light_of( const RfLinkWork* w, const RfLink* link )
{
    const RfVertexLanes* v = w->v;
    const RfChain* chain = &link->chain;
    const RfEmission* e = &chain->start;
    int i = link->lane;
    RfVec3 y = rf_start_of( v, i ), none = rf_vec3( 0, 0, 0 );
    float cos_x = rf_dot( rf_lane_of( v->n, i ), link->wi );
    if ( !( cos_x > 0.0f && rf_dot( rf_lane_of( v->ng, i ), link->wi ) > 0.0f ) )
        return none;
    float spread = rf_chain_spread( w->settings->path->tracer, chain, y );
    float cos_light = e->infinite || e->delta_position ? 1.0f : rf_dot( e->normal, e->direction );
    float fixed_pdf = e->pdf_light * ( e->infinite ? e->pdf_solid_angle : e->pdf_area );
    float last = rf_length( rf_sub( chain->vertex[chain->length - 1].p, y ) );
    float falloff = rf_emission_falloff( e, chain->way + last );
    float scale = cos_x * cos_light * falloff * link->scale * link->path->weight / ( spread * fixed_pdf );
    RfVec3 absorbed = rf_vec3( expf( -chain->end_absorption.x * last ), expf( -chain->end_absorption.y * last ),
                               expf( -chain->end_absorption.z * last ) );
    RfVec3 light = rf_scale( rf_mul( rf_mul( e->radiance, chain->weight ), absorbed ), scale );
    float sum = light.x + light.y + light.z;
    return sum > 0.0f && sum < INFINITY ? light : none;
}

// The area that a link covers at a matte vertex, where light paths scatter (rf_own_weight).
static float area_of( const RfLinkWork* w, const RfLink* link, const RfBend* bend )
{
    float step[2], miss, spread;
    if ( !rf_may_scatter( w->settings->path->tracer, &link->chain ) || !rf_is_matte_lane( w->settings->path, w->v, link->lane ) ||
         !rf_newton_step( &link->chain.end, bend->y, bend->n, step, &miss, &spread ) )
        return INFINITY;
    return rf_reach_area( &link->reach ) * spread / w->settings->paths->links;
}

// Solves all links; those that fail, or whose solution is out of reach, are closed.
static void solve( RfLinkWork* w )
{
    const RfTracer* tracer = w->settings->path->tracer;
    const RfLightPaths* paths = w->settings->paths;
    for ( int k = 0; k < w->count; ++k )
    {
        const RfLink* link = w->link + k;
        RfBend* bend = w->bend + k;
        bend->at.start = link->path->start;
        bend->at.events = link->path->events;
        bend->at.length = link->path->length;
        bend->at.end = link->path->end;
        bend->y = rf_start_of( w->v, link->lane );
        bend->n = rf_lane_of( w->v->ng, link->lane );
        bend->most = rf_scaled_reach( &link->path->reach, RF_STEP_MARGIN );
        bend->active = true;
    }
    rf_bend_chains( tracer, w->count, w->bend, &w->out->rays );
    for ( int k = 0; k < w->count; ++k )
    {
        RfLink* link = w->link + k;
        link->open = w->bend[k].met;
        if ( !link->open )
            continue;
        link->chain = w->bend[k].at;
        RfVec3 y = w->bend[k].y;
        float pdf = rf_steer_pdf( paths, &link->chain );
        RfFootprint footprint = rf_find_footprint( paths, rf_tracer_lights( tracer ), &link->chain, pdf, y, w->bend[k].n );
        link->reach = footprint.reach;
        float found = (float)paths->emitted / paths->share * pdf;
        link->most = found * footprint.most;
        link->rare_most = found * footprint.rare_most;
        link->open = link->reach.along > 0.0f && rf_reach_to( &link->reach, &link->chain.start, &link->path->start ) <= 1.0f;
        link->wi = rf_normalize( rf_sub( link->chain.vertex[link->chain.length - 1].p, y ) );
        link->chance = rf_chance_area( paths, &link->chain, rf_reach_area( &link->reach ), pdf, y );
        link->light = link->open && link->chance < INFINITY ? light_of( w, link ) : rf_vec3( 0, 0, 0 );
        link->open = link->open && rf_max_component( link->light ) > 0.0f;
        link->repeats = 1.0f;
        link->area = area_of( w, link, w->bend + k );
    }
}

// Shadow rays to the last vertices of the chains.
static void test_visibility( RfLinkWork* w )
{
    float o[3][RF_CHAIN_BLOCK], d[3][RF_CHAIN_BLOCK], visible[RF_CHAIN_BLOCK];
    int index[RF_CHAIN_BLOCK], count = 0;
    for ( int k = 0; k < w->count; ++k )
    {
        const RfLink* link = w->link + k;
        if ( !link->open )
            continue;
        RfVec3 from = rf_start_of( w->v, link->lane ), way = rf_sub( link->chain.end.o, from );
        rf_put_ray( o, d, count, from, way );
        index[count++] = k;
    }
    const float *from[3] = { o[0], o[1], o[2] }, *way[3] = { d[0], d[1], d[2] };
    rf_trace_segments( w->settings->path->tracer, count, from, way, visible );
    w->out->rays += (uint64_t)count;
    for ( int k = 0; k < count; ++k )
        w->link[index[k]].open = visible[k] > 0.0f;
}

// The weight of a link at a vertex that a ray of the vertex before has found.
static float own_weight( const RfLinkWork* w, const RfLink* link )
{
    const RfVertexLanes* v = w->v;
    const RfRayLanes* rays = w->rays;
    int i = link->lane, r = v->ray[i];
    if ( rays == NULL || !w->keys->matte[v->slot[i]] )
        return 1.0f;
    return rf_own_weight( w->settings->linker.parents, link->area, rf_lane_of( rays->o, r ), rf_lane_of( rays->n, r ),
                          rf_lane_of( v->p, i ), rf_lane_of( v->ng, i ) );
}

static void add( RfLinkWork* w, const RfLink* link )
{
    const RfLightPaths* paths = w->settings->paths;
    float found = rf_reach_area( &link->reach ) * (float)paths->emitted, weight = own_weight( w, link );
    if ( w->settings->normalization != RF_KERNEL_DENSITY )
        weight *= rf_link_weight( paths, link->chance, rf_dot( rf_lane_of( w->v->n, link->lane ), link->wi ), w->vertex );
    if ( paths->measures )
        rf_measure_link( w, link, rf_luminance( link->light ) * link->repeats / found );
    RfVec3 light = rf_scale( link->light, link->repeats * weight / found );
    if ( rf_max_component( light ) > 0.0f )
        rf_add_light( w, link->lane, link->key, link->wi, light, link->area );
}

// Photon mapping: what lands around the eye vertex is taken to land there, evenly over the footprint.
static void estimate_density( RfLinkWork* w )
{
    for ( int k = 0; k < w->count; ++k )
    {
        RfLink* link = w->link + k;
        link->wi = rf_scale( link->path->end.d, -1.0f );
        link->light = rf_scale( link->path->flux, link->scale );
        link->reach = ( RfReach ){ { 1.0f, 0.0f }, link->path->at.half.x, link->path->at.half.x };
        link->repeats = 1.0f;
        link->area = INFINITY;
        link->open = rf_dot( rf_lane_of( w->v->n, link->lane ), link->wi ) > 0.0f &&
                     rf_dot( rf_lane_of( w->v->ng, link->lane ), link->wi ) > 0.0f;
    }
}

static void bend_links( RfLinkWork* w )
{
    solve( w );
    test_visibility( w );
    if ( w->settings->normalization == RF_KERNEL_EXACT )
        rf_repeat_trials( w );
}

static void flush( RfLinkWork* w )
{
    if ( w->count == 0 )
        return;
    if ( w->settings->normalization == RF_KERNEL_DENSITY )
        estimate_density( w );
    else
        bend_links( w );
    for ( int k = 0; k < w->count; ++k )
    {
        if ( w->link[k].open )
            add( w, w->link + k );
    }
    w->count = 0;
}

static void link_lane( RfLinkWork* w, RfRandomKey lane, int i )
{
    RfCandidates c;
    rf_begin_candidates( w, i, &w->settings->paths->tree, rf_note_path, &c );
    float scale = rf_find_candidates( &c, lane );
    RfAcceptance trials = rf_weigh_candidates( w, lane, scale, i, &c );
    for ( int k = 0; k < c.kept; ++k )
    {
        RfLink* link = w->link + w->count;
        *link = ( RfLink ){ .lane = i, .path = w->settings->paths->path + c.path[k] };
        link->scale = rf_accept( &trials, &c, k, &link->key );
        link->offered = trials.trials * rf_offered( &trials, &c, k ) / w->settings->paths->share;
        w->count += link->scale > 0.0f;
        if ( w->count == RF_CHAIN_BLOCK )
            flush( w );
    }
}

void rf_link_vertices( const RfKernelLinker* linker, RfWavefront* keys, const RfRayLanes* rays, const RfVertexLanes* v,
                       int vertex )
{
    RfLinkLanes* out = linker->out;
    RfLinkWork w; // its arrays are large: they stay as they are
    w.settings = linker;
    w.keys = keys;
    w.rays = rays;
    w.vertex = vertex;
    w.v = v;
    w.out = out;
    w.count = w.parent_count = 0;
    memset( w.chosen, 0, sizeof w.chosen );
    int count = rf_record_count( v );
    out->rays = out->trials = 0;
    out->searched += (uint64_t)count;
    memset( out->light, 0, sizeof out->light );
    memset( out->one, 0, sizeof out->one );
    memset( out->found, 0, sizeof out->found );
    for ( int c = 0; c < 3; ++c )
        memcpy( out->wi[c], v->n[c], (size_t)count * sizeof( float ) );
    for ( int i = 0; i < count; ++i )
    {
        int slot = v->slot[i];
        RfRandomKey lane = rf_pixel_key( (uint64_t)keys->key_a[slot] << 32 | keys->key_b[slot], 0x6b65726eu + (uint32_t)vertex );
        link_lane( &w, lane, i );
        rf_link_parents( &w, lane, i );
    }
    flush( &w );
    rf_flush_parents( &w );
    for ( int i = 0; i < count; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            out->one[c][i] *= w.chosen[i];
    }
    keys->path_rays += out->rays;
    out->all_rays += out->rays;
}

// Links as light samples.
static void sample( const RfLinker* linker, RfWavefront* keys, const RfRayLanes* rays, const RfVertexLanes* v, int vertex,
                    RfLightLanes* out, float* area )
{
    const RfKernelLinker* kernel = (const RfKernelLinker*)(const void*)linker;
    const RfLinkLanes* links = kernel->out;
    int count = rf_record_count( v );
    rf_link_vertices( kernel, keys, area == NULL ? rays : NULL, v, vertex );
    float scale = RF_DELTA_PDF * (float)kernel->path->light_samples;
    for ( int i = 0; i < v->count; ++i )
    {
        bool found = i < count && links->found[i] > 0;
        for ( int c = 0; c < 3; ++c )
        {
            out->wi[c][i] = found ? links->wi[c][i] : v->n[c][i];
            out->radiance_cos[c][i] = found ? links->one[c][i] * scale : 0.0f;
        }
        out->pdf_solid_angle[i] = found ? RF_DELTA_PDF : 1.0f;
    }
    for ( int i = 0; i < v->count && area != NULL; ++i )
        area[i] = i < count && links->found[i] > 0 ? links->area[i] : INFINITY;
}

RfKernelLinker rf_make_linker( const RfLightPaths* paths, RfKernelNormalization normalization, const RfPathSettings* path,
                               RfLinkLanes* lanes )
{
    RfLinker linker = { sample, paths->parents, paths->linked, lanes->trail, rf_weigh_chance };
    return ( RfKernelLinker ){ linker, path, paths, normalization, lanes };
}
