#include "light_paths/connections_internal.h"

#include <string.h>

// The light of a solved connection before its normalisation; 0 where nothing arrives.
static RfVec3 light_of( const RfConnectionWork* w, const RfConnection* connection )
{
    const RfVertexLanes* v = w->v;
    const RfChain* chain = &connection->chain;
    const RfEmission* e = &chain->start;
    int i = connection->lane;
    RfVec3 y = rf_start_of( v, i ), none = rf_vec3( 0, 0, 0 );
    float cos_x = rf_dot( rf_lane_of( v->n, i ), connection->wi );
    if ( !( cos_x > 0.0f && rf_dot( rf_lane_of( v->ng, i ), connection->wi ) > 0.0f ) )
        return none;
    float spread = rf_chain_spread( w->settings->path->tracer, chain, y );
    float cos_light = e->infinite || e->delta_position ? 1.0f : rf_dot( e->normal, e->direction );
    float fixed_pdf = e->pdf_light * ( e->infinite ? e->pdf_solid_angle : e->pdf_area );
    float last = rf_length( rf_sub( chain->vertex[chain->length - 1].p, y ) );
    float falloff = rf_emission_falloff( e, chain->way + last );
    float scale = cos_x * cos_light * falloff * connection->scale * connection->path->weight / ( spread * fixed_pdf );
    RfVec3 absorbed = rf_vec3( expf( -chain->end_absorption.x * last ), expf( -chain->end_absorption.y * last ),
                               expf( -chain->end_absorption.z * last ) );
    RfVec3 light = rf_scale( rf_mul( rf_mul( e->radiance, chain->weight ), absorbed ), scale );
    float sum = light.x + light.y + light.z;
    return sum > 0.0f && sum < INFINITY ? light : none;
}

// The area that a connection covers at a matte vertex, where light paths scatter (rf_own_weight).
static float area_of( const RfConnectionWork* w, const RfConnection* connection, const RfBend* bend )
{
    float step[2], miss, spread;
    if ( !rf_may_scatter( w->settings->path->tracer, &connection->chain ) ||
         !rf_is_matte_lane( w->settings->path, w->v, connection->lane ) ||
         !rf_newton_step( &connection->chain.end, bend->y, bend->n, step, &miss, &spread ) )
        return INFINITY;
    return rf_reach_area( &connection->reach ) * spread / w->settings->paths->connections;
}

// Solves all connections; those that fail, or whose solution is out of reach, are closed.
static void solve( RfConnectionWork* w )
{
    const RfTracer* tracer = w->settings->path->tracer;
    const RfLightPaths* paths = w->settings->paths;
    for ( int k = 0; k < w->count; ++k )
    {
        const RfConnection* connection = w->connection + k;
        RfBend* bend = w->bend + k;
        bend->at.start = connection->path->start;
        bend->at.events = connection->path->events;
        bend->at.length = connection->path->length;
        bend->at.end = connection->path->end;
        bend->y = rf_start_of( w->v, connection->lane );
        bend->n = rf_lane_of( w->v->ng, connection->lane );
        bend->most = rf_scaled_reach( &connection->path->reach, RF_STEP_MARGIN );
        bend->active = true;
    }
    rf_bend_chains( tracer, w->count, w->bend, &w->out->rays );
    for ( int k = 0; k < w->count; ++k )
    {
        RfConnection* connection = w->connection + k;
        connection->open = w->bend[k].met;
        if ( !connection->open )
            continue;
        connection->chain = w->bend[k].at;
        RfVec3 y = w->bend[k].y;
        float pdf = rf_steer_pdf( paths, &connection->chain );
        RfFootprint footprint = rf_find_footprint( paths, rf_tracer_lights( tracer ), &connection->chain, pdf, y, w->bend[k].n );
        connection->reach = footprint.reach;
        float found = (float)paths->emitted / paths->share * pdf;
        connection->most = found * footprint.most;
        connection->rare_most = found * footprint.rare_most;
        connection->open = connection->reach.along > 0.0f &&
                           rf_reach_to( &connection->reach, &connection->chain.start, &connection->path->start ) <= 1.0f;
        connection->wi = rf_normalize( rf_sub( connection->chain.vertex[connection->chain.length - 1].p, y ) );
        connection->chance = rf_chance_area( paths, &connection->chain, rf_reach_area( &connection->reach ), pdf, y );
        connection->light = connection->open && connection->chance < INFINITY ? light_of( w, connection ) : rf_vec3( 0, 0, 0 );
        connection->open = connection->open && rf_max_component( connection->light ) > 0.0f;
        connection->repeats = 1.0f;
        connection->area = area_of( w, connection, w->bend + k );
    }
}

