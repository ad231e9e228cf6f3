// The exact normalisation of connections: the mean number of repeated trials is one over the probability that a light path drawn
// around a solution walks to it, as counted by drawing many.
#include "light_paths/connections_internal.h"
#include "render/estimator.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/test.h"

#define TRIALS 8192
#define LINKS 8 // solutions looked at
#define PARTICLES 400000
#define MOST_SIGMAS 4.5

// A camera vertex a part of the footprint away from where a light path lands, and the connection from that path to it, solved.
static bool solve_connection( const LightPathSet* s, const RfLightPath* path, float part, RfVertexLanes* v,
                              RfConnection* connection )
{
    RfVec3 t, b, n = rf_scale( path->end.d, -1.0f );
    rf_basis( n, &t, &b );
    RfVec3 y = rf_madd( path->at.p, t, part * rf_minf( path->at.half.x, rf_minf( path->at.half.y, path->at.half.z ) ) );
    v->p[0][0] = y.x;
    v->p[1][0] = y.y;
    v->p[2][0] = y.z;
    v->ng[0][0] = n.x;
    v->ng[1][0] = n.y;
    v->ng[2][0] = n.z;
    RfManifoldWalk walk = { .y = y, .n = n, .most = rf_scaled_reach( &path->reach, RF_STEP_MARGIN ), .active = true };
    uint64_t rays = 0;
    walk.at.start = path->start;
    walk.at.events = path->events;
    walk.at.length = path->length;
    walk.at.end = path->end;
    rf_walk_manifold( s->tracer, 1, &walk, &rays );
    if ( !walk.met )
        return false;
    *connection = ( RfConnection ){ .path = path, .chain = walk.at, .open = true };
    connection->reach =
        rf_find_footprint( s->paths, rf_tracer_lights( s->tracer ), &walk.at, rf_steer_pdf( s->paths, &walk.at ), y, n ).reach;
    return rf_reach_to( &connection->reach, &walk.at.start, &path->start ) <= 1.0f;
}

// Repeats the trial of one connection as 64 connections with random numbers of their own, `first` and those that follow.
static void count_repeats( RfConnectionWork* work, const RfConnection* connection, uint32_t first, double* sum )
{
    for ( int k = 0; k < RF_CHAIN_BLOCK; ++k )
    {
        work->connection[k] = *connection;
        work->connection[k].repeats = 1.0f;
        work->walk[k].y = rf_start_of( work->v, 0 );
        work->walk[k].n = rf_lane_of( work->v->ng, 0 );
        work->connection[k].key = rf_pixel_key( 77, first + (uint32_t)k );
    }
    work->count = RF_CHAIN_BLOCK;
    rf_repeat_trials( work );
    for ( int k = 0; k < RF_CHAIN_BLOCK; ++k )
        *sum += (double)work->connection[k].repeats;
}

// The share of starts, drawn evenly around the solution, from which it is found.
static double count_found( const LightPathSet* s, const RfConnection* connection, const RfManifoldWalk* target )
{
    const RfTriangleRecord* triangles = rf_tracer_records( s->tracer )->records;
    int found = 0;
    uint64_t rays = 0;
    for ( uint32_t k = 0; k < TRIALS; ++k )
    {
        RfRandomKey key = rf_pixel_key( 99, k );
        RfManifoldWalk walk = *target;
        RfChain* chain = &walk.at;
        RfVec3 t, b;
        // evenly over the chords, by rejection from the disc around the ellipse
        float r = rf_maxf( connection->reach.along, connection->reach.across ), x, z, chord2;
        uint32_t d = 0;
        do
        {
            x = r * ( 2.0f * rf_random( key, d ) - 1.0f );
            z = r * ( 2.0f * rf_random( key, d + 1 ) - 1.0f );
            d += 2;
        } while ( rf_reach_squared( &connection->reach, x, z ) > 1.0f );
        chord2 = x * x + z * z;
        rf_basis( connection->chain.start.direction, &t, &b );
        RfVec3 across = rf_scale( rf_add( rf_scale( t, x ), rf_scale( b, z ) ), sqrtf( 1.0f - 0.25f * chord2 ) );
        RfVec3 towards = rf_normalize( rf_madd( across, connection->chain.start.direction, 1.0f - 0.5f * chord2 ) );
        *chain = connection->chain;
        bool active = rf_emit_towards( rf_tracer_lights( s->tracer ), towards, &chain->start );
        RfLanding land;
        rf_walk_chains( s->tracer, RF_CHAIN_COPY, NULL, &active, 1, &chain, &land, &rays );
        if ( !active || chain->length == 0 )
            continue;
        RfFootprint f = rf_find_footprint( s->paths, rf_tracer_lights( s->tracer ), chain, rf_steer_pdf( s->paths, chain ),
                                           land.p[0], triangles[land.triangle[0]].ng );
        RfVec3 apart = rf_sub( walk.y, land.p[0] );
        walk.active = fabsf( apart.x ) <= f.half.x && fabsf( apart.y ) <= f.half.y && fabsf( apart.z ) <= f.half.z;
        walk.most = rf_scaled_reach( &f.reach, RF_STEP_MARGIN );
        rf_walk_manifold( s->tracer, 1, &walk, &rays );
        found += walk.met && rf_reach_to( &connection->reach, &connection->chain.start, &chain->start ) <= 0.05f * 0.05f;
    }
    return (double)found / TRIALS;
}

