// Tiles: their names; the patches of a pass cover every pixel of the film once with tiles
// of the right shape, for any shift.
#include "support/test.h"
#include "base/random.h"
#include "reuse/tile/tile.h"

#include <stdlib.h>
#include <string.h>

TEST( test_names_of_tiles )
{
    static const char* const good[] = { "1", "3x3", "2x1", "1x64", "8x8", "rooks2", "rooks16", "rooks64" };
    for ( size_t i = 0; i < sizeof good / sizeof good[0]; ++i )
    {
        RfTile tile;
        char name[24];
        assert_true( rf_parse_tile( good[i], &tile ) );
        assert_true( rf_is_tile( &tile ) );
        rf_tile_name( &tile, name );
        assert_string_equal( name, good[i] );
    }
    RfTile tile;
    assert_true( rf_parse_tile( "1x1", &tile ) && tile.kind == RF_TILE_NONE );
    assert_true( rf_parse_tile( "rooks1", &tile ) && tile.kind == RF_TILE_NONE );
    static const char* const bad[] = { "",
                                       "0",
                                       "2",
                                       "3x",
                                       "x3",
                                       "3x3x3",
                                       "9x8",
                                       "65x1",
                                       "0x4",
                                       "3X3",
                                       "-3x3",
                                       " 3x3",
                                       "3x3 ",
                                       "rooks",
                                       "rooks0",
                                       "rooks65",
                                       "rook",
                                       "rooks3x3",
                                       "rooks-3",
                                       "rooks 3",
                                       "Rooks9",
                                       "99999999999999999999x1",
                                       "1x99999999999999999999" };
    for ( size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i )
        assert_false( rf_parse_tile( bad[i], &tile ) );
    // who fills in an RfTile must not get a grid of one pixel for each pixel of a patch
    assert_false( rf_is_tile( &( RfTile ){ RF_TILE_ROOKS, 1, 1 } ) );
}

typedef struct Cover
{
    RfPatchLayout layout;
    RfEye eye;
    uint64_t key;
    int32_t* tile; // per pixel of the film: a number of its own per tile
    int tiles;
} Cover;

static void cover_film( Cover* c )
{
    int pixels = c->eye.width * c->eye.height;
    for ( int i = 0; i < pixels; ++i )
        c->tile[i] = -1;
    int base = 0;
    for ( int p = 0; p < c->layout.count; ++p )
    {
        int32_t pixel[RF_PATCH_PIXELS], tile_of[RF_PATCH_PIXELS];
        int tiles, count = rf_list_patch( &c->layout, &c->eye, c->key, p, pixel, tile_of, &tiles );
        assert_in_range( count, 0, RF_PATCH_PIXELS );
        assert_in_range( tiles, 1, RF_PATCH_PIXELS );
        for ( int i = 0; i < count; ++i )
        {
            assert_in_range( pixel[i], 0, pixels - 1 );
            assert_in_range( tile_of[i], 0, tiles - 1 );
            assert_int_equal( c->tile[pixel[i]], -1 ); // no pixel twice
            c->tile[pixel[i]] = base + tile_of[i];
        }
        base += tiles;
    }
    c->tiles = base;
    for ( int i = 0; i < pixels; ++i )
        assert_true( c->tile[i] >= 0 ); // none left out
}

