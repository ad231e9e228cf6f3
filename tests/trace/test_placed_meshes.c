// Meshes that are placed against the same triangles in world space: hits, ray offsets, holes, panes, what reaches far.
#include "support/placed_scenes.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/test.h"

#include "base/random.h"
#include "scene/placement.h"
#include "trace/trace.h"

#define RAYS 20000

static float number( uint32_t dimension, int i )
{
    return rf_random( rf_pixel_key( rf_pass_key( 17, 0, 0, 0 ), (uint32_t)i ), dimension );
}

static RfVec3 direction( uint32_t dimension, int i )
{
    float z = 2.0f * number( dimension, i ) - 1.0f, phi = 2.0f * RF_PI * number( dimension + 1, i ), r = sqrtf( 1.0f - z * z );
    return rf_vec3( r * cosf( phi ), z, r * sinf( phi ) );
}

// A scene that has placements, and its twin without.
typedef struct Twins
{
    RfScene scene[2];
    RfTracer* tracer[2];
} Twins;

static Twins make_twins( RfScene placed, RfScene flat )
{
    Twins t = { { placed, flat }, { NULL, NULL } };
    flatten_scene( t.scene + 1 );
    assert_true( t.scene[0].placement_count > 0 && t.scene[1].placement_count == 0 );
    assert_int_equal( rf_triangle_count( t.scene ), rf_triangle_count( t.scene + 1 ) );
    return t;
}

// Tracers keep the addresses of scenes.
static void open_twins( Twins* t )
{
    for ( int k = 0; k < 2; ++k )
        t->tracer[k] = make_tracer( t->scene + k );
}

static void free_twins( Twins* t )
{
    for ( int k = 0; k < 2; ++k )
    {
        rf_destroy_tracer( t->tracer[k] );
        rf_destroy_scene( t->scene + k );
    }
}

typedef struct Hit
{
    uint32_t triangle;
    float u, v;
    RfHitPoint at;
    RfTriangleRecord record;
    RfVec3 n;
} Hit;

static Hit trace( const RfTracer* tracer, RfVec3 from, RfVec3 d )
{
    Hit hit = { 0 };
    const float* o[3] = { &from.x, &from.y, &from.z };
    const float* way[3] = { &d.x, &d.y, &d.z };
    rf_trace_nearest( tracer, 1, o, way, false, &hit.triangle, &hit.u, &hit.v );
    if ( hit.triangle == RF_MISS )
        return hit;
    RfTriangleRecord place;
    const RfTriangleRecord* t = rf_triangle_record( tracer, hit.triangle, &place );
    hit.record = *t;
    hit.at = rf_hit_point( t, hit.u, hit.v, from, d );
    hit.n = rf_normalize( rf_add( t->n0, rf_add( rf_scale( t->d1, hit.u ), rf_scale( t->d2, hit.v ) ) ) );
    return hit;
}

static float apart( RfVec3 a, RfVec3 b ) { return rf_length( rf_sub( a, b ) ); }

static float segment( const RfTracer* tracer, RfVec3 from, RfVec3 to )
{
    RfVec3 way = rf_sub( to, from );
    const float* o[3] = { &from.x, &from.y, &from.z };
    const float* d[3] = { &way.x, &way.y, &way.z };
    float visible;
    rf_trace_segments( tracer, 1, o, d, &visible );
    return visible;
}

