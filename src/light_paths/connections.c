// Connects camera vertices to light paths by manifold walks, and to VPLs: finds candidates by footprints, accepts some of them,
// solves, tests visibility, and adds their light. Connections and scattered rays that find the same light are weighted by the
// balance heuristic.
#include "light_paths/connections_internal.h"

#include "scene/textured.h"

#include <math.h>
#include <string.h>

#define EVENLY 0.25f      // of the trial connections are uniform over the candidates: derivatives are unreliable near foci
#define LEAST_SHARE 0.02f // of trial connections, however bright the direct light
#define SCATTERED 0.5f    // albedo that is assumed beyond the first vertex

// Trial connections of one lane: each candidate is accepted in proportion to its expected contribution.
typedef struct Acceptance
{
    RfRandomKey lane;
    float scale;  // from find_candidates
    float trials; // connections wanted
    float sum;    // predicted for all candidates
} Acceptance;

// Begins the search for a lane's candidates.
static void begin_candidates( const RfConnectionWork* w, int i, const RfFootprintTree* tree, RfFootprintFound* note,
                              RfCandidates* c )
{
    const RfVertexLanes* v = w->v;
    c->settings = w->settings;
    c->tree = tree;
    c->note = note;
    c->y = rf_start_of( v, i );
    c->ng = rf_lane_of( v->ng, i );
    c->n = rf_lane_of( v->n, i );
    c->spent = w->vertex - 1 + ( w->settings->path->spent != NULL ? w->settings->path->spent[v->slot[i]] : 0 );
    c->vertex = w->vertex;
    c->count = c->kept = 0;
    c->next = c->stride = 0.0;
    c->thinned = false;
}

void rf_keep_candidate( RfCandidates* c, uint32_t number, float light )
{
    int k = c->count++;
    if ( c->thinned && (double)k < c->next )
        return;
    if ( c->kept == RF_MOST_CANDIDATES )
        return;
    c->path[c->kept] = number;
    c->light[c->kept++] = light;
    c->next += c->stride;
}

void rf_note_path( void* user, uint32_t number )
{
    RfCandidates* c = user;
    const RfLightPath* path = c->settings->paths->path + number;
    float step[2], miss, spread;
    if ( c->spent + path->length + 2 > c->settings->path->max_depth )
        return;
    if ( !rf_newton_step( &path->end, c->y, c->ng, step, &miss, &spread ) ||
         !( rf_reach_squared( &path->reach, step[0], step[1] ) <= RF_STEP_MARGIN * RF_STEP_MARGIN ) )
        return;
    float light =
        path->light / spread * rf_connection_weight( c->settings->paths, path->chance, -rf_dot( c->n, path->end.d ), c->vertex );
    if ( light > 0.0f )
        rf_keep_candidate( c, number, light );
}

// Finds candidates, every k-th of them if there are too many. Returns the reciprocal of the probability of being kept.
static float find_candidates( RfCandidates* c, RfRandomKey key )
{
    rf_find_footprints( c->tree, c->y, c->note, c );
    if ( c->count <= RF_MOST_CANDIDATES )
        return 1.0f;
    c->stride = (double)c->count / RF_MOST_CANDIDATES;
    c->next = c->stride * (double)rf_random( key, 0 );
    c->count = c->kept = 0;
    c->thinned = true;
    rf_find_footprints( c->tree, c->y, c->note, c );
    return (float)c->stride;
}

// Divides the trial connections among the candidates.
static Acceptance weigh_candidates( const RfConnectionWork* w, RfRandomKey lane, float scale, int i, const RfCandidates* c )
{
    Acceptance a = { .lane = lane, .scale = scale };
    for ( int k = 0; k < c->kept; ++k )
        a.sum += c->light[k];
    float promised = a.sum * scale * RF_INV_PI / (float)w->settings->paths->emitted;
    float share = promised / rf_maxf( promised + w->keys->lit[i], 1e-30f );
    a.trials = rf_trial_connections( w->settings->paths->share, w->vertex ) * rf_maxf( share, LEAST_SHARE );
    return a;
}

// A candidate's fraction of the trial connections.
static float offered_part( const Acceptance* a, const RfCandidates* c, int k )
{
    return ( 1.0f - EVENLY ) * c->light[k] / a->sum + EVENLY / (float)c->kept;
}

