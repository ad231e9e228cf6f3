// Curved mirrors, glass, panes and lobes that are nearly specular are rendered without bias by
// tiles, by groups of frames and by both, against independent references over 16 seeds. Without REFRAME_LONG a room is left
// out whose parts are in others, such as panes, which are rendered under a film.
#include "support/test.h"
#include "support/unbiased.h"
#include "support/rooms.h"
#include "support/statistics.h"

#include <stdlib.h>

static void check_room( const char* what, MirrorRoom kind, int max_depth )
{
    ChainCase c = chain_case( what, max_depth );
    check_chains( &c, make_mirror_room( kind ) );
}

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

static void check_room_if_long( const char* what, MirrorRoom kind, int max_depth )
{
    if ( is_long() )
        check_room( what, kind, max_depth );
}

TEST( test_a_mirror_ball_is_unbiased ) { check_room( "mirror ball", MIRROR_BALL, 5 ); }

TEST( test_balls_of_glass_are_unbiased )
{
    check_room( "glass ball", GLASS_BALL, 6 );
    check_room( "absorbing ball", ABSORBING_BALL, 6 );
    check_room_if_long( "glass ball, depth 4", GLASS_BALL, 4 );
}

TEST( test_extra_samples_are_unbiased )
{
    ChainCase c = chain_case( "glass ball", 6 );
    c.settings = g_adaptive;
    c.setting_count = 1;
    check_chains( &c, make_mirror_room( GLASS_BALL ) );
}

TEST( test_slabs_of_glass_are_unbiased )
{
    check_room( "glass slab", GLASS_SLAB, 6 );
    check_room_if_long( "absorbing slab", ABSORBING_SLAB, 6 );
    check_room_if_long( "glass slab, depth 4", GLASS_SLAB, 4 );
    check_room_if_long( "layered slab", LAYERED_SLAB, 6 );
}

TEST( test_light_that_comes_by_chains_is_unbiased )
{
    check_room( "lamp in glass", LAMP_IN_GLASS, 7 );
    check_room_if_long( "lamp in glass, depth 4", LAMP_IN_GLASS, 4 );
    ChainCase c = chain_case( "slabs under a sky", 7 );
    low_eyes( c.eyes, CHAIN_EYES, CHAIN_WIDTH, CHAIN_HEIGHT );
    check_chains( &c, make_glass_in_the_open() );
}

TEST( test_rough_glass_is_unbiased )
{
    check_room( "rough slab", ROUGH_SLAB, 6 );
    ChainCase c = chain_case( "frosted sheets", 5 );
    RfScene room = make_mirror_room( FROSTED_SHEETS );
    add_punctual( &room, make_point_light( rf_vec3( 0.2f, 1.2f, -0.6f ), 2.0f ) ); // whose light does not come through
    check_chains( &c, room );
}

TEST( test_eyes_within_glass_are_unbiased ) { check_room( "tank", GLASS_TANK, 6 ); }

TEST( test_panes_are_unbiased )
{
    check_room_if_long( "panes in a row", PANES_IN_A_ROW, 7 );
    check_room_if_long( "panes, depth 4", PANES_IN_A_ROW, 4 );
    check_room( "mirror behind a pane", MIRROR_BEHIND_PANE, 6 );
}

// Where panes and mirrors show it again and again.
TEST( test_lamps_in_bulbs_are_unbiased )
{
    check_room( "bulb", MIRROR_BEHIND_BULB, 6 );
    check_room_if_long( "bulb, depth 3", MIRROR_BEHIND_BULB, 3 );
    check_room_if_long( "bulb, depth 2", MIRROR_BEHIND_BULB, 2 );
}

TEST( test_sharp_lobes_are_unbiased )
{
    check_room_if_long( "metal, roughness 0.05", SHARP_METAL, 4 );
    check_room_if_long( "smooth plastic", SMOOTH_PLASTIC, 4 ); // in test_estimator_adaptive, too
    check_room_if_long( "plastic, roughness 0.05", SHARP_PLASTIC, 4 );
    check_room( "plastic, depth 2", SHARP_PLASTIC, 2 ); // the lobe ends without a hit
    check_room( "clear coat", CLEAR_COAT, 4 );
}

// All glass of a room with an inside disperses colours; thin walls and mirrors have a film.
static RfScene make_spectral_room( MirrorRoom kind, float dispersion, bool film )
{
    RfScene scene = make_mirror_room( kind );
    for ( uint32_t i = 0; i < scene.material_count; ++i )
    {
        RfMaterial* m = scene.materials + i;
        if ( m->kind != RF_BSDF_GLASS )
            continue;
        m->kind = RF_BSDF_SPECTRAL;
        m->dispersion = m->ior > 0.0f && !m->thin ? dispersion : 0.0f;
        m->film = film ? 0.8f : 0.0f;
        m->film_ior = 1.7f;
        m->film_thickness = 300.0f;
    }
    return scene;
}

static void check_dispersion( const char* what, MirrorRoom kind, int max_depth )
{
    ChainCase c = chain_case( what, max_depth );
    check_chains( &c, make_spectral_room( kind, 8.0f, false ) );
}

// Each channel is that of glass of its own index.
TEST( test_dispersion_is_unbiased )
{
    check_dispersion( "rough slab, dispersion", ROUGH_SLAB, 6 );
    check_dispersion( "layered slab, dispersion", LAYERED_SLAB, 6 );
    if ( is_long() )
    {
        check_dispersion( "absorbing ball, dispersion", ABSORBING_BALL, 6 );
        check_dispersion( "lamp in glass, dispersion", LAMP_IN_GLASS, 7 );
    }
    ChainCase c = chain_case( "glass ball, dispersion", 6 );
    c.settings = g_connected;
    check_chains( &c, make_spectral_room( GLASS_BALL, 8.0f, false ) );
}

TEST( test_films_over_glass_are_unbiased )
{
    ChainCase panes = chain_case( "panes under a film", 7 ), mirrors = chain_case( "mirror under a film, behind a pane", 6 );
    check_chains( &panes, make_spectral_room( PANES_IN_A_ROW, 0.0f, true ) );
    check_chains( &mirrors, make_spectral_room( MIRROR_BEHIND_PANE, 0.0f, true ) );
    ChainCase slab = chain_case( "rough slab under a film", 6 );
    if ( is_long() )
        check_chains( &slab, make_spectral_room( ROUGH_SLAB, 0.0f, true ) );
}

STATISTICAL_TESTS
