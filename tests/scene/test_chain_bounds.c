// The boxes around mirrors and glass: no ray that meets one of those misses its box, and most others miss all.
#include "base/random.h"
#include "scene/mirrors.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/test.h"
#include "trace/trace.h"

#define RAYS 1024
#define ROUNDS 64

typedef struct Rays
{
    float o[3][RAYS], d[3][RAYS];
} Rays;

// From all over a cube of half-width 2, in all directions; some along an axis.
static void draw_rays( uint64_t round, float scale, RfVec3 shift, Rays* rays )
{
    for ( uint32_t i = 0; i < RAYS; ++i )
    {
        RfRandomKey key = rf_pixel_key( round, i );
        float at[3] = { shift.x, shift.y, shift.z }, u[6];
        for ( uint32_t k = 0; k < 6; ++k )
            u[k] = 2.0f * rf_random( key, k ) - 1.0f;
        RfVec3 d = i % 16 == 0 ? rf_vec3( 0, i % 32 == 0 ? 1 : -1, 0 ) : rf_normalize( rf_vec3( u[3], u[4], u[5] + 1e-3f ) );
        for ( int c = 0; c < 3; ++c )
            rays->o[c][i] = scale * 2.0f * u[c] + at[c];
        rays->d[0][i] = d.x;
        rays->d[1][i] = d.y;
        rays->d[2][i] = d.z;
    }
}

// Two balls of glass and a mirror, all apart, among matte things.
static RfScene make_things( void )
{
    SceneBuilder b = { 0 };
    uint32_t wall = add_material( &b, make_lambert( 0.8f, 0.8f, 0.8f ) ),
             glass = add_material( &b, make_glass( 1.5f, 0.0f, false ) ),
             pane = add_material( &b, make_glass( 1.5f, 0.0f, true ) );
    add_sphere( &b, glass, rf_vec3( -1.2f, -1, 0 ), 0.3f, 16 );
    add_sphere( &b, glass, rf_vec3( 1.4f, 1.2f, -1 ), 0.2f, 16 );
    add_quad( &b, glass, rf_vec3( -1, 0.5f, 1.5f ), rf_vec3( -0.5f, 0.5f, 1.5f ), rf_vec3( -0.5f, 1, 1.5f ),
              rf_vec3( -1, 1, 1.5f ) );
    add_sphere( &b, wall, rf_vec3( 0, 0, 0 ), 0.4f, 16 );
    add_quad( &b, pane, rf_vec3( -2, -2, 1.9f ), rf_vec3( 2, -2, 1.9f ), rf_vec3( 2, 2, 1.9f ), rf_vec3( -2, 2, 1.9f ) );
    return finish_scene( &b );
}

static void check_things( float scale, RfVec3 shift )
{
    static Rays rays;
    float meets[RAYS], u[RAYS], v[RAYS];
    uint32_t triangle[RAYS];
    int found = 0, met = 0, missed = 0;
    AUTO_SCENE scene = make_things();
    move_scene( &scene, scale, shift );
    AUTO_TRACER tracer = make_tracer( &scene );
    const RfChainBounds* bounds = rf_tracer_chain_bounds( tracer );
    const float *o[3] = { rays.o[0], rays.o[1], rays.o[2] }, *d[3] = { rays.d[0], rays.d[1], rays.d[2] };
    assert_in_range( bounds->count, 3, RF_MAX_CHAIN_BOUNDS );
    for ( uint64_t round = 0; round < ROUNDS; ++round )
    {
        draw_rays( round, scale, shift, &rays );
        rf_meet_chain_bounds( bounds, RAYS, o, d, meets );
        rf_trace_nearest( tracer, RAYS, o, d, false, triangle, u, v );
        for ( int i = 0; i < RAYS; ++i )
        {
            const RfMaterial* m = triangle[i] == RF_MISS ? NULL : scene.materials + scene.triangles.material[triangle[i]];
            bool hit = m != NULL && m->kind == RF_BSDF_GLASS && !m->thin;
            found += hit;
            met += meets[i] > 0.0f;
            missed += hit && !( meets[i] > 0.0f );
        }
    }
    printf( "of %d rays %d meet mirrors and glass, %d their boxes\n", RAYS * ROUNDS, found, met );
    assert_true( found > 1000 );
    assert_int_equal( missed, 0 );
    assert_true( met < 4 * found );
}

TEST( test_no_ray_is_lost )
{
    check_things( 1.0f, rf_vec3( 0, 0, 0 ) );
    check_things( 1e-3f, rf_vec3( 0, 0, 0 ) );
    check_things( 1e4f, rf_vec3( 0, 0, 0 ) );
    check_things( 1.0f, rf_vec3( 500, -300, 200 ) );
}

TEST( test_without_mirrors_and_glass_there_are_none )
{
    AUTO_SCENE scene = make_room( ROOM_GGX );
    AUTO_TRACER tracer = make_tracer( &scene );
    assert_int_equal( rf_tracer_chain_bounds( tracer )->count, 0 );
}