// The key of a candidate, and the reciprocal of the probability of accepting it; 0: it was not accepted.
static float accept( const Acceptance* a, const RfCandidates* c, int k, RfRandomKey* key )
{
    *key = rf_pixel_key( (uint64_t)a->lane.a << 32 | a->lane.b, c->path[k] );
    float accepted = rf_minf( a->trials * offered_part( a, c, k ), 1.0f );
    return rf_random( *key, RF_DIMENSION_ACCEPT ) < accepted ? a->scale / accepted : 0.0f;
}

// Adds the light of a connection to its lane.
static void add_light( RfConnectionWork* w, int i, RfRandomKey key, RfVec3 wi_of, RfVec3 light, float area )
{
    RfConnectionLanes* out = w->out;
    float add[3] = { light.x, light.y, light.z }, weight = rf_luminance( light );
    w->chosen[i] += weight;
    bool choose = rf_random( key, RF_DIMENSION_CHOOSE ) * w->chosen[i] < weight || out->found[i] == 0;
    for ( int c = 0; c < 3; ++c )
        out->light[c][i] += add[c];
    out->found[i] += 1;
    if ( !choose )
        return;
    float wi[3] = { wi_of.x, wi_of.y, wi_of.z };
    out->area[i] = area;
    for ( int c = 0; c < 3; ++c )
    {
        out->wi[c][i] = wi[c];
        out->one[c][i] = add[c] / weight;
    }
}

// The direction from a VPL to a point, and the cone of the particles that cover it. False: the VPL does not light it.
static bool find_way( const RfLightPaths* paths, const RfLightPath* path, RfVec3 y, RfVplConnection* connection,
                      float* distance2 )
{
    RfVec3 way = rf_sub( y, rf_vpl_start( path ) );
    *distance2 = rf_dot( way, way );
    connection->d = rf_scale( way, 1.0f / sqrtf( rf_maxf( *distance2, 1e-20f ) ) );
    connection->cosine = rf_dot( connection->d, path->vpl.ng );
    if ( !( connection->cosine > 0.0f && *distance2 > 1e-20f ) )
        return false;
    connection->cone = rf_vpl_cone( paths, connection->cosine );
    return true;
}

// The weight of a connection to a VPL.
static float weight_of( const RfCandidates* c, const RfLightPath* path )
{
    const RfLightPaths* paths = c->settings->paths;
    return path->vpl.share *
           ( 1.0f - rf_own_weight( paths->vpl_connections, path->vpl.area, c->y, c->n, path->at.p, path->vpl.ng ) );
}

// Notes a particle, if its VPL may be connected.
static void note_particle( void* user, uint32_t number )
{
    RfCandidates* c = user;
    const RfLightPaths* paths = c->settings->paths;
    const RfScatteredPath* particle = paths->scattered + number;
    const RfLightPath* path = paths->path + particle->path;
    RfVplConnection connection;
    float distance2;
    RfVec3 apart = rf_sub( c->y, particle->at.p );
    if ( rf_dot( apart, apart ) > particle->at.half.x * particle->at.half.x )
        return;
    if ( c->spent + path->length + 3 > c->settings->path->max_depth || !find_way( paths, path, c->y, &connection, &distance2 ) )
        return;
    float cos_n = -rf_dot( connection.d, c->n ), cos_g = -rf_dot( connection.d, c->ng );
    RfVec3 landed = rf_normalize( rf_sub( particle->at.p, rf_vpl_start( path ) ) ), across = rf_cross( landed, connection.d );
    if ( !( cos_n > 0.0f && cos_g > 0.0f && rf_dot( landed, connection.d ) > 0.0f &&
            rf_dot( across, across ) <= connection.cone ) )
        return;
    float covers = connection.cosine * connection.cone * (float)RF_SCATTERED_PER_PATH;
    float light = rf_luminance( path->flux ) * connection.cosine * cos_n * weight_of( c, path ) / ( distance2 * covers );
    if ( light > 0.0f && light < INFINITY )
        rf_keep_candidate( c, number, light );
}

