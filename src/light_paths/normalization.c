// Connections as light samples of the path tracer, and the light of connections divided by the probability of finding them: by
// repeated trials, unbiased (src/reuse/estimators.md, section 16), or by one of the biased ways.
#include "light_paths/connections_internal.h"

#define MOST_REPEATS 4096 // reached by rounding errors alone
#define SAME 0.05f        // solutions closer than this, in reaches, are one

// Draws a start uniformly within reach of the solution. False: nothing is emitted there.
static bool draw_start( const RfConnectionWork* w, const RfConnection* connection, uint32_t trial, RfEmission* e )
{
    const RfTracer* tracer = w->settings->path->tracer;
    *e = connection->chain.start;
    float chord;
    RfVec3 across = rf_sample_reach( &connection->reach, e->direction, rf_random( connection->key, 2 * trial ),
                                     rf_random( connection->key, 2 * trial + 1 ), &chord );
    if ( e->infinite )
    {
        e->position = rf_madd( e->position, across, chord );
        return true;
    }
    float versine = 0.5f * chord * chord, sine = sqrtf( versine * ( 2.0f - versine ) );
    RfVec3 d = rf_normalize( rf_madd( rf_scale( across, sine ), e->direction, 1.0f - versine ) );
    return rf_emit_towards( rf_tracer_lights( tracer ), d, e );
}

// One more trial of the pending connections: a light path near the solution, from which a manifold walk may converge to the
// same. Returns how many are still pending.
static int try_again( RfConnectionWork* w, uint32_t trial, bool* pending )
{
    const RfTracer* tracer = w->settings->path->tracer;
    RfTriangleRecord place;
    const RfLightPaths* paths = w->settings->paths;
    RfChain* chains[RF_CHAIN_BLOCK];
    bool active[RF_CHAIN_BLOCK];
    RfLanding land;
    for ( int k = 0; k < w->count; ++k )
    {
        const RfConnection* connection = w->connection + k;
        RfManifoldWalk* walk = w->walk + k;
        chains[k] = &walk->at;
        walk->active = active[k] = pending[k] && draw_start( w, connection, trial, &walk->at.start );
        walk->at.events = connection->chain.events;
        walk->at.plate = connection->chain.plate;
        walk->at.facet[0] = connection->chain.facet[0];
        walk->at.facet[1] = connection->chain.facet[1];
        walk->at.length = connection->chain.length;
        w->out->trials += pending[k];
    }
    rf_walk_chains( tracer, RF_CHAIN_COPY, NULL, active, w->count, chains, &land, &w->out->rays );
    for ( int k = 0; k < w->count; ++k )
    {
        RfManifoldWalk* walk = w->walk + k;
        if ( !active[k] || walk->at.length == 0 )
        {
            walk->active = false;
            continue;
        }
        const RfConnection* connection = w->connection + k;
        RfFootprint footprint = rf_find_footprint( paths, rf_tracer_lights( tracer ), &walk->at, rf_steer_pdf( paths, &walk->at ),
                                                   land.p[k], rf_triangle_record( tracer, land.triangle[k], &place )->ng );
        RfFootprintBox box = { land.p[k], footprint.half };
        walk->most = rf_scaled_reach( &footprint.reach, RF_STEP_MARGIN );
        // light paths that panes leave nothing of are not stored
        bool shines = rf_luminance( rf_mul( walk->at.start.radiance, walk->at.weight ) ) > 0.0f;
        walk->active = shines && footprint.reach.along > 0.0f && rf_box_holds( &box, rf_start_of( w->v, connection->lane ) );
    }
    rf_walk_manifold( tracer, w->count, w->walk, &w->out->rays );
    int left = 0;
    for ( int k = 0; k < w->count; ++k )
    {
        if ( !pending[k] )
            continue;
        RfConnection* connection = w->connection + k;
        const RfManifoldWalk* walk = w->walk + k;
        bool same = walk->met && rf_reach_to( &connection->reach, &connection->chain.start, &walk->at.start ) <= SAME * SAME;
        pending[k] = !same;
        connection->repeats += pending[k] ? 1.0f : 0.0f;
        left += pending[k];
    }
    return left;
}

