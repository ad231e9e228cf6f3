// Hits, and the rays that leave them: no triangle shades itself or lets light through, whatever its size, its tilt
// and how far it reaches beyond what is looked at.
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/test.h"

#include "base/random.h"
#include "trace/trace.h"

#define RAYS 4096

typedef struct Ground
{
    float reach; // its corners are so far from its middle, over the size of the scene
    float tilt;  // of its normal, about two axes
    float scale; // m: rays start and lamps are so far from the middle
} Ground;

static float number( uint32_t dimension, int i )
{
    return rf_random( rf_pixel_key( rf_pass_key( 5, 0, 0, 0 ), (uint32_t)i ), dimension );
}

// The frame of a tilted ground: along it, and its normal.
static void ground_frame( const Ground* g, RfVec3* x, RfVec3* z, RfVec3* n )
{
    *n = rf_normalize( rf_vec3( g->tilt, 1.0f, 0.7f * g->tilt ) );
    *x = rf_normalize( rf_vec3( n->y, -n->x, 0.0f ) );
    *z = rf_vec3( x->y * n->z - x->z * n->y, x->z * n->x - x->x * n->z, x->x * n->y - x->y * n->x );
}

// The ground, and a small box at its middle, of which there are more triangles than of the ground.
static RfScene make_ground( const Ground* g )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) );
    float s = g->scale, far = s * g->reach;
    RfVec3 x, z, n;
    ground_frame( g, &x, &z, &n );
    x = rf_scale( x, far );
    z = rf_scale( z, far );
    add_quad( &b, grey, rf_sub( z, x ), rf_add( x, z ), rf_sub( x, z ), rf_scale( rf_add( x, z ), -1.0f ) );
    for ( int k = 0; k < 4; ++k )
        add_box( &b, grey, rf_vec3( 9.0f * s, 3.0f * s, (float)k * s ), rf_vec3( 9.5f * s, 3.5f * s, ( (float)k + 0.5f ) * s ),
                 false );
    return finish_scene( &b );
}

// A point near the middle: along the ground, and above it (below: negative).
static RfVec3 above( const Ground* g, int i, uint32_t dimension, float height )
{
    RfVec3 x, z, n;
    ground_frame( g, &x, &z, &n );
    float s = g->scale;
    RfVec3 p = rf_madd( rf_scale( x, s * ( number( dimension, i ) - 0.5f ) ), z, s * ( number( dimension + 1, i ) - 0.5f ) );
    return rf_madd( p, n, s * height );
}

static float segment( const RfTracer* tracer, RfVec3 from, RfVec3 to )
{
    RfVec3 way = rf_sub( to, from );
    const float* o[3] = { &from.x, &from.y, &from.z };
    const float* d[3] = { &way.x, &way.y, &way.z };
    float visible;
    rf_trace_segments( tracer, 1, o, d, &visible );
    return visible;
}

// Counts hits whose lamp, on their side, is hidden from them, and hits that see a lamp on the other side. Their
// ray offset is at most RF_OFFSET_RATIO times that of their coordinates.
static void check_ground( float reach, float tilt, float scale )
{
    Ground g = { reach, tilt, scale };
    AUTO_SCENE scene = make_ground( &g );
    AUTO_TRACER tracer = make_tracer( &scene );
    int hits = 0, hidden = 0, leaks = 0, lifted = 0;
    for ( int i = 0; i < RAYS; ++i )
    {
        RfVec3 eye = above( &g, i, 0, 0.3f ), target = above( &g, i, 2, 0.0f ), d = rf_normalize( rf_sub( target, eye ) );
        const float* o[3] = { &eye.x, &eye.y, &eye.z };
        const float* way[3] = { &d.x, &d.y, &d.z };
        uint32_t triangle;
        float u, v;
        rf_trace_nearest( tracer, 1, o, way, false, &triangle, &u, &v );
        if ( triangle == RF_MISS )
            continue;
        RfTriangleRecord place;
        const RfTriangleRecord* t = rf_triangle_record( tracer, triangle, &place );
        RfHitPoint hit = rf_hit_point( t, u, v, eye, d );
        RfVec3 out = rf_madd( hit.p, t->ng, hit.offset ), in = rf_madd( hit.p, t->ng, -hit.offset );
        hits += 1;

        lifted += hit.offset > RF_OFFSET_RATIO * 1e-6f * rf_maxf( rf_largest_coordinate( eye ), rf_largest_coordinate( hit.p ) );
        hidden += segment( tracer, out, above( &g, i, 4, 0.5f ) ) == 0.0f;
        hidden += segment( tracer, out, above( &g, i, 6, 0.01f ) ) == 0.0f;
        hidden += segment( tracer, above( &g, i, 4, 0.5f ), out ) == 0.0f;
        // The ground itself, which renders do not ask for: hits face their lights. Embree misses a tilted one from
        // so near.
        leaks += tilt < 1e-3f && segment( tracer, in, above( &g, i, 4, 0.5f ) ) > 0.0f;
        leaks += tilt < 1e-3f && segment( tracer, above( &g, i, 4, -0.5f ), out ) > 0.0f;
        leaks += segment( tracer, above( &g, i, 4, 0.5f ), above( &g, i, 6, -0.5f ) ) > 0.0f;
    }
    printf( "reach %g tilt %g scale %g: %d hits, %d hide their lamp, %d leak, %d lifted too far\n", (double)reach, (double)tilt,
            (double)scale, hits, hidden, leaks, lifted );
    assert_int_equal( hits, RAYS );
    assert_int_equal( hidden, 0 );
    assert_int_equal( leaks, 0 );
    assert_int_equal( lifted, 0 );
}

