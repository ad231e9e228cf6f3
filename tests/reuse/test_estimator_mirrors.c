// Rooms with flat mirrors are rendered without bias by tiles, by groups of frames and by both,
// against independent references over 16 seeds: one mirror, facing, coplanar and tessellated
// ones, at the border of the film, with eyes on both sides of the mirror's plane and in it, with
// paths cut at any vertex, with every kind of light.
#include "support/test.h"
#include "support/unbiased.h"
#include "support/rooms.h"
#include "support/statistics.h"

#include <stdio.h>

static void check_room( const char* what, MirrorRoom kind, int max_depth )
{
    ChainCase c = chain_case( what, max_depth );
    check_chains( &c, make_mirror_room( kind ) );
}

TEST( test_one_mirror_is_unbiased )
{
    ChainCase c = chain_case( "mirror", 5 );
    c.settings = g_all_reuse;
    c.setting_count = 4;
    check_chains( &c, make_mirror_room( FLAT_MIRROR ) );
}

TEST( test_mirrors_in_view_of_each_other_are_unbiased )
{
    ChainCase c = chain_case( "facing mirrors", 8 );
    c.settings = g_all_reuse;
    c.setting_count = 4;
    check_chains( &c, make_mirror_room( FACING_MIRRORS ) );
    check_room( "mirrors in a corner", CORNER_MIRRORS, 6 );
}

TEST( test_coplanar_mirrors_are_unbiased )
{
    check_room( "L-shaped mirror", L_SHAPED_MIRROR, 5 );
    check_room( "coplanar mirrors", COPLANAR_MIRRORS, 5 );
}

TEST( test_a_mirror_at_the_border_of_the_film_is_unbiased )
{
    ChainCase c = chain_case( "mirror at the border", 5 );
    sweep_eyes( c.eyes, CHAIN_EYES, CHAIN_WIDTH, CHAIN_HEIGHT );
    c.settings = g_all_reuse + 2; // groups of 3 without and with tiles
    check_chains( &c, make_mirror_room( NARROW_MIRROR ) );
}

// Before the mirror, exactly in its plane, behind it.
TEST( test_eyes_that_cross_the_plane_of_a_mirror_are_unbiased )
{
    ChainCase c = chain_case( "crossing", 5 );
    crossing_eyes( c.eyes, CHAIN_EYES, CHAIN_WIDTH, CHAIN_HEIGHT );
    c.every_frame = true;
    c.settings = g_all_reuse + 2; // groups of 3 without and with tiles
    check_chains( &c, make_mirror_room( STANDING_MIRROR ) );
}

// A chain takes as many vertices as it has.
TEST( test_any_depth_is_unbiased )
{
    check_room( "mirror, depth 2", FLAT_MIRROR, 2 );
    check_room( "mirror, depth 3", FLAT_MIRROR, 3 );
    check_room( "mirror, depth 4", FLAT_MIRROR, 4 );
    check_room( "facing mirrors, depth 4", FACING_MIRRORS, 4 );
}

TEST( test_lights_in_a_mirror_are_unbiased )
{
    static const struct
    {
        const char* what;
        OpenLight light;
    } open[] = { { "mirror, map", LIT_BY_MAP }, { "mirror, lamps", LIT_BY_LAMPS }, { "mirror, all lights", LIT_BY_ALL } };
    check_room( "mirror, sign", MIRROR_BY_SIGN, 4 );
    for ( size_t k = 0; k < sizeof open / sizeof open[0]; ++k )
    {
        ChainCase c = chain_case( open[k].what, 4 );
        check_chains( &c, make_mirror_in_the_open( open[k].light ) );
    }
}

TEST( test_extra_samples_are_unbiased )
{
    ChainCase c = chain_case( "coplanar mirrors", 5 );
    c.settings = g_adaptive;
    c.setting_count = 1;
    check_chains( &c, make_mirror_room( COPLANAR_MIRRORS ) );
}

STATISTICAL_TESTS