// The radiant intensity of a VPL towards a direction, by its scattering model.
static RfVec3 scattered_light( const RfTracer* tracer, const RfLightPath* path, RfVec3 d )
{
    const RfVpl* vpl = &path->vpl;
    const RfScene* scene = rf_tracer_scene( tracer );
    const RfMaterial* m = scene->materials + rf_triangle_material( tracer, vpl->triangle );
    RfMaterial here = *m;
    if ( m->textured != NULL )
        rf_material_at( scene, m, vpl->triangle, vpl->u, vpl->v, &here );
    RfVec3 wi = rf_scale( path->end.d, -1.0f ), f;
    RfBsdfLanes lanes = { .n = { &vpl->n.x, &vpl->n.y, &vpl->n.z } };
    for ( RfBsdfParams left = rf_bsdf_model( m->kind )->params & ~RF_PARAMS_OF_HIT; left != 0; left &= left - 1 )
    {
        RfBsdfParam p = rf_first_param( left );
        lanes.param[p] = rf_material_param( &here, p );
    }
    const float *wo_in[3] = { &d.x, &d.y, &d.z }, *wi_in[3] = { &wi.x, &wi.y, &wi.z };
    float* out[3] = { &f.x, &f.y, &f.z };
    rf_bsdf_evaluate( m->kind, 1, &lanes, wo_in, wi_in, out, NULL );
    // flux is per geometric area; the model takes irradiance by the shading normal
    float cosines = rf_dot( vpl->n, wi ) / rf_maxf( rf_dot( vpl->ng, wi ), 1e-6f );
    return rf_scale( rf_mul( path->flux, f ), cosines * vpl->falloff );
}

// The last segments of connections: blocked, or by way of panes, as segment number `k`.
static void see_chain( RfConnection* connection, float visible, const RfPassedPanes* panes, int k )
{
    connection->open = visible > 0.0f;
    if ( !connection->open || !panes->any )
        return;
    connection->light = rf_mul( connection->light, rf_passed_colour( panes, k ) );
    rf_pass_panes( panes, k, &connection->chain );
}

static void see_vpl( RfVplConnection* connection, float visible, const RfPassedPanes* panes, int k )
{
    connection->open = visible > 0.0f;
    if ( connection->open && panes->any )
        connection->light = rf_mul( connection->light, rf_passed_colour( panes, k ) );
}

// Closes the connections that are blocked, by shadow rays from the vertices to the ends of the chains, or from the VPLs to the
// vertices.
static void test_visibility( RfConnectionWork* w, bool of_vpls )
{
    float o[3][RF_CHAIN_BLOCK], d[3][RF_CHAIN_BLOCK], visible[RF_CHAIN_BLOCK];
    int tested[RF_CHAIN_BLOCK], count = 0;
    RfPassedPanes panes;
    for ( int k = 0; k < ( of_vpls ? w->vpl_count : w->count ); ++k )
    {
        RfConnection* chain = w->connection + k;
        RfVplConnection* vpl = w->vpl_connection + k;
        if ( !( of_vpls ? vpl->open : chain->open ) )
            continue;
        RfVec3 vertex = rf_start_of( w->v, of_vpls ? vpl->lane : chain->lane );
        RfVec3 from = of_vpls ? rf_vpl_start( vpl->path ) : vertex, to = of_vpls ? vertex : chain->chain.end.o;
        rf_put_ray( o, d, count, from, rf_sub( to, from ) );
        tested[count++] = k;
    }
    const float *from[3] = { o[0], o[1], o[2] }, *way[3] = { d[0], d[1], d[2] };
    rf_trace_light_segments( w->settings->path->tracer, count, from, way, visible, &panes );
    w->out->rays += (uint64_t)count;
    for ( int k = 0; k < count; ++k )
    {
        if ( of_vpls )
            see_vpl( w->vpl_connection + tested[k], visible[k], &panes, k );
        else
            see_chain( w->connection + tested[k], visible[k], &panes, k );
    }
}

void rf_flush_vpls( RfConnectionWork* w )
{
    if ( w->vpl_count == 0 )
        return;
    test_visibility( w, true );
    w->settings->normalization->divide_vpls( w );
    float particles = (float)w->settings->paths->emitted * (float)RF_SCATTERED_PER_PATH;
    for ( int k = 0; k < w->vpl_count; ++k )
    {
        const RfVplConnection* connection = w->vpl_connection + k;
        RfVec3 light = rf_scale( connection->light, connection->inverse_probability / particles );
        float most = rf_max_component( light );
        if ( connection->open && most > 0.0f && most < INFINITY )
            add_light( w, connection->lane, connection->key, rf_scale( connection->d, -1.0f ), light, INFINITY );
    }
    w->vpl_count = 0;
}