TEST( test_repeated_trials_are_one_over_the_probability )
{
    static RfVertexLanes v;
    static RfConnectionLanes out;
    static RfConnectionWork work;
    AUTO_SCENE scene = make_mirror_room( GLASS_BALL );
    static LightPathSet s;
    draw_light_path_set( &scene, 64, 64, &s );
    RfLightPathConnector connector = rf_make_connector( s.paths, RF_KERNEL_EXACT, &s.path, &out );
    work = ( RfConnectionWork ){ .settings = &connector, .v = &v, .out = &out };
    int connections = 0, uncertain = 0;
    for ( uint32_t i = 0; i < s.paths->count && connections < LINKS; ++i )
    {
        RfConnection connection;
        if ( !solve_connection( &s, s.paths->path + i, 0.1f * (float)( i % 7 ), &v, &connection ) )
            continue;
        double sum = 0.0;
        for ( uint32_t k = 0; k < TRIALS; k += RF_CHAIN_BLOCK )
            count_repeats( &work, &connection, k, &sum );
        RfManifoldWalk target = { .y = rf_vec3( v.p[0][0], v.p[1][0], v.p[2][0] ),
                                  .n = rf_vec3( v.ng[0][0], v.ng[1][0], v.ng[2][0] ) };
        double p = count_found( &s, &connection, &target ), mean = sum / TRIALS;
        // the mean of a geometric distribution has the variance ( 1 − p ) / p²; few trials may know no failure
        double fails = fmax( 1.0 - p, 4.0 / TRIALS ), sigma = sqrt( fails * ( 1.0 + 1.0 / p ) / ( p * p * TRIALS ) );
        assert_true( p > 0.0 );
        printf( "mean of the trials %.4f, 1/p %.4f\n", mean, 1.0 / p );
        assert_true( fabs( mean - 1.0 / p ) <= MOST_SIGMAS * sigma );
        connections += 1;
        uncertain += p < 0.95;
    }
    printf( "%d connections, %d of them found in less than 95 %% of the trials\n", connections, uncertain );
    assert_int_equal( connections, LINKS );
    assert_true( uncertain > 0 );
    free_light_path_set( &s );
}

// A camera vertex where a particle landed, facing its VPL, and the connection between them.
static bool find_vpl_connection( const LightPathSet* s, const RfScatteredPath* particle, RfConnectionWork* work,
                                 RfVertexLanes* v )
{
    const RfScene* scene = rf_tracer_scene( s->tracer );
    RfVec3 n = rf_normalize( rf_sub( s->paths->path[particle->path].at.p, particle->at.p ) );
    float p[3] = { particle->at.p.x, particle->at.p.y, particle->at.p.z }, ng[3] = { n.x, n.y, n.z };
    for ( int c = 0; c < 3; ++c )
    {
        v->p[c][0] = p[c];
        v->ng[c][0] = v->n[c][0] = ng[c];
    }
    v->offset[0] = 1e-4f;
    for ( uint32_t m = 0; m < scene->material_count; ++m )
    {
        if ( scene->materials[m].kind == RF_BSDF_LAMBERT )
            v->material[0] = (int32_t)m;
    }
    work->vertex = 1;
    work->vpl_count = 0;
    rf_connect_vpls( work, rf_pixel_key( 5, particle->path ), 0 );
    return work->vpl_count > 0;
}