// Rays within a room of 4 m find the same: where they do not, they pass an edge.
static void compare_hits( const char* name, const Twins* t, float scale )
{
    int other = 0, touching = 0, hits = 0; // surfaces that touch, or share an edge
    double most = 0.0, normals = 0.0, colours = 0.0;
    for ( int i = 0; i < RAYS; ++i )
    {
        RfVec3 from = rf_scale(
            rf_vec3( 3.6f * number( 0, i ) - 1.8f, 2.6f * number( 1, i ) + 0.2f, 3.6f * number( 2, i ) - 1.8f ), scale );
        Hit a = trace( t->tracer[0], from, direction( 3, i ) ), b = trace( t->tracer[1], from, direction( 3, i ) );
        hits += b.triangle != RF_MISS;
        if ( a.triangle != b.triangle )
        {
            bool touch = a.triangle != RF_MISS && b.triangle != RF_MISS && apart( a.at.p, b.at.p ) < 1e-4f * scale;
            other += !touch;
            touching += touch;
            continue;
        }
        if ( a.triangle == RF_MISS )
            continue;
        assert_int_equal( a.record.material, b.record.material );
        assert_int_equal( a.record.flat, b.record.flat );
        most = fmax( most, (double)( apart( a.at.p, b.at.p ) / scale ) );
        normals = fmax( normals, (double)fmaxf( apart( a.record.ng, b.record.ng ), apart( a.n, b.n ) ) );
        const RfMaterial* m = t->scene[0].materials + a.record.material;
        if ( m->textured == NULL )
            continue;
        RfMaterial here[2];
        rf_material_at( t->scene, m, a.triangle, a.u, a.v, here );
        rf_material_at( t->scene + 1, t->scene[1].materials + b.record.material, b.triangle, b.u, b.v, here + 1 );
        colours =
            fmax( colours,
                  (double)( fmaxf( apart( here[0].diffuse, here[1].diffuse ), apart( here[0].specular, here[1].specular ) ) ) );
        if ( m->textured->refs[RF_TEXTURE_NORMAL].texture >= 0 )
            normals = fmax( normals, (double)apart( rf_normal_at( t->scene, m, a.triangle, a.u, a.v, a.n, a.record.ng ),
                                                    rf_normal_at( t->scene + 1, m, b.triangle, b.u, b.v, b.n, b.record.ng ) ) );
    }
    printf( "%s: %d of %d hits differ, and %d where surfaces touch; points by %.2g, normals by %.2g, colours by %.2g\n", name,
            other, hits, touching, most, normals, colours );
    assert_true( hits > RAYS / 2 );
    assert_true( other <= RAYS / 1000 );
    assert_true( most < 2e-5 );
    assert_true( normals < 2e-3 );
    assert_true( colours < 2e-2 );
}

TEST( test_hits_are_the_same )
{
    for ( int kind = 0; kind < PLACED_KIND_COUNT; ++kind )
    {
        for ( int room = 0; room < 3; ++room )
        {
            RfScene scene[2];
            for ( int k = 0; k < 2; ++k )
            {
                scene[k] = room == 0 ? make_textured_room() : room == 1 ? make_blended_room() : make_mirror_room( GLASS_BALL );
                place_scene( scene + k, (PlacedKind)kind, 5, true );
            }
            Twins t = make_twins( scene[0], scene[1] );
            open_twins( &t );
            char name[64];
            snprintf( name, sizeof name, "kind %d, room %d", kind, room );
            compare_hits( name, &t, 1.0f );
            free_twins( &t );
        }
    }
}

// Rooms of all sizes, of meshes that are of yet another size.
TEST( test_hits_are_the_same_at_any_scale )
{
    const float scales[] = { 1e-9f, 1e-4f, 1e4f, 1e9f };
    for ( int s = 0; s < 4; ++s )
    {
        RfScene scene[2];
        for ( int k = 0; k < 2; ++k )
        {
            scene[k] = make_mirror_room( GLASS_BALL );
            move_scene( scene + k, scales[s], rf_vec3( 0, 0, 0 ) );
            place_scene( scene + k, s % 2 == 0 ? PLACED_SCALED : PLACED_STRETCHED, 5, true );
        }
        Twins t = make_twins( scene[0], scene[1] );
        open_twins( &t );
        char name[64];
        snprintf( name, sizeof name, "scale %g", (double)scales[s] );
        compare_hits( name, &t, scales[s] );
        free_twins( &t );
    }
}