// The light and the cone of a connection that was accepted.
static bool prepare_vpl( const RfConnectionWork* w, const RfCandidates* c, RfVplConnection* connection )
{
    float distance2;
    if ( !find_way( w->settings->paths, connection->path, c->y, connection, &distance2 ) )
        return false;
    float cos_cone = sqrtf( rf_maxf( 1.0f - connection->cone, 0.0f ) );
    connection->versine = connection->cone / ( 1.0f + cos_cone );
    float sine = sqrtf( rf_maxf( 1.0f - connection->cosine * connection->cosine, 0.0f ) );
    connection->most = connection->cosine >= cos_cone ? 1.0f : connection->cosine * cos_cone + sine * sqrtf( connection->cone );
    float scale =
        -rf_dot( connection->d, c->n ) * connection->cosine / distance2 * weight_of( c, connection->path ) * connection->scale;
    connection->light = rf_scale( scattered_light( w->settings->path->tracer, connection->path, connection->d ), scale );
    connection->open = rf_max_component( connection->light ) > 0.0f;
    connection->repeats = 0.0f;
    return connection->open;
}

void rf_connect_vpls( RfConnectionWork* w, RfRandomKey lane, int i )
{
    const RfLightPaths* paths = w->settings->paths;
    if ( w->settings->normalization->divide_vpls == NULL || !rf_is_matte_lane( w->settings->path, w->v, i ) )
        return;
    RfCandidates c;
    begin_candidates( w, i, &paths->scattered_tree, note_particle, &c );
    lane.a ^= 0x70617265u; // apart from those of light paths
    Acceptance trials = weigh_candidates( w, lane, find_candidates( &c, lane ), i, &c );
    for ( int k = 0; k < c.kept; ++k )
    {
        RfVplConnection* connection = w->vpl_connection + w->vpl_count;
        *connection = ( RfVplConnection ){ .lane = i, .path = paths->path + paths->scattered[c.path[k]].path };
        connection->scale = accept( &trials, &c, k, &connection->key );
        w->vpl_count += connection->scale > 0.0f && prepare_vpl( w, &c, connection );
        if ( w->vpl_count == RF_CHAIN_BLOCK )
            rf_flush_vpls( w );
    }
}

// Rebuilds a trail as a chain from a point of the emitter. False: light cannot take it.
static bool follow_back( const RfTracer* tracer, const RfTrail* trail, int length, uint32_t emitter, RfVec3 point,
                         RfChain* chain )
{
    RfTriangleRecord place;
    const RfLights* lights = rf_tracer_lights( tracer );
    uint32_t number = rf_triangle_light( tracer, emitter );
    const RfLight* light = lights->light + number;
    RfVec3 at[RF_MAX_CHAIN + 2]; // from the emitter on
    at[0] = point;
    at[length + 1] = trail->start;
    for ( int k = 0; k < length; ++k )
    {
        const RfTriangleRecord* t = rf_triangle_record( tracer, trail->triangle[k], &place );
        at[length - k] = rf_add( t->p0, rf_add( rf_scale( t->e1, trail->u[k] ), rf_scale( t->e2, trail->v[k] ) ) );
    }
    RfEmission e = { .position = point, .range = INFINITY, .light = number, .offset = light->offset };
    e.direction = rf_normalize( rf_sub( at[1], at[0] ) );
    e.normal = rf_dot( light->normal, e.direction ) < 0.0f ? rf_scale( light->normal, -1.0f ) : light->normal;
    rf_find_emission_pdf( lights, &e );
    *chain = ( RfChain ){ .start = e };
    rf_begin_chain( chain );
    for ( int k = 0; k < length; ++k )
    {
        const RfTriangleRecord* t = rf_triangle_record( tracer, trail->triangle[length - 1 - k], &place );
        RfVec3 in = rf_sub( at[k], at[k + 1] ), out = rf_sub( at[k + 2], at[k + 1] );
        bool refracted = ( rf_dot( in, t->ng ) < 0.0f ) != ( rf_dot( out, t->ng ) < 0.0f );
        chain->events |= (uint32_t)refracted << k;
        if ( !rf_step_chain( tracer, trail->triangle[length - 1 - k], trail->u[length - 1 - k], trail->v[length - 1 - k],
                             RF_CHAIN_COPY, ( RfRandomKey ){ 0, 0 }, chain ) )
            return false;
        chain->end.d = rf_normalize( out ); // where it went, not where rounding would lead
    }
    return true;
}

