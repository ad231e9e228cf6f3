// Mirrors whose surface varies, and surfaces with holes or half transparent before and behind
// mirrors, are rendered without bias by tiles, by groups of frames and by both, against
// independent references over 16 seeds.
#include "support/test.h"
#include "support/unbiased.h"
#include "support/rooms.h"
#include "support/statistics.h"

static void check_room( const char* what, MirrorRoom kind )
{
    ChainCase c = chain_case( what, 5 );
    check_chains( &c, make_mirror_room( kind ) );
}

TEST( test_bumpy_mirrors_are_unbiased ) { check_room( "normal-mapped mirror", BUMPY_MIRROR ); }

TEST( test_textured_mirrors_are_unbiased ) { check_room( "textured mirror", TEXTURED_MIRROR ); }

TEST( test_mirrors_with_holes_are_unbiased )
{
    check_room( "masked mirror", MASKED_MIRROR );
    check_room( "blended mirror", BLENDED_MIRROR );
}

TEST( test_screens_about_a_mirror_are_unbiased )
{
    check_room( "masked screens", MASKED_SCREENS );
    check_room( "blended screens", BLENDED_SCREENS );
}

STATISTICAL_TESTS
