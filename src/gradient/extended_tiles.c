#include "gradient/extended_tiles.h"

#include "path/lanes.h"
#include "reuse/tile.h"

#define SALT 0x6d41e00000000u // keeps the random numbers of the shift apart

static int up( int a, int b ) { return ( a + b - 1 ) / b; }
static int at_most( int a, int b ) { return a < b ? a : b; }
static int at_least( int a, int b ) { return a > b ? a : b; }

RfExtendedTiles rf_lay_out_extended_tiles( const RfTile* tile, bool scattered, int width, int height )
{
    RfExtendedTiles l = { .film_width = width, .film_height = height, .scattered = scattered };
    l.pairs = tile->kind == RF_TILE_NONE;
    l.width = l.pairs ? 1 : tile->width;
    l.height = l.pairs ? 1 : tile->height;
    l.across = up( width + l.width - 1, l.width );
    l.down = up( height + l.height - 1, l.height );
    int tiles = RF_PATCH_PIXELS / ( l.pairs ? 4 * rf_extended_pixels( tile ) : rf_extended_pixels( tile ) );
    l.patch_across = 1;
    while ( ( l.patch_across + 1 ) * ( l.patch_across + 1 ) <= tiles )
        ++l.patch_across;
    l.patch_down = tiles / l.patch_across;
    l.patches_x = up( l.across, l.patch_across );
    l.patches = l.patches_x * up( l.down, l.patch_down );
    return l;
}

// The number of tile k of a patch; past the last one: none.
static int tile_number( const RfExtendedTiles* l, int patch, int k )
{
    if ( l->scattered )
        return k * l->patches + patch;
    int x = patch % l->patches_x * l->patch_across + k % l->patch_across;
    int y = patch / l->patches_x * l->patch_down + k / l->patch_across;
    return x < l->across && y < l->down ? y * l->across + x : l->across * l->down;
}

// The pairs of pixel (x, y) with its neighbours on the film, left, right, above and below.
static int list_pairs( const RfExtendedTiles* l, int x, int y, RfExtendedTile* tiles )
{
    static const int s_step[4][2] = { { -1, 0 }, { 1, 0 }, { 0, -1 }, { 0, 1 } };
    int count = 0;
    for ( int k = 0; k < 4; ++k )
    {
        int dx = s_step[k][0], dy = s_step[k][1];
        if ( x + dx < 0 || y + dy < 0 || x + dx >= l->film_width || y + dy >= l->film_height )
            continue;
        int x0 = at_most( x, x + dx ), y0 = at_most( y, y + dy ), x1 = at_least( x, x + dx ) + 1, y1 = at_least( y, y + dy ) + 1;
        tiles[count] = ( RfExtendedTile ){ y * l->film_width + x, x0, y0, x1, y1, count == 0 ? x1 : x0, y1, dx + dy < 0 };
        ++count;
    }
    return count;
}

int rf_list_extended_tiles( const RfExtendedTiles* l, uint64_t pass_key, int patch, RfExtendedTile* tiles )
{
    uint64_t state = rf_mix64( pass_key ^ SALT );
    int shift_x = (int)( ( state >> 32 ) % (uint64_t)l->width );
    int shift_y = (int)( ( state & 0xffffffffu ) % (uint64_t)l->height );
    int count = 0;
    for ( int k = 0; k < l->patch_across * l->patch_down; ++k )
    {
        int number = tile_number( l, patch, k );
        int x = number % l->across * l->width - shift_x, y = number / l->across * l->height - shift_y;
        if ( number >= l->across * l->down || x + l->width <= 0 || y + l->height <= 0 || x >= l->film_width ||
             y >= l->film_height )
            continue;
        int right = at_most( x + l->width + 1, l->film_width ), bottom = at_most( y + l->height + 1, l->film_height );
        if ( l->pairs )
            count += list_pairs( l, x, y, tiles + count );
        else
            tiles[count++] = ( RfExtendedTile ){ number,
                                                 at_least( x, 0 ),
                                                 at_least( y, 0 ),
                                                 right,
                                                 bottom,
                                                 at_most( x + l->width, l->film_width ),
                                                 at_most( y + l->height, l->film_height ),
                                                 0 };
    }
    return count;
}