void rf_repeat_trials( RfConnectionWork* w )
{
    bool pending[RF_CHAIN_BLOCK];
    int left = 0;
    for ( int k = 0; k < w->count; ++k )
        left += pending[k] = w->connection[k].open;
    for ( uint32_t trial = 0; left > 0 && trial < MOST_REPEATS; ++trial )
        left = try_again( w, trial, pending );
}

// Draws a direction uniformly from the cone. False: it is rejected, as VPLs scatter by the cosine.
static bool draw_from_cone( const RfVplConnection* connection, uint32_t trial, RfVec3* d )
{
    float versine = connection->versine * rf_random( connection->key, 3 * trial );
    float phi = 2.0f * RF_PI * rf_random( connection->key, 3 * trial + 1 ), sine = sqrtf( versine * ( 2.0f - versine ) );
    RfVec3 t, b;
    rf_basis( connection->d, &t, &b );
    RfVec3 across = rf_add( rf_scale( t, cosf( phi ) ), rf_scale( b, sinf( phi ) ) );
    *d = rf_normalize( rf_madd( rf_scale( across, sine ), connection->d, 1.0f - versine ) );
    return rf_random( connection->key, 3 * trial + 2 ) * connection->most < rf_dot( *d, connection->path->vpl.ng );
}

// Whether a particle that lands here covers the vertex.
static bool covers( const RfConnectionWork* w, const RfVplConnection* connection, uint32_t triangle, RfVec3 p )
{
    const RfTracer* tracer = w->settings->path->tracer;
    RfTriangleRecord place;
    const RfTriangleRecord* t = rf_triangle_record( tracer, triangle, &place );
    if ( rf_tracer_scene( tracer )->materials[t->material].kind >= RF_BSDF_FIRST_SPECULAR )
        return false;
    float radius = rf_scattered_radius( w->settings->paths, connection->path, p, t->ng );
    RfVec3 apart = rf_sub( rf_start_of( w->v, connection->lane ), p );
    return rf_dot( apart, apart ) <= radius * radius;
}

// One more trial of the pending connections to VPLs. Returns how many are still pending.
static int try_vpls_again( RfConnectionWork* w, uint32_t trial, bool* pending )
{
    const RfTracer* tracer = w->settings->path->tracer;
    float o[3][RF_CHAIN_BLOCK], d[3][RF_CHAIN_BLOCK], u[RF_CHAIN_BLOCK], v[RF_CHAIN_BLOCK];
    uint32_t hit[RF_CHAIN_BLOCK];
    int index[RF_CHAIN_BLOCK], count = 0, left = 0;
    for ( int k = 0; k < w->vpl_count; ++k )
    {
        RfVplConnection* connection = w->vpl_connection + k;
        RfVec3 way, from = rf_vpl_start( connection->path );
        left += pending[k];
        w->out->trials += pending[k];
        connection->repeats += pending[k] ? 1.0f : 0.0f;
        if ( !pending[k] || !draw_from_cone( connection, trial, &way ) )
            continue;
        rf_put_ray( o, d, count, from, way );
        index[count++] = k;
    }
    const float *from[3] = { o[0], o[1], o[2] }, *way[3] = { d[0], d[1], d[2] };
    RfPassedPanes panes;
    rf_trace_light( tracer, count, from, way, hit, u, v, &panes );
    w->out->rays += (uint64_t)count;
    for ( int k = 0; k < count; ++k )
    {
        if ( hit[k] == RF_MISS )
            continue;
        RfTriangleRecord place;
        const RfTriangleRecord* t = rf_triangle_record( tracer, hit[k], &place );
        RfVec3 p = rf_hit_point( t, u[k], v[k], RF_GET3( o, k ), RF_GET3( d, k ) ).p;
        bool found = covers( w, w->vpl_connection + index[k], hit[k], p );
        pending[index[k]] = !found;
        left -= found;
    }
    return left;
}

// Trials of connections to VPLs, until a particle from within the cone covers the vertex.
static void repeat_vpl_trials( RfConnectionWork* w )
{
    bool pending[RF_CHAIN_BLOCK];
    int left = 0;
    for ( int k = 0; k < w->vpl_count; ++k )
        left += pending[k] = w->vpl_connection[k].open;
    for ( uint32_t trial = 0; left > 0 && trial < MOST_REPEATS; ++trial )
        left = try_vpls_again( w, trial, pending );
}