TEST( test_no_ground_hides_its_lamps_or_leaks )
{
    const float tilts[] = { 0.0f, 1e-7f, 0.3f, 20.0f }, scales[] = { 1e-9f, 1e-6f, 1.0f, 1e6f };
    for ( int t = 0; t < 4; ++t )
    {
        for ( int s = 0; s < 4; ++s )
        {
            check_ground( 1e4f, tilts[t], scales[s] );
            check_ground( 1e5f, tilts[t], scales[s] );
        }
    }
}

// A closed box around a lamp, seen from outside, at several scales and places.
static void check_box( float scale, float far )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) ), light = add_material( &b, make_light( 1e6f, true ) );
    RfVec3 at = rf_vec3( far * scale, 0, 0.3f * far * scale ), half = rf_vec3( scale, scale, scale );
    add_box( &b, grey, rf_sub( at, half ), rf_add( at, half ), true );
    add_box( &b, light, rf_madd( at, half, -0.5f ), rf_madd( at, half, 0.5f ), false );
    float reach = 1e4f * scale;
    // below the box: where two surfaces touch, the rounding of coordinates decides
    add_quad( &b, grey, rf_vec3( -reach, -1.5f * scale, reach ), rf_vec3( reach, -1.5f * scale, reach ),
              rf_vec3( reach, -1.5f * scale, -reach ), rf_vec3( -reach, -1.5f * scale, -reach ) );
    AUTO_SCENE scene = finish_scene( &b );
    RfVec3 from = rf_madd( at, rf_vec3( 2.0f, 2.5f, 3.5f ), scale );
    RfEye eye = rf_make_eye( from, rf_sub( at, from ), rf_vec3( 0, 1, 0 ), 0.8, 48, 32 );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfRenderSettings settings = plain_settings();
    settings.spp = 16;
    AUTO_BY( free_rendered ) Rendered r = render_all( tracer, &eye, 1, &settings );
    int lit = 0;
    for ( size_t i = 0; i < 3 * r.pixels; ++i )
        lit += r.rgb[i] != 0.0f;
    printf( "box of %g m at %g: %d values are not black\n", (double)scale, (double)( far * scale ), lit );
    assert_int_equal( lit, 0 );
}

TEST( test_no_light_leaves_a_closed_box )
{
    const float scales[] = { 1e-9f, 1e-6f, 1e-3f, 1.0f, 1e3f, 1e6f };
    for ( int k = 0; k < 6; ++k )
    {
        check_box( scales[k], 0.0f );
        check_box( scales[k], 1000.0f );
    }
}

// A lamp that is so bright and near that its radiance, with the factor of a delta, would not be a float.
static double mean_under_lamp( float scale, float intensity )
{
    AUTO_SCENE scene = make_room( ROOM_GGX );
    for ( uint32_t i = 0; i < 3 * scene.triangles.vertex_count; ++i )
        scene.triangles.positions[i] *= scale;
    scene.bounds_min = rf_scale( scene.bounds_min, scale );
    scene.bounds_max = rf_scale( scene.bounds_max, scale );
    for ( uint32_t m = 0; m < scene.material_count; ++m )
        scene.materials[m].emission = rf_vec3( 0, 0, 0 );
    scene.punctuals = malloc( sizeof *scene.punctuals );
    scene.punctual_count = 1;
    scene.punctuals[0] = make_point_light( rf_vec3( 0.5f * scale, 2.5f * scale, 0.3f * scale ), intensity );
    RfEye eye;
    orbit_eyes( &eye, 1, 3.0f, 24, 18 );
    eye.origin = rf_scale( eye.origin, scale );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfRenderSettings settings = plain_settings();
    settings.spp = 16;
    AUTO_BY( free_rendered ) Rendered r = render_all( tracer, &eye, 1, &settings );
    double sum = 0.0;
    for ( size_t i = 0; i < 3 * r.pixels; ++i )
        sum += (double)r.rgb[i];
    return sum;
}

TEST( test_no_lamp_is_too_bright )
{
    double plain = mean_under_lamp( 1.0f, 10.0f );
    const double scales[] = { 0x1p-10, 0x1p-20, 0x1p-30 }; // I / d² of 1e13 to 1e25
    for ( int k = 0; k < 3; ++k )
    {
        double bright = mean_under_lamp( (float)scales[k], 1e8f ) * scales[k] * scales[k] * 1e-7;
        printf( "room of %g m: %.9g of the plain radiance\n", 4.0 * scales[k], bright / plain );
        assert_true( bright > 0.99999 * plain && bright < 1.00001 * plain );
    }
}

int main( void )
{
    rf_set_float_mode();
    return run_listed_tests();
}
