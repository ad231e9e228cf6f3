// In every pass the tiles' own pixels, whose AOVs count, cover the film exactly once, for tiles of any size and film.
#include "support/test.h"
#include "gradient/gradient.h"

enum
{
    MOST = 40 * 40
};

static void count_own( const RfExtendedTiles* layout, uint64_t pass, uint8_t* covered )
{
    static RfExtendedTile tiles[RF_LISTED_TILES];
    for ( int patch = 0; patch < layout->patches; ++patch )
    {
        int count = rf_list_extended_tiles( layout, pass, patch, tiles );
        for ( int t = 0; t < count; ++t )
        {
            const RfExtendedTile* tile = tiles + t;
            for ( int y = tile->y0, k = 0; y < tile->y1; ++y )
            {
                for ( int x = tile->x0; x < tile->x1; ++x, ++k )
                    covered[y * layout->film_width + x] +=
                        x < tile->own_x1 && y < tile->own_y1 && ( !layout->pairs || k == tile->source );
            }
        }
    }
}

TEST( test_own_pixels_cover_the_film_once )
{
    static const int films[][2] = { { 40, 40 }, { 37, 23 }, { 7, 5 }, { 2, 1 }, { 1, 9 } };
    for ( size_t f = 0; f < sizeof films / sizeof films[0]; ++f )
    {
        for ( int side = 1; side <= RF_MAX_TILE_SIDE; ++side )
        {
            RfTile tile = { side == 1 ? RF_TILE_NONE : RF_TILE_BLOCK, side, side };
            RfExtendedTiles layout = rf_lay_out_extended_tiles( &tile, side % 2 == 0, films[f][0], films[f][1] );
            for ( uint64_t pass = 0; pass < 20; ++pass )
            {
                uint8_t covered[MOST] = { 0 };
                count_own( &layout, pass, covered );
                for ( int i = 0; i < films[f][0] * films[f][1]; ++i )
                    assert_int_equal( covered[i], 1 );
            }
        }
    }
}
