// Connections to VPLs: an eye vertex in the footprint of a particle is lit by the VPL that scattered it, over the probability
// that such a particle is found (src/reuse/estimators.md, E10 and section 16).
#include "light_paths/connections_internal.h"

#include "scene/textured.h"

#include <math.h>

#define MOST_REPEATS 4096 // so many are never needed but for rounding

// The way from a VPL to a point, and the cone of the particles that cover it. False: no light goes there.
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

void rf_note_particle( void* user, uint32_t number )
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

// The light that a VPL scatters towards a direction, as a model scatters it.
static RfVec3 scattered_light( const RfTracer* tracer, const RfLightPath* path, RfVec3 d )
{
    const RfVpl* vpl = &path->vpl;
    const RfScene* scene = rf_tracer_scene( tracer );
    const RfMaterial* m = scene->materials + rf_tracer_triangles( tracer )[vpl->triangle].material;
    RfMaterial here = *m;
    if ( m->textured != NULL )
        rf_material_at( scene, m, vpl->triangle, vpl->u, vpl->v, &here );
    RfVec3 wi = rf_scale( path->end.d, -1.0f ), f;
    RfBsdfLanes lanes = { .n = { &vpl->n.x, &vpl->n.y, &vpl->n.z } };
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
    {
        bool has = rf_has_param( rf_bsdf_model( m->kind )->params & ~RF_PARAMS_OF_HIT, (RfBsdfParam)p );
        lanes.param[p] = has ? rf_material_param( &here, (RfBsdfParam)p ) : NULL;
    }
    const float *wo_in[3] = { &d.x, &d.y, &d.z }, *wi_in[3] = { &wi.x, &wi.y, &wi.z };
    float* out[3] = { &f.x, &f.y, &f.z };
    rf_bsdf_evaluate( m->kind, 1, &lanes, wo_in, wi_in, out, NULL );
    // flux comes through the area, the model asks for irradiance by the shading normal
    float cosines = rf_dot( vpl->n, wi ) / rf_maxf( rf_dot( vpl->ng, wi ), 1e-6f );
    return rf_scale( rf_mul( path->flux, f ), cosines * vpl->falloff );
}

static void test_visibility( RfConnectionWork* w )
{
    float o[3][RF_CHAIN_BLOCK], d[3][RF_CHAIN_BLOCK], visible[RF_CHAIN_BLOCK];
    int index[RF_CHAIN_BLOCK], count = 0;
    for ( int k = 0; k < w->vpl_count; ++k )
    {
        const RfVplConnection* connection = w->vpl_connection + k;
        if ( !connection->open )
            continue;
        RfVec3 from = rf_vpl_start( connection->path ), way = rf_sub( rf_start_of( w->v, connection->lane ), from );
        rf_put_ray( o, d, count, from, way );
        index[count++] = k;
    }
    const float *from[3] = { o[0], o[1], o[2] }, *way[3] = { d[0], d[1], d[2] };
    rf_trace_segments( w->settings->path->tracer, count, from, way, visible );
    w->out->rays += (uint64_t)count;
    for ( int k = 0; k < count; ++k )
        w->vpl_connection[index[k]].open = visible[k] > 0.0f;
}

// Draws a direction evenly from the cone. False: a VPL that scatters by the cosine does not take it.
static bool draw_direction( const RfVplConnection* connection, uint32_t trial, RfVec3* d )
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
    const RfTriangleRecord* t = rf_tracer_triangles( tracer ) + triangle;
    if ( rf_tracer_scene( tracer )->materials[t->material].kind >= RF_BSDF_FIRST_SPECULAR )
        return false;
    float radius = rf_scattered_radius( w->settings->paths, connection->path, p, t->ng );
    RfVec3 apart = rf_sub( rf_start_of( w->v, connection->lane ), p );
    return rf_dot( apart, apart ) <= radius * radius;
}

