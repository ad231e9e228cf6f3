// The balance weights of connections and of scattered rays that find the same path sum to one, each computed by its own technique:
// from the chain that a manifold walk leads a light path to, and from what rays hit that went the same way from the other end.
#include "light_paths/connections_internal.h"
#include "render/estimator.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/test.h"

#define LEAST_PATHS 100
#define CLOSE 2e-3f

// The chain that a manifold walk leads a light path to, at a point near to where it lands.
static bool walk( const RfTracer* tracer, const RfLightPath* path, RfVec3 y, RfVec3 n, RfChain* chain )
{
    RfManifoldWalk b = { .y = y, .n = n, .most = rf_scaled_reach( &path->reach, RF_STEP_MARGIN ), .active = true };
    uint64_t rays = 0;
    b.at.start = path->start;
    b.at.events = path->events;
    b.at.length = path->length;
    b.at.end = path->end;
    rf_walk_manifold( tracer, 1, &b, &rays );
    *chain = b.at;
    return b.met;
}

static uint32_t trace( const RfTracer* tracer, RfVec3 from, RfVec3 way, float* u, float* v )
{
    const float *o[3] = { &from.x, &from.y, &from.z }, *d[3] = { &way.x, &way.y, &way.z };
    uint32_t triangle;
    rf_trace_nearest( tracer, 1, o, d, false, &triangle, u, v );
    return triangle;
}

static RfVec3 hit_of( const RfTriangleRecord* t, float u, float v )
{
    return rf_add( t->p0, rf_add( rf_scale( t->e1, u ), rf_scale( t->e2, v ) ) );
}

// Goes back from a vertex along a chain. False: something is in the way.
static bool follow( const RfTracer* tracer, const RfChain* chain, RfVec3 y, RfVec3 n, int vertex, RfTrail* trail,
                    uint32_t* emitter, RfVec3* point )
{
    const RfTriangleRecord* triangles = rf_tracer_records( tracer )->records;
    RfVec3 from = y, way = rf_normalize( rf_sub( chain->vertex[chain->length - 1].p, y ) );
    *trail = ( RfTrail ){ .start = y, .n = n, .ng = n, .vertex = vertex };
    for ( int k = 0; k < chain->length; ++k )
    {
        const RfChainVertex* at = chain->vertex + chain->length - 1 - k;
        trail->triangle[k] = trace( tracer, from, way, trail->u + k, trail->v + k );
        if ( trail->triangle[k] != at->triangle )
            return false;
        way = rf_scale( k + 1 < chain->length ? at[-1].out : chain->start.direction, -1.0f );
        const RfTriangleRecord* t = triangles + at->triangle;
        from = rf_madd( hit_of( t, trail->u[k], trail->v[k] ), t->ng, rf_dot( way, t->ng ) < 0.0f ? -t->offset : t->offset );
    }
    float u, v;
    *emitter = trace( tracer, from, way, &u, &v );
    if ( *emitter == RF_MISS || triangles[*emitter].light == RF_NO_LIGHT )
        return false;
    *point = hit_of( triangles + *emitter, u, v );
    return true;
}

// Counts the paths that were looked at, and those of which both techniques have a part.
static void check_path( const RfTracer* tracer, const RfLightPathConnector* connector, const RfLightPath* path, int vertex,
                        int count[2] )
{
    const RfLightPaths* paths = connector->paths;
    RfVec3 t, b, n = rf_scale( path->end.d, -1.0f ), point;
    RfChain chain;
    RfTrail trail;
    uint32_t emitter;
    rf_basis( n, &t, &b );
    n = rf_normalize( rf_madd( n, b, 0.5f ) );
    RfVec3 y = rf_madd( path->at.p, t, 0.3f * rf_minf( path->at.half.x, rf_minf( path->at.half.y, path->at.half.z ) ) );
    if ( !walk( tracer, path, y, n, &chain ) || !follow( tracer, &chain, y, n, vertex, &trail, &emitter, &point ) )
        return;
    float pdf = rf_steer_pdf( paths, &chain );
    RfReach reach = rf_find_footprint( paths, rf_tracer_lights( tracer ), &chain, pdf, y, n ).reach;
    RfVec3 wi = rf_normalize( rf_sub( chain.vertex[chain.length - 1].p, y ) );
    float by_connection =
        rf_connection_weight( paths, rf_chance_area( paths, &chain, rf_reach_area( &reach ), pdf, y ), rf_dot( n, wi ), vertex );
    float by_ray = connector->connector.weigh_chance( &connector->connector, &trail, chain.length, emitter, point );
    assert_true( by_connection >= 0.0f && by_ray >= 0.0f );
    if ( !( fabsf( by_connection + by_ray - 1.0f ) < CLOSE ) )
        fail_msg( "weights %g and %g", (double)by_connection, (double)by_ray );
    count[0] += 1;
    count[1] += by_connection > 0.05f && by_connection < 0.95f;
}

static void check_room( MirrorRoom kind, float share )
{
    static LightPathSet set;
    static RfConnectionLanes lanes;
    AUTO_SCENE scene = make_mirror_room( kind );
    draw_light_path_set( &scene, 256, 128, &set );
    RfLightPaths* paths = set.paths;
    paths->share = share;
    RfLightPathConnector connector = rf_make_connector( paths, RF_KERNEL_EXACT, &set.path, &lanes );
    int count[2] = { 0, 0 };
    for ( uint32_t k = 0; k < paths->count; ++k )
        check_path( set.tracer, &connector, paths->path + k, 1 + (int)( k % 2 ), count );
    printf( "room %d, share %g: %d paths, %d of them divided\n", (int)kind, (double)share, count[0], count[1] );
    assert_true( count[0] >= LEAST_PATHS );
    assert_true( count[1] > 0 );
    free_light_path_set( &set );
}

TEST( test_weights_sum_to_one )
{
    static const MirrorRoom rooms[] = { GLASS_BALL, MIRROR_BALL, ABSORBING_SLAB, FACING_MIRRORS };
    for ( size_t r = 0; r < sizeof rooms / sizeof *rooms; ++r )
    {
        check_room( rooms[r], 1.0f );
        check_room( rooms[r], 0.03f );
    }
}