// The mean number of trials until a particle covers the vertex.
static double count_vpl_trials( RfConnectionWork* work, const RfVplConnection* connection )
{
    double sum = 0.0;
    for ( uint32_t first = 0; first < TRIALS; first += RF_CHAIN_BLOCK )
    {
        work->vpl_count = RF_CHAIN_BLOCK;
        for ( uint32_t k = 0; k < RF_CHAIN_BLOCK; ++k )
        {
            work->vpl_connection[k] = *connection;
            work->vpl_connection[k].key = rf_pixel_key( 78, first + k );
        }
        rf_flush_vpls( work );
        for ( int k = 0; k < RF_CHAIN_BLOCK; ++k )
            sum += (double)work->vpl_connection[k].repeats;
    }
    return sum / TRIALS;
}

// The share of all particles of a VPL that cover the vertex.
static double count_covering( const LightPathSet* s, const RfVplConnection* connection, RfVec3 y )
{
    const RfVpl* vpl = &connection->path->vpl;
    const RfTriangleRecord* triangles = rf_tracer_records( s->tracer )->records;
    RfVec3 o = rf_vpl_start( connection->path ), t, b;
    const float* from[3] = { &o.x, &o.y, &o.z };
    rf_basis( vpl->ng, &t, &b );
    int found = 0;
    for ( uint32_t k = 0; k < PARTICLES; ++k )
    {
        RfRandomKey key = rf_pixel_key( 101, k );
        float u = rf_random( key, 0 ), phi = 2.0f * RF_PI * rf_random( key, 1 );
        RfVec3 d = rf_add( rf_scale( t, sqrtf( u ) * cosf( phi ) ), rf_scale( b, sqrtf( u ) * sinf( phi ) ) );
        d = rf_normalize( rf_madd( d, vpl->ng, sqrtf( 1.0f - u ) ) );
        RfVec3 across = rf_cross( d, connection->d );
        if ( rf_dot( d, connection->d ) <= 0.0f || rf_dot( across, across ) > connection->cone )
            continue;
        const float* way[3] = { &d.x, &d.y, &d.z };
        uint32_t hit;
        float bu, bv;
        rf_trace_nearest( s->tracer, 1, from, way, false, &hit, &bu, &bv );
        if ( hit == RF_MISS || rf_tracer_scene( s->tracer )->materials[triangles[hit].material].kind == RF_BSDF_GLASS )
            continue;
        RfVec3 p = rf_hit_point( triangles + hit, bu, bv, o, d ).p;
        found += rf_length( rf_sub( p, y ) ) <= rf_scattered_radius( s->paths, connection->path, p, triangles[hit].ng );
    }
    return (double)found / PARTICLES;
}

TEST( test_trials_of_vpls_are_one_over_the_probability )
{
    static RfVertexLanes v;
    static RfConnectionLanes out;
    static RfConnectionWork work;
    static RfWavefront keys;
    AUTO_SCENE scene = make_mirror_room( GLASS_BALL );
    static LightPathSet s;
    draw_light_path_set( &scene, 64, 64, &s );
    RfLightPathConnector connector = rf_make_connector( s.paths, RF_KERNEL_EXACT, &s.path, &out );
    work = ( RfConnectionWork ){ .settings = &connector, .v = &v, .out = &out, .keys = &keys };
    int connections = 0, uncertain = 0;
    assert_true( s.paths->scattered_count > 100 );
    for ( uint32_t i = 0; i < s.paths->scattered_count && connections < LINKS; i += 13 )
    {
        if ( !find_vpl_connection( &s, s.paths->scattered + i, &work, &v ) )
            continue;
        RfVplConnection connection = work.vpl_connection[0];
        double mean = count_vpl_trials( &work, &connection ), drawn = 2.0 * (double)connection.versine * (double)connection.most;
        if ( !work.vpl_connection[0].open ) // occluded
            continue;
        double n = count_covering( &s, &connection, rf_start_of( &v, 0 ) ), p = 1.0 / mean;
        double sigma = sqrt( ( 1.0 - p + 4.0 / TRIALS ) / TRIALS + 1.0 / ( n * PARTICLES ) );
        printf( "one over the trials %.5f, share of the particles %.5f\n", drawn * p, n );
        assert_true( n > 0.0 );
        assert_true( fabs( drawn * p / n - 1.0 ) <= MOST_SIGMAS * sigma );
        connections += 1;
        uncertain += p < 0.8;
    }
    printf( "%d connections, %d of them found in less than 80 %% of the trials\n", connections, uncertain );
    assert_int_equal( connections, LINKS );
    assert_true( uncertain > 0 );
    free_light_path_set( &s );
}