static void divide_vpls( RfConnectionWork* w )
{
    repeat_vpl_trials( w );
    for ( int k = 0; k < w->vpl_count; ++k )
    {
        RfVplConnection* connection = w->vpl_connection + k;
        connection->inverse_probability = connection->repeats / ( 2.0f * connection->versine * connection->most );
    }
}

static void solve( RfConnectionWork* w )
{
    rf_walk_to_vertices( w );
    rf_repeat_trials( w );
}

static const RfNormalization s_exact = {
    .weighted = true,
    .note_path = rf_note_path,
    .solve = solve,
    .divide_vpls = divide_vpls,
    .weigh_chance = rf_weigh_chance,
};

// ---- Research: biased, for comparison (--kernel-normalization). `disc` takes all of the reach to lead to the vertex, without trials.
// `density` connects nothing: it estimates the photon density by balls (GK 7)

static void divide_by_cones( RfConnectionWork* w )
{
    for ( int k = 0; k < w->vpl_count; ++k )
    {
        RfVplConnection* connection = w->vpl_connection + k;
        connection->inverse_probability = 1.0f / ( connection->cone * connection->cosine );
    }
}

static const RfNormalization s_disc = {
    .weighted = true,
    .note_path = rf_note_path,
    .solve = rf_walk_to_vertices,
    .divide_vpls = divide_by_cones,
    .weigh_chance = rf_weigh_chance,
};

static void note_in_ball( void* user, uint32_t number )
{
    RfCandidates* c = user;
    const RfLightPath* path = c->settings->paths->path + number;
    RfVec3 apart = rf_sub( c->y, path->at.p );
    bool within = c->spent + path->length + 2 <= c->settings->path->max_depth &&
                  !( rf_dot( apart, apart ) > path->at.half.x * path->at.half.x );
    if ( within && path->light > 0.0f )
        rf_keep_candidate( c, number, path->light );
}

// Paths that land near the camera vertex count as landing there.
static void estimate_density( RfConnectionWork* w )
{
    for ( int k = 0; k < w->count; ++k )
    {
        RfConnection* connection = w->connection + k;
        connection->wi = rf_scale( connection->path->end.d, -1.0f );
        connection->light = rf_scale( connection->path->flux, connection->scale );
        connection->reach = ( RfReach ){ { 1.0f, 0.0f }, connection->path->at.half.x, connection->path->at.half.x };
        connection->repeats = 1.0f;
        connection->chance = 0.0f;
        connection->area = INFINITY;
        connection->open = rf_dot( rf_lane_of( w->v->n, connection->lane ), connection->wi ) > 0.0f &&
                           rf_dot( rf_lane_of( w->v->ng, connection->lane ), connection->wi ) > 0.0f;
    }
}

// Scattered rays leave all of this light to the light paths.
static float leave_all( const RfConnector* connector, const RfTrail* trail, int length, uint32_t triangle, RfVec3 point )
{
    (void)connector, (void)trail, (void)length, (void)triangle, (void)point;
    return 0.0f;
}

static const RfNormalization s_density = {
    .balls = true,
    .note_path = note_in_ball,
    .solve = estimate_density,
    .weigh_chance = leave_all,
};

// ---- The connector

const RfNormalization* rf_find_normalization( RfKernelNormalization normalization )
{
    static const RfNormalization* const rows[] = {
        [RF_KERNEL_EXACT] = &s_exact,
        [RF_KERNEL_DISC] = &s_disc,
        [RF_KERNEL_DENSITY] = &s_density,
    };
    return rows[normalization];
}

static void sample( const RfConnector* connector, RfWavefront* keys, const RfRayLanes* rays, const RfVertexLanes* v, int vertex,
                    RfLightLanes* out, float* area )
{
    const RfLightPathConnector* self = (const RfLightPathConnector*)(const void*)connector;
    const RfConnectionLanes* connections = self->out;
    int count = rf_record_count( v );
    rf_connect_vertices( self, keys, area == NULL ? rays : NULL, v, vertex );
    float scale = RF_DELTA_PDF * (float)self->path->light_samples;
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
    const RfNormalization* row = rf_find_normalization( normalization );
    return ( RfLightPathConnector ){
        .connector = { .sample = sample,
                       .vpl_connections = paths->vpl_connections,
                       .emission = paths->emission,
                       .trails = lanes->trail,
                       .weigh_chance = row->weigh_chance },
        .path = path,
        .paths = paths,
        .normalization = row,
        .out = lanes,
    };
}