// Balls that are placed far from where their mesh is: every point of them sees a lamp above it, none sees one through them.
static void check_offsets( PlacedKind kind, float far, float reach )
{
    SceneBuilder b = { 0 };
    add_sphere( &b, add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) ), rf_vec3( reach, 0.3f * reach, 0 ), 1.0f, 24 );
    AUTO_SCENE scene = finish_scene( &b );
    int mesh = take_mesh( &scene ), hits = 0, hidden = 0, leaks = 0;
    RfMat4 matrix[8];
    for ( int k = 0; k < 8; ++k )
    {
        matrix[k] = placing_matrix( kind, k );
        RfVec3 middle = rf_place_point( matrix + k, rf_vec3( reach, 0.3f * reach, 0 ) );
        const float to[3] = { far + 300.0f * (float)k, -0.5f * far, 0.2f * far }, from[3] = { middle.x, middle.y, middle.z };
        for ( int c = 0; c < 3; ++c )
            matrix[k].m[12 + c] += (double)( to[c] - from[c] );
        add_placement( &scene, mesh, matrix[k] );
    }
    assert_int_equal( rf_finish_placements( &scene, NULL ), RF_OK );
    AUTO_TRACER tracer = make_tracer( &scene );
    for ( int i = 0; i < RAYS; ++i )
    {
        const RfMat4* m = matrix + i % 8;
        RfVec3 d = direction( 0, i ), across = direction( 2, i ), middle = rf_vec3( reach, 0.3f * reach, 0 );
        RfVec3 eye = rf_place_point( m, rf_madd( middle, d, 3.0f ) );
        RfVec3 to = rf_place_point( m, rf_madd( middle, across, 0.9f * number( 4, i ) ) );
        Hit hit = trace( tracer, eye, rf_normalize( rf_sub( to, eye ) ) );
        if ( hit.triangle == RF_MISS )
            continue;
        hits += 1;
        float side = rf_dot( hit.record.ng, rf_sub( eye, hit.at.p ) ) < 0.0f ? -1.0f : 1.0f;
        RfVec3 out = rf_madd( hit.at.p, hit.record.ng, side * hit.at.offset );
        RfVec3 in = rf_madd( hit.at.p, hit.record.ng, -side * hit.at.offset );
        float size = apart( eye, hit.at.p );
        RfVec3 above = rf_madd( hit.at.p, hit.record.ng, side * size );
        RfVec3 slanted =
            rf_add( out, rf_scale( rf_normalize( rf_add( hit.record.ng, rf_scale( direction( 6, i ), 0.98f ) ) ), size ) );
        if ( side < 0.0f )
            slanted = above;
        hidden += segment( tracer, out, eye ) == 0.0f || segment( tracer, eye, out ) == 0.0f;
        hidden += segment( tracer, out, above ) == 0.0f || segment( tracer, out, slanted ) == 0.0f;
        leaks += segment( tracer, in, eye ) > 0.0f;
        assert_true( side > 0.0f ); // the front, whatever the matrix
    }
    printf( "kind %d, %g m away, mesh at %g m: %d hits, %d hide their lamp, %d leak\n", kind, (double)far, (double)reach, hits,
            hidden, leaks );
    assert_true( hits > RAYS * 9 / 10 );
    assert_int_equal( hidden, 0 );
    assert_true( leaks <= hits / 1000 ); // at edges
}

TEST( test_nothing_placed_shades_itself )
{
    for ( int kind = 0; kind < PLACED_KIND_COUNT; ++kind )
    {
        check_offsets( (PlacedKind)kind, 0.0f, 0.0f );
        check_offsets( (PlacedKind)kind, 1000.0f, 0.0f );
        check_offsets( (PlacedKind)kind, 0.0f, 300.0f );
        check_offsets( (PlacedKind)kind, 5000.0f, 100.0f );
    }
}