// Shadow rays to the last vertices of the chains.
static void test_visibility( RfConnectionWork* w )
{
    float o[3][RF_CHAIN_BLOCK], d[3][RF_CHAIN_BLOCK], visible[RF_CHAIN_BLOCK];
    int index[RF_CHAIN_BLOCK], count = 0;
    for ( int k = 0; k < w->count; ++k )
    {
        const RfConnection* connection = w->connection + k;
        if ( !connection->open )
            continue;
        RfVec3 from = rf_start_of( w->v, connection->lane ), way = rf_sub( connection->chain.end.o, from );
        rf_put_ray( o, d, count, from, way );
        index[count++] = k;
    }
    const float *from[3] = { o[0], o[1], o[2] }, *way[3] = { d[0], d[1], d[2] };
    rf_trace_segments( w->settings->path->tracer, count, from, way, visible );
    w->out->rays += (uint64_t)count;
    for ( int k = 0; k < count; ++k )
        w->connection[index[k]].open = visible[k] > 0.0f;
}

// The weight of a connection at a vertex that a ray of the vertex before has found.
static float own_weight( const RfConnectionWork* w, const RfConnection* connection )
{
    const RfVertexLanes* v = w->v;
    const RfRayLanes* rays = w->rays;
    int i = connection->lane, r = v->ray[i];
    if ( rays == NULL || !w->keys->matte[v->slot[i]] )
        return 1.0f;
    return rf_own_weight( w->settings->connector.vpl_connections, connection->area, rf_lane_of( rays->o, r ),
                          rf_lane_of( rays->n, r ), rf_lane_of( v->p, i ), rf_lane_of( v->ng, i ) );
}

static void add( RfConnectionWork* w, const RfConnection* connection )
{
    const RfLightPaths* paths = w->settings->paths;
    float found = rf_reach_area( &connection->reach ) * (float)paths->emitted, weight = own_weight( w, connection );
    if ( w->settings->normalization != RF_KERNEL_DENSITY )
        weight *= rf_connection_weight( paths, connection->chance,
                                        rf_dot( rf_lane_of( w->v->n, connection->lane ), connection->wi ), w->vertex );
    if ( paths->measures )
        rf_measure_connection( w, connection, rf_luminance( connection->light ) * connection->repeats / found );
    RfVec3 light = rf_scale( connection->light, connection->repeats * weight / found );
    if ( rf_max_component( light ) > 0.0f )
        rf_add_light( w, connection->lane, connection->key, connection->wi, light, connection->area );
}

// Photon mapping: what lands around the eye vertex is taken to land there, evenly over the footprint.
static void estimate_density( RfConnectionWork* w )
{
    for ( int k = 0; k < w->count; ++k )
    {
        RfConnection* connection = w->connection + k;
        connection->wi = rf_scale( connection->path->end.d, -1.0f );
        connection->light = rf_scale( connection->path->flux, connection->scale );
        connection->reach = ( RfReach ){ { 1.0f, 0.0f }, connection->path->at.half.x, connection->path->at.half.x };
        connection->repeats = 1.0f;
        connection->area = INFINITY;
        connection->open = rf_dot( rf_lane_of( w->v->n, connection->lane ), connection->wi ) > 0.0f &&
                           rf_dot( rf_lane_of( w->v->ng, connection->lane ), connection->wi ) > 0.0f;
    }
}

