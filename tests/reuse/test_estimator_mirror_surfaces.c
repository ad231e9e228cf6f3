// Mirrors whose surface varies, and surfaces with holes or half transparent before and behind
// mirrors, are rendered without bias by tiles, by groups of frames and by both, against
// independent references over 16 seeds.
#include "support/unbiased.h"
#include "support/rooms.h"
#include "support/statistics.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static void check_room( const char* what, MirrorRoom kind )
{
    ChainCase c = chain_case( what, 5 );
    check_chains( &c, make_mirror_room( kind ) );
}

static void test_bumpy_mirrors_are_unbiased( void** state )
{
    (void)state;
    check_room( "normal-mapped mirror", BUMPY_MIRROR );
}

static void test_textured_mirrors_are_unbiased( void** state )
{
    (void)state;
    check_room( "textured mirror", TEXTURED_MIRROR );
}

static void test_mirrors_with_holes_are_unbiased( void** state )
{
    (void)state;
    check_room( "masked mirror", MASKED_MIRROR );
    check_room( "blended mirror", BLENDED_MIRROR );
}

static void test_screens_about_a_mirror_are_unbiased( void** state )
{
    (void)state;
    check_room( "masked screens", MASKED_SCREENS );
    check_room( "blended screens", BLENDED_SCREENS );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_bumpy_mirrors_are_unbiased ),
        cmocka_unit_test( test_textured_mirrors_are_unbiased ),
        cmocka_unit_test( test_mirrors_with_holes_are_unbiased ),
        cmocka_unit_test( test_screens_about_a_mirror_are_unbiased ),
    };
    return run_statistical_tests( tests, sizeof tests / sizeof *tests );
}