// A ground of kilometres, tilted, is placed; hits near its middle are as exact as those of one in world space.
TEST( test_far_ground_is_placed )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) );
    add_quad( &b, grey, rf_vec3( -1e4f, 0, 1e4f ), rf_vec3( 1e4f, 0, 1e4f ), rf_vec3( 1e4f, 0, -1e4f ),
              rf_vec3( -1e4f, 0, -1e4f ) );
    AUTO_SCENE scene = finish_scene( &b );
    int ground = take_mesh( &scene ), hits = 0, hidden = 0;
    SceneBuilder box = { 0 };
    add_material( &box, make_lambert( 0.5f, 0.5f, 0.5f ) );
    for ( int k = 0; k < 8; ++k )
        add_box( &box, 0, rf_vec3( 9, 3, (float)k ), rf_vec3( 9.5f, 3.5f, (float)k + 0.5f ), false );
    AUTO_SCENE boxes = finish_scene( &box );
    scene.triangles = boxes.triangles;
    scene.bounds_min = boxes.bounds_min;
    scene.bounds_max = boxes.bounds_max;
    boxes.triangles = ( RfTriangles ){ 0 };
    double q[4] = { sin( 0.15 ), 0.3 * sin( 0.15 ), 0, 0 }, t[3] = { 0.1, 0.2, 0.3 }, s[3] = { 2, 1, -1.5 };
    q[3] = sqrt( 1.0 - q[0] * q[0] - q[1] * q[1] );
    add_placement( &scene, ground, rf_mat4_from_trs( t, q, s ) );
    assert_int_equal( rf_finish_placements( &scene, NULL ), RF_OK );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfMat4 m = scene.placements[0].matrix;
    for ( int i = 0; i < RAYS; ++i )
    {
        RfVec3 eye = rf_place_point( &m, rf_vec3( number( 0, i ), 0.3f, number( 1, i ) ) );
        RfVec3 lamp = rf_place_point( &m, rf_vec3( number( 2, i ), 0.01f, number( 3, i ) ) );
        RfVec3 to = rf_place_point( &m, rf_vec3( number( 4, i ), 0.0f, number( 5, i ) ) );
        Hit hit = trace( tracer, eye, rf_normalize( rf_sub( to, eye ) ) );
        assert_true( hit.triangle >= scene.triangles.count && hit.triangle != RF_MISS );
        RfVec3 out = rf_madd( hit.at.p, hit.record.ng, hit.at.offset );
        hits += 1;
        hidden += segment( tracer, out, lamp ) == 0.0f || segment( tracer, lamp, out ) == 0.0f;
        // the corners, 20 km away, are rounded to 2 mm in world space
        if ( !( hit.at.offset < 2e-5f && apart( hit.at.p, to ) < 4e-3f ) )
            fail_msg( "a hit is %g m off, its offset %g m", (double)apart( hit.at.p, to ), (double)hit.at.offset );
    }
    printf( "far ground: %d hits, %d hide their lamp\n", hits, hidden );
    assert_int_equal( hidden, 0 );
}

// Where rounding in the world joins corners that are apart in the mesh's space, in which rays still meet the triangle.
TEST( test_normals_far_out )
{
    for ( int kind = 0; kind < PLACED_KIND_COUNT; ++kind )
    {
        AUTO_SCENE scene = make_textured_room();
        RfError error;
        place_scene( &scene, (PlacedKind)kind, 5, true );
        for ( int i = 0; i < scene.placement_count; ++i )
        {
            for ( int k = 12; k < 15; ++k )
                scene.placements[i].matrix.m[k] += 1e9;
        }
        assert_int_equal( rf_finish_placements( &scene, &error ), RF_OK );
        AUTO_TRACER tracer = make_tracer( &scene );
        int joined = 0;
        for ( uint32_t t = scene.triangles.count; t < rf_triangle_count( &scene ); ++t )
        {
            RfTriangleRecord place;
            const RfTriangleRecord* r = rf_triangle_record( tracer, t, &place );
            joined += rf_length( rf_cross( r->e1, r->e2 ) ) == 0.0f;
            assert_float_equal( rf_length( r->ng ), 1.0f, 1e-5f );
        }
        assert_true( joined > 0 );
    }
}