float rf_weigh_chance( const RfConnector* connector, const RfTrail* trail, int length, uint32_t triangle, RfVec3 point )
{
    const RfLightPathConnector* self = (const RfLightPathConnector*)(const void*)connector;
    const RfTracer* tracer = self->path->tracer;
    const RfLightPaths* paths = self->paths;
    RfChain chain;
    if ( paths->light_count == 0 || !follow_back( tracer, trail, length, triangle, point, &chain ) )
        return 1.0f;
    chain.start.pdf_light /= (float)paths->light_cumulative[paths->light_count - 1];
    float pdf = rf_steer_pdf( paths, &chain );
    RfReach reach = rf_find_footprint( paths, rf_tracer_lights( tracer ), &chain, pdf, trail->start, trail->ng ).reach;
    float area = rf_chance_area( paths, &chain, rf_reach_area( &reach ), pdf, trail->start );
    return 1.0f - rf_connection_weight( paths, area, -rf_dot( trail->n, chain.end.d ), trail->vertex );
}

const float rf_connection_shares[RF_CONNECTION_SHARES] = { 0.0f, 0.03f, 0.06f, 0.125f, 0.25f, 0.5f, 1.0f };

// Throughput from a vertex to the first one.
static float throughput_of( const RfConnectionWork* w, int i )
{
    if ( w->vertex == 1 )
        return 1.0f;
    int r = w->v->ray[i];
    return SCATTERED * ( w->rays == NULL ? 1.0f : rf_luminance( RF_GET3( w->rays->throughput, r ) ) );
}

// Connections of this kind found with a share of all light paths (rf_find_footprint).
static float find_count( const RfLightPaths* paths, const RfConnection* connection, float share )
{
    return rf_maxf( rf_minf( paths->connections, share * connection->most ),
                    rf_minf( paths->rare_connections, share * connection->rare_most ) );
}

// Counts the scattered rays that would find this light by themselves.
static void count_chance( RfConnectionLanes* out, double light, double found, double through )
{
    if ( !( found * through > 0.0 && found < INFINITY ) )
        return;
    int octave = (int)floor( log2( found * through ) ) - RF_FIRST_OCTAVE;
    octave = octave < 0 ? 0 : octave >= RF_CHANCE_OCTAVES ? RF_CHANCE_OCTAVES - 1 : octave;
    out->chance[octave].rays += light / found;
    out->chance[octave].square += through * through * light * found;
}

// Adds the second moment that this light would have with each share of light paths.
static void measure_connection( const RfConnectionWork* w, const RfConnection* connection, float light )
{
    const RfChain* chain = &connection->chain;
    float cosine = rf_dot( rf_lane_of( w->v->n, connection->lane ), connection->wi ), chance = RF_INV_PI * cosine,
          through = throughput_of( w, connection->lane );
    // the contribution of a scattered ray that finds the same light
    float found =
        rf_luminance( rf_mul( chain->start.radiance, chain->weight ) ) * cosine / ( chance * chain->probability * chain->passes );
    const RfLightPaths* paths = w->settings->paths;
    count_chance( w->out, (double)light, (double)found, (double)through );
    float found_now = find_count( paths, connection, paths->share );
    for ( int k = 0; k < RF_CONNECTION_SHARES; ++k )
    {
        float share = rf_connection_shares[k], tried = rf_tried( w->settings->paths, share, w->vertex );
        float fewer = share > 0.0f ? found_now / find_count( paths, connection, share ) : 0.0f;
        float weight = share == 0.0f               ? 0.0f
                       : connection->chance > 0.0f ? rf_balance_weight( tried, connection->chance * fewer * chance )
                                                   : 1.0f;
        float accepted = rf_minf( w->settings->paths->share * connection->offered, 1.0f ),
              then = rf_minf( share * connection->offered, 1.0f );
        float by_connections = share > 0.0f ? weight * weight * light * light * fewer * accepted / then : 0.0f;
        float by_chance = ( 1.0f - weight ) * ( 1.0f - weight ) * light * found;
        w->out->moment[k] += (double)( through * through ) * (double)( by_connections + by_chance );
    }
}

// The contribution of a solved connection before normalisation; 0 if it is blocked by geometry.
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
    float falloff = rf_emission_falloff( e, chain->vertex[0].p, chain->way + last );
    float scale = cos_x * cos_light * falloff * connection->scale * connection->path->weight / ( spread * fixed_pdf );
    RfVec3 absorbed = rf_vec3( expf( -chain->end_absorption.x * last ), expf( -chain->end_absorption.y * last ),
                               expf( -chain->end_absorption.z * last ) );
    RfVec3 light = rf_scale( rf_mul( rf_mul( e->radiance, chain->weight ), absorbed ), scale );
    float sum = light.x + light.y + light.z;
    return sum > 0.0f && sum < INFINITY ? light : none;
}