static void bend_connections( RfConnectionWork* w )
{
    solve( w );
    test_visibility( w );
    if ( w->settings->normalization == RF_KERNEL_EXACT )
        rf_repeat_trials( w );
}

static void flush( RfConnectionWork* w )
{
    if ( w->count == 0 )
        return;
    if ( w->settings->normalization == RF_KERNEL_DENSITY )
        estimate_density( w );
    else
        bend_connections( w );
    for ( int k = 0; k < w->count; ++k )
    {
        if ( w->connection[k].open )
            add( w, w->connection + k );
    }
    w->count = 0;
}

static void connection_lane( RfConnectionWork* w, RfRandomKey lane, int i )
{
    RfCandidates c;
    rf_begin_candidates( w, i, &w->settings->paths->tree, rf_note_path, &c );
    float scale = rf_find_candidates( &c, lane );
    RfAcceptance trials = rf_weigh_candidates( w, lane, scale, i, &c );
    for ( int k = 0; k < c.kept; ++k )
    {
        RfConnection* connection = w->connection + w->count;
        *connection = ( RfConnection ){ .lane = i, .path = w->settings->paths->path + c.path[k] };
        connection->scale = rf_accept( &trials, &c, k, &connection->key );
        connection->offered = trials.trials * rf_offered( &trials, &c, k ) / w->settings->paths->share;
        w->count += connection->scale > 0.0f;
        if ( w->count == RF_CHAIN_BLOCK )
            flush( w );
    }
}

void rf_connection_vertices( const RfLightPathConnector* connector, RfWavefront* keys, const RfRayLanes* rays,
                             const RfVertexLanes* v, int vertex )
{
    RfConnectionLanes* out = connector->out;
    RfConnectionWork w; // its arrays are large: they stay as they are
    w.settings = connector;
    w.keys = keys;
    w.rays = rays;
    w.vertex = vertex;
    w.v = v;
    w.out = out;
    w.count = w.vpl_count = 0;
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
        connection_lane( &w, lane, i );
        rf_connect_vpls( &w, lane, i );
    }
    flush( &w );
    rf_flush_vpls( &w );
    for ( int i = 0; i < count; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            out->one[c][i] *= w.chosen[i];
    }
    keys->path_rays += out->rays;
    out->all_rays += out->rays;
}

// Connections as light samples.
static void sample( const RfConnector* connector, RfWavefront* keys, const RfRayLanes* rays, const RfVertexLanes* v, int vertex,
                    RfLightLanes* out, float* area )
{
    const RfLightPathConnector* kernel = (const RfLightPathConnector*)(const void*)connector;
    const RfConnectionLanes* connections = kernel->out;
    int count = rf_record_count( v );
    rf_connection_vertices( kernel, keys, area == NULL ? rays : NULL, v, vertex );
    float scale = RF_DELTA_PDF * (float)kernel->path->light_samples;
    for ( int i = 0; i < v->count; ++i )
    {
        bool found = i < count && connections->found[i] > 0;
        for ( int c = 0; c < 3; ++c )
        {
            out->wi[c][i] = found ? connections->wi[c][i] : v->n[c][i];
            out->radiance_cos[c][i] = found ? connections->one[c][i] * scale : 0.0f;
        }
        out->pdf_solid_angle[i] = found ? RF_DELTA_PDF : 1.0f;
    }
    for ( int i = 0; i < v->count && area != NULL; ++i )
        area[i] = i < count && connections->found[i] > 0 ? connections->area[i] : INFINITY;
}

RfLightPathConnector rf_make_connector( const RfLightPaths* paths, RfKernelNormalization normalization,
                                        const RfPathSettings* path, RfConnectionLanes* lanes )
{
    RfConnector connector = { sample, paths->vpl_connections, paths->connected, lanes->trail, rf_weigh_chance };
    return ( RfLightPathConnector ){ connector, path, paths, normalization, lanes };
}