// Panes and holes weaken segments alike, and stop as many rays.
TEST( test_segments_are_the_same )
{
    for ( int kind = 0; kind < PLACED_KIND_COUNT; ++kind )
    {
        for ( int room = 0; room < 3; ++room )
        {
            RfScene scene[2];
            for ( int k = 0; k < 2; ++k )
            {
                scene[k] = room == 0   ? make_textured_room()
                           : room == 1 ? make_blended_room()
                                       : make_pane_room( PANES_AND_AREA_LIGHT );
                place_scene( scene + k, (PlacedKind)kind, 5, true );
            }
            Twins t = make_twins( scene[0], scene[1] );
            open_twins( &t );
            int other = 0, partial = 0;
            for ( int i = 0; i < RAYS; ++i )
            {
                RfVec3 from = rf_vec3( 3.6f * number( 0, i ) - 1.8f, 2.6f * number( 1, i ) + 0.2f, 3.6f * number( 2, i ) - 1.8f );
                RfVec3 way = rf_sub(
                    rf_vec3( 3.6f * number( 3, i ) - 1.8f, 2.6f * number( 4, i ) + 0.2f, 3.6f * number( 5, i ) - 1.8f ), from );
                const float *o[3] = { &from.x, &from.y, &from.z }, *d[3] = { &way.x, &way.y, &way.z };
                float visible[2], q[2], weight[2][3];
                for ( int k = 0; k < 2; ++k )
                {
                    RfPaneLanes panes = { .probability = q + k, .weight = { weight[k], weight[k] + 1, weight[k] + 2 } };
                    rf_trace_segments_past_panes( t.tracer[k], 1, o, d, visible + k, &panes );
                }
                partial += visible[1] > 0.0f && visible[1] * q[1] < 1.0f;
                bool same = fabsf( visible[0] - visible[1] ) < 1e-3f;
                if ( visible[1] > 0.0f )
                    same = same && fabsf( q[0] - q[1] ) < 2e-3f && fabsf( weight[0][0] - weight[1][0] ) < 1e-2f;
                other += !same;
            }
            printf( "kind %d, room %d: %d of %d segments differ, %d are open in part\n", kind, room, other, RAYS, partial );
            assert_true( other <= RAYS / 500 );
            assert_true( room == 0 || partial > 100 );
            free_twins( &t );
        }
    }
}

// Triangle numbers beyond those that fit are an error.
TEST( test_too_many_triangles_are_refused )
{
    SceneBuilder b = { 0 };
    add_box( &b, add_material( &b, make_lambert( 1, 1, 1 ) ), rf_vec3( 0, 0, 0 ), rf_vec3( 1, 1, 1 ), false );
    AUTO_SCENE scene = finish_scene( &b );
    int mesh = take_mesh( &scene );
    for ( int k = 0; k < 3; ++k )
        add_placement( &scene, mesh, rf_mat4_identity() );
    uint32_t count = scene.meshes[mesh].triangles.count;
    assert_int_equal( rf_finish_placements( &scene, NULL ), RF_OK );
    assert_int_equal( rf_triangle_count( &scene ), 3 * count );
    scene.meshes[mesh].triangles.count = 0x60000000u;
    RfError error;
    assert_int_equal( rf_finish_placements( &scene, &error ), RF_ERROR_UNSUPPORTED );
    assert_non_null( strstr( error.text, "more than 4294967294 triangles" ) );
    assert_null( strchr( error.text, '\n' ) );
    scene.meshes[mesh].triangles.count = count;
}
