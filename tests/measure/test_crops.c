// Windows of the picture: their rays are those of the picture, they cover it evenly, and their margins are not measured.
#include "support/test.h"
#include "measure/trial_pieces.h"

#include "scene/projection.h"

#define WIDTH 320
#define HEIGHT 180
#define FRAMES 3

static void make_eyes( RfEye* eyes )
{
    for ( int i = 0; i < FRAMES; ++i )
        eyes[i] = rf_make_eye( rf_vec3( 0.1f * (float)i, 0, 0 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 0.8, WIDTH, HEIGHT );
}

static void assert_same_ray( const RfEye* window, const RfEye* eye, int x, int y, int dx, int dy )
{
    const float inverse[2] = { 1.0f / eye->focal_x, 1.0f / eye->focal };
    RfVec3 o[2], d[2];
    rf_eye_ray( window, inverse, x, y, 0.25f, 0.5f, o, d );
    rf_eye_ray( eye, inverse, x + dx, y + dy, 0.25f, 0.5f, o + 1, d + 1 );
    assert_true( rf_dot( d[0], d[1] ) > 0.99999999f - 1e-6f && o[0].x == o[1].x );
}

TEST( test_rays_are_those_of_the_picture )
{
    RfEye eyes[FRAMES], *crops;
    RfTestPieces pieces;
    bool left = false, right = false, low = false, high = false;
    make_eyes( eyes );
    for ( uint64_t seed = 1; seed <= 20; ++seed )
    {
        assert_int_equal( rf_choose_crops( eyes, FRAMES, 4000.0, seed, &crops, &pieces, NULL ), RF_OK );
        assert_non_null( crops );
        double pixels = pieces.pixels * RF_CROPS;
        assert_true( pixels > 0.8 * 4000.0 * FRAMES && pixels < 1.3 * 4000.0 * FRAMES );
        for ( int i = 0; i < RF_CROPS; ++i )
        {
            const RfEye* eye = eyes + i * FRAMES / RF_CROPS;
            int x = (int)( eye->axis_x - crops[i].axis_x ), y = (int)( eye->axis_y - crops[i].axis_y );
            assert_true( x >= 0 && y >= 0 && x + crops[i].width <= WIDTH && y + crops[i].height <= HEIGHT );
            assert_same_ray( crops + i, eye, 3, 7, x, y );
            left |= x<WIDTH / 4, right |= x> WIDTH / 2, low |= y > HEIGHT / 3, high |= y < HEIGHT / 6;
        }
        rf_destroy_test_pieces( &pieces );
        free( crops );
    }
    assert_true( left && right && low && high );
}

TEST( test_margins_are_not_measured )
{
    RfEye eyes[FRAMES], *crops;
    RfTestPieces p;
    make_eyes( eyes );
    assert_int_equal( rf_choose_crops( eyes, FRAMES, 4000.0, 3, &crops, &p, NULL ), RF_OK );
    int cells = p.across * p.down, inside = ( p.across - 2 ) * ( p.down - 2 );
    assert_int_equal( p.first_slot[RF_CROPS], inside * RF_CROPS );
    for ( int f = 0; f < RF_CROPS; ++f )
    {
        for ( int i = 0; i < cells; ++i )
        {
            int x = i % p.across, y = i / p.across, slot = p.slot[f * cells + i];
            bool margin = x == 0 || y == 0 || x == p.across - 1 || y == p.down - 1;
            assert_true( margin ? slot == -1 : slot >= p.first_slot[f] && slot < p.first_slot[f + 1] );
            assert_true( margin || p.piece[slot] < p.count );
        }
    }
    rf_destroy_test_pieces( &p );
    free( crops );
}

// Most of a picture: as well the whole of it.
TEST( test_small_pictures_are_taken_whole )
{
    RfEye eyes[FRAMES], *crops;
    RfTestPieces pieces;
    make_eyes( eyes );
    assert_int_equal( rf_choose_crops( eyes, 1, 0.8 * WIDTH * HEIGHT, 3, &crops, &pieces, NULL ), RF_OK );
    assert_null( crops );
}