// Extent, and whether a row or column is used twice, of every tile.
static void check_shapes( const Cover* c )
{
    int w = c->eye.width, n = c->layout.tile.width, size = rf_tile_pixels( &c->layout.tile ), whole = 0;
    for ( int t = 0; t < c->tiles; ++t )
    {
        int x0 = w, x1 = -1, y0 = c->eye.height, y1 = -1, count = 0;
        uint64_t rows = 0, columns = 0;
        for ( int i = 0; i < w * c->eye.height; ++i )
        {
            if ( c->tile[i] != t )
                continue;
            int x = i % w, y = i / w;
            x0 = x < x0 ? x : x0, x1 = x > x1 ? x : x1, y0 = y < y0 ? y : y0, y1 = y > y1 ? y : y1;
            if ( c->layout.tile.kind == RF_TILE_ROOKS )
            {
                // films here are smaller than 64, so a grid's rows are told apart by the film's
                assert_true( ( rows >> y & 1u ) == 0 && ( columns >> x & 1u ) == 0 );
                rows |= (uint64_t)1 << y;
                columns |= (uint64_t)1 << x;
            }
            ++count;
        }
        if ( count == 0 )
            continue;
        assert_true( x1 - x0 < n && y1 - y0 < c->layout.tile.height );
        assert_true( count <= size );
        whole += count == size;
        if ( c->layout.tile.kind == RF_TILE_BLOCK )
            assert_int_equal( count, ( x1 - x0 + 1 ) * ( y1 - y0 + 1 ) );
    }
    if ( w >= 2 * n && c->eye.height >= 2 * c->layout.tile.height )
        assert_true( whole > 0 );
}

TEST( test_every_pixel_once )
{
    static const char* const names[] = { "3x3",    "2x1",    "5x7",     "1x13",    "8x8",    "64x1",
                                         "rooks2", "rooks9", "rooks16", "rooks36", "rooks64" };
    static const int sizes[][2] = { { 1, 1 }, { 5, 3 }, { 33, 61 }, { 63, 40 } };
    for ( size_t k = 0; k < sizeof names / sizeof names[0]; ++k )
    {
        RfTile tile;
        assert_true( rf_parse_tile( names[k], &tile ) );
        for ( int s = 0; s < 4; ++s )
        {
            int32_t memory[63 * 61];
            for ( uint64_t seed = 0; seed < 6; ++seed )
            {
                Cover c = { .eye = { .width = sizes[s][0], .height = sizes[s][1] }, .key = rf_mix64( seed ), .tile = memory };
                c.layout = rf_lay_out_patches( &tile, false, c.eye.width, c.eye.height );
                cover_film( &c );
                check_shapes( &c );
            }
        }
    }
}

// Any two neighbours share a tile in some passes and in others do not: no seam
// stays where it is.
TEST( test_no_seam_stays )
{
    static const char* const names[] = { "3x3", "rooks9" };
    enum
    {
        SIDE = 40,
        PASSES = 64
    };
    static int32_t tile[SIDE * SIDE];
    static int together[SIDE * SIDE];
    for ( int k = 0; k < 2; ++k )
    {
        RfTile shape;
        assert_true( rf_parse_tile( names[k], &shape ) );
        memset( together, 0, sizeof together );
        int step = k == 0 ? 1 : SIDE + 1; // to the right; diagonally, since rooks share no row
        for ( int pass = 0; pass < PASSES; ++pass )
        {
            Cover c = { .eye = { .width = SIDE, .height = SIDE }, .key = rf_mix64( (uint64_t)pass ), .tile = tile };
            c.layout = rf_lay_out_patches( &shape, false, SIDE, SIDE );
            cover_film( &c );
            for ( int i = 0; i + step < SIDE * SIDE; ++i )
                together[i] += tile[i] == tile[i + step];
        }
        // blocks: 2 of 3 passes; rooks: (8/9)² · 1/8 of them: a pixel has one mate in each other row
        double share = k == 0 ? 2.0 / 3.0 : 64.0 / 81.0 / 8.0, sum = 0.0;
        int count = 0;
        for ( int y = 0; y + 1 < SIDE; ++y )
        {
            for ( int x = 0; x + 1 < SIDE; ++x )
            {
                int n = together[y * SIDE + x];
                assert_true( n < PASSES && ( k == 1 || n > 0 ) );
                sum += n;
                ++count;
            }
        }
        assert_true( sum / count / PASSES > share * 0.85 && sum / count / PASSES < share * 1.15 );
    }
}