// One more trial of the connections that are pending. Returns how many are pending still.
static int try_again( RfConnectionWork* w, uint32_t trial, bool* pending )
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
        if ( !pending[k] || !draw_direction( connection, trial, &way ) )
            continue;
        rf_put_ray( o, d, count, from, way );
        index[count++] = k;
    }
    const float *from[3] = { o[0], o[1], o[2] }, *way[3] = { d[0], d[1], d[2] };
    rf_trace_nearest( tracer, count, from, way, false, hit, u, v );
    w->out->rays += (uint64_t)count;
    for ( int k = 0; k < count; ++k )
    {
        if ( hit[k] == RF_MISS )
            continue;
        RfVec3 p = rf_hit_point( rf_tracer_triangles( tracer ) + hit[k], u[k], v[k], rf_vec3( o[0][k], o[1][k], o[2][k] ),
                                 rf_vec3( d[0][k], d[1][k], d[2][k] ) )
                       .p;
        bool found = covers( w, w->vpl_connection + index[k], hit[k], p );
        pending[index[k]] = !found;
        left -= found;
    }
    return left;
}

// The exact normalisation: counts trials until a particle from within the cone covers the vertex.
static void repeat_trials( RfConnectionWork* w )
{
    bool pending[RF_CHAIN_BLOCK];
    int left = 0;
    for ( int k = 0; k < w->vpl_count; ++k )
        left += pending[k] = w->vpl_connection[k].open;
    for ( uint32_t trial = 0; left > 0 && trial < MOST_REPEATS; ++trial )
        left = try_again( w, trial, pending );
}

// One over the probability that a particle covers the vertex.
static float inverse_probability( const RfConnectionWork* w, const RfVplConnection* connection )
{
    if ( w->settings->normalization == RF_KERNEL_EXACT )
        return connection->repeats / ( 2.0f * connection->versine * connection->most );
    return 1.0f / ( connection->cone * connection->cosine );
}

void rf_flush_vpls( RfConnectionWork* w )
{
    if ( w->vpl_count == 0 )
        return;
    test_visibility( w );
    if ( w->settings->normalization == RF_KERNEL_EXACT )
        repeat_trials( w );
    float particles = (float)w->settings->paths->emitted * (float)RF_SCATTERED_PER_PATH;
    for ( int k = 0; k < w->vpl_count; ++k )
    {
        const RfVplConnection* connection = w->vpl_connection + k;
        RfVec3 light = rf_scale( connection->light, inverse_probability( w, connection ) / particles );
        float most = rf_max_component( light );
        if ( connection->open && most > 0.0f && most < INFINITY )
            rf_add_light( w, connection->lane, connection->key, rf_scale( connection->d, -1.0f ), light, INFINITY );
    }
    w->vpl_count = 0;
}

// The light and the cone of a connection that was accepted.
static bool prepare( const RfConnectionWork* w, const RfCandidates* c, RfVplConnection* connection )
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
    if ( w->settings->normalization == RF_KERNEL_DENSITY || !rf_is_matte_lane( w->settings->path, w->v, i ) )
        return;
    RfCandidates c;
    rf_begin_candidates( w, i, &paths->scattered_tree, rf_note_particle, &c );
    lane.a ^= 0x70617265u; // apart from those of light paths
    RfAcceptance trials = rf_weigh_candidates( w, lane, rf_find_candidates( &c, lane ), i, &c );
    for ( int k = 0; k < c.kept; ++k )
    {
        RfVplConnection* connection = w->vpl_connection + w->vpl_count;
        *connection = ( RfVplConnection ){ .lane = i, .path = paths->path + paths->scattered[c.path[k]].path };
        connection->scale = rf_accept( &trials, &c, k, &connection->key );
        w->vpl_count += connection->scale > 0.0f && prepare( w, &c, connection );
        if ( w->vpl_count == RF_CHAIN_BLOCK )
            rf_flush_vpls( w );
    }
}