// The area that a connection covers at a matte vertex, where light paths scatter (rf_own_weight).
static float area_of( const RfConnectionWork* w, const RfConnection* connection, const RfManifoldWalk* walk )
{
    float step[2], miss, spread;
    if ( !rf_may_scatter( &connection->chain ) || !rf_is_matte_lane( w->settings->path, w->v, connection->lane ) ||
         !rf_newton_step( &connection->chain.end, walk->y, walk->n, step, &miss, &spread ) )
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
        RfManifoldWalk* walk = w->walk + k;
        walk->at.start = connection->path->start;
        walk->at.events = connection->path->events;
        walk->at.plate = connection->path->plate;
        walk->at.facet[0] = connection->path->facet[0];
        walk->at.facet[1] = connection->path->facet[1];
        walk->at.length = connection->path->length;
        walk->at.end = connection->path->end;
        walk->y = rf_start_of( w->v, connection->lane );
        walk->n = rf_lane_of( w->v->ng, connection->lane );
        walk->most = rf_scaled_reach( &connection->path->reach, RF_STEP_MARGIN );
        walk->active = true;
    }
    rf_walk_manifold( tracer, w->count, w->walk, &w->out->rays );
    for ( int k = 0; k < w->count; ++k )
    {
        RfConnection* connection = w->connection + k;
        connection->open = w->walk[k].met;
        if ( !connection->open )
            continue;
        connection->chain = w->walk[k].at;
        RfVec3 y = w->walk[k].y;
        float pdf = rf_steer_pdf( paths, &connection->chain );
        RfFootprint footprint = rf_find_footprint( paths, rf_tracer_lights( tracer ), &connection->chain, pdf, y, w->walk[k].n );
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
        connection->area = area_of( w, connection, w->walk + k );
    }
}

// The weight of a connection at a vertex against connections of the previous vertex to the VPL there.
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
    float found = rf_reach_area( &connection->reach ) * (float)paths->emitted;
    float cosine = rf_dot( rf_lane_of( w->v->n, connection->lane ), connection->wi );
    float weight = own_weight( w, connection ) * rf_connection_weight( paths, connection->chance, cosine, w->vertex );
    if ( paths->measures )
        measure_connection( w, connection, rf_luminance( connection->light ) * connection->repeats / found );
    RfVec3 light = rf_scale( connection->light, connection->repeats * weight / found );
    if ( rf_max_component( light ) > 0.0f )
        add_light( w, connection->lane, connection->key, connection->wi, light, connection->area );
}

void rf_walk_to_vertices( RfConnectionWork* w )
{
    solve( w );
    test_visibility( w, false );
}

static void flush( RfConnectionWork* w )
{
    if ( w->count == 0 )
        return;
    w->settings->normalization->solve( w );
    for ( int k = 0; k < w->count; ++k )
    {
        if ( w->connection[k].open )
            add( w, w->connection + k );
    }
    w->count = 0;
}

static void connect_lane( RfConnectionWork* w, RfRandomKey lane, int i )
{
    RfCandidates c;
    begin_candidates( w, i, &w->settings->paths->tree, w->settings->normalization->note_path, &c );
    float scale = find_candidates( &c, lane );
    Acceptance trials = weigh_candidates( w, lane, scale, i, &c );
    for ( int k = 0; k < c.kept; ++k )
    {
        RfConnection* connection = w->connection + w->count;
        *connection = ( RfConnection ){ .lane = i, .path = w->settings->paths->path + c.path[k] };
        connection->scale = accept( &trials, &c, k, &connection->key );
        connection->offered = trials.trials * offered_part( &trials, &c, k ) / w->settings->paths->share;
        w->count += connection->scale > 0.0f;
        if ( w->count == RF_CHAIN_BLOCK )
            flush( w );
    }
}

void rf_connect_vertices( const RfLightPathConnector* connector, RfWavefront* keys, const RfRayLanes* rays,
                          const RfVertexLanes* v, int vertex )
{
    RfConnectionLanes* out = connector->out;
    RfConnectionWork w; // its large arrays are not cleared
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
        connect_lane( &w, lane, i );
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
