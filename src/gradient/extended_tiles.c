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
    l.width = tile->width;
    l.height = tile->height;
    l.across = up( width + l.width - 1, l.width );
    l.down = up( height + l.height - 1, l.height );
    int tiles = RF_PATCH_PIXELS / rf_extended_pixels( tile );
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
        tiles[count++] =
            ( RfExtendedTile ){ number, at_least( x, 0 ), at_least( y, 0 ), at_most( x + l->width + 1, l->film_width ),
                                at_most( y + l->height + 1, l->film_height ) };
    }
    return count;
}
