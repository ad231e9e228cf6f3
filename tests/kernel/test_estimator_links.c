// Links to light paths leave the picture as it is in the mean: in rooms where paths from the eye find the light that mirrors
// and glass send on, against independent references over 16 seeds.
#include "support/chain_checks.h"
#include "support/mirror_rooms.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static void check_room( const char* what, MirrorRoom kind, int max_depth )
{
    ChainCase c = chain_case( what, max_depth );
    c.settings = g_linked;
    check_chains( &c, make_mirror_room( kind ) );
}

static void test_light_of_mirrors_is_unbiased( void** state )
{
    (void)state;
    check_room( "flat mirror", FLAT_MIRROR, 5 );
    check_room( "mirror ball", MIRROR_BALL, 5 );
}

static void test_light_through_glass_is_unbiased( void** state )
{
    (void)state;
    check_room( "glass ball", GLASS_BALL, 6 );
    check_room( "absorbing slab", ABSORBING_SLAB, 6 );
    check_room( "layered slab", LAYERED_SLAB, 6 );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_light_of_mirrors_is_unbiased ),
        cmocka_unit_test( test_light_through_glass_is_unbiased ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
