// Light of the second kind, which a caustic throws on other surfaces, without bias: a room whose lamp shines on a mirror alone,
// against paths that hit it by chance. Welch tests over 16 seeds.
#include "support/chain_checks.h"
#include "support/scene_builder.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// The room has a floor that parents and eyes see in all ways: matte and glossy, flat and curved, and corners, where links to
// parents have small weights.
static RfScene make_indirect_room( void )
{
    SceneBuilder b = { 0 };
    uint32_t wall = add_material( &b, make_lambert( 0.7f, 0.6f, 0.5f ) );
    uint32_t matte = add_material( &b, make_plastic( 0.6f, 0.8f ) ), glossy = add_material( &b, make_plastic( 0.5f, 0.3f ) );
    uint32_t mirror = add_material( &b, make_mirror( 0.9f ) ), lamp = add_material( &b, make_light( 4.0f, false ) );
    add_box( &b, wall, rf_vec3( -2, 0, -2 ), rf_vec3( 2, 3, 2 ), true );
    add_box( &b, matte, rf_vec3( -1.5f, 0, -1.3f ), rf_vec3( -0.7f, 0.9f, -0.5f ), false );
    add_box( &b, glossy, rf_vec3( 1.0f, 0, -0.6f ), rf_vec3( 1.5f, 0.5f, -0.1f ), false );
    add_sphere( &b, matte, rf_vec3( 0.7f, 0.4f, -1.1f ), 0.4f, 12 );
    // facing up, under a mirror that faces down
    add_quad( &b, lamp, rf_vec3( -1.2f, 2.3f, 1.2f ), rf_vec3( 1.2f, 2.3f, 1.2f ), rf_vec3( 1.2f, 2.3f, -1.2f ),
              rf_vec3( -1.2f, 2.3f, -1.2f ) );
    add_quad( &b, mirror, rf_vec3( -2.0f, 2.95f, -2.0f ), rf_vec3( 2.0f, 2.95f, -2.0f ), rf_vec3( 2.0f, 2.95f, 2.0f ),
              rf_vec3( -2.0f, 2.95f, 2.0f ) );
    // and one that the eyes see
    add_quad( &b, mirror, rf_vec3( -0.3f, 0.8f, -1.95f ), rf_vec3( 0.3f, 0.8f, -1.95f ), rf_vec3( 0.3f, 1.6f, -1.95f ),
              rf_vec3( -0.3f, 1.6f, -1.95f ) );
    return finish_scene( &b );
}

static void test_light_of_the_second_kind( void** state )
{
    (void)state;
    const ChainSetting settings[2] = { { .group = 0, .tile = "1", .spp = 6, .linked = true },
                                       { .group = 3, .tile = "3x3", .spp = 7, .linked = true } };
    ChainCase c = chain_case( "light of the second kind", 5 );
    c.settings = settings;
    c.setting_count = 2;
    check_chains( &c, make_indirect_room() );
}

int main( void )
{
    const struct CMUnitTest tests[] = { cmocka_unit_test( test_light_of_the_second_kind ) };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
