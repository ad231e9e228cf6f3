// Divides a film into patches and lists the pixels of their tiles: blocks, or scattered by Latin squares.
#include "reuse/tile/tile.h"

#include "base/random.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PLAIN_SIDE 32 // of a patch without tiles, and about that of the others
// A strip of scattered patches has at least so many rows of pixels and patches, so the neighbours of a tile are in other patches.
#define STRIP_HEIGHT 48
#define STRIP_PATCHES 16
#define ROW_SHIFT 7          // tiles, by which a row of scattered ones is shifted against the next
#define UNIT_SIDE 2          // of the blocks of scattered patches without tiles
#define SALT 0x711300000000u // above all pixels: keeps the tiles' random numbers apart from the pixels'

static bool parse_count( const char** text, int* count )
{
    char* end;
    if ( **text < '0' || **text > '9' )
        return false;
    long value = strtol( *text, &end, 10 );
    *count = (int)value;
    *text = end;
    return value >= 1 && value <= RF_MAX_TILE_PIXELS;
}

bool rf_is_tile( const RfTile* tile )
{
    int w = tile->width, h = tile->height;
    if ( tile->kind == RF_TILE_NONE )
        return true;
    if ( w < 1 || h < 1 || w > RF_MAX_TILE_PIXELS || h > RF_MAX_TILE_PIXELS )
        return false;
    return tile->kind == RF_TILE_BLOCK ? w * h <= RF_MAX_TILE_PIXELS : tile->kind == RF_TILE_ROOKS && w == h && w > 1;
}

bool rf_parse_tile( const char* text, RfTile* tile )
{
    static const char s_rooks[] = "rooks";
    size_t prefix = strlen( s_rooks );
    if ( strcmp( text, "auto" ) == 0 )
    {
        *tile = ( RfTile ){ RF_TILE_AUTO, 1, 1 };
        return true;
    }
    tile->kind = strncmp( text, s_rooks, prefix ) == 0 ? RF_TILE_ROOKS : RF_TILE_BLOCK;
    text += tile->kind == RF_TILE_ROOKS ? prefix : 0;
    if ( !parse_count( &text, &tile->width ) )
        return false;
    tile->height = tile->width;
    bool one = tile->kind == RF_TILE_BLOCK && *text == '\0';
    if ( tile->kind == RF_TILE_BLOCK && !one && !( *text++ == 'x' && parse_count( &text, &tile->height ) ) )
        return false;
    if ( *text != '\0' || ( one && tile->width != 1 ) )
        return false;
    if ( rf_tile_pixels( tile ) == 1 )
        *tile = rf_no_tile();
    return rf_is_tile( tile );
}

void rf_tile_name( const RfTile* tile, char text[RF_TILE_NAME_SIZE] )
{
    if ( tile->kind == RF_TILE_NONE || tile->kind == RF_TILE_AUTO )
        strcpy( text, tile->kind == RF_TILE_NONE ? "1" : "auto" );
    else if ( tile->kind == RF_TILE_BLOCK )
        snprintf( text, 24, "%dx%d", tile->width, tile->height );
    else
        snprintf( text, 24, "rooks%d", tile->width );
}

static int up( int a, int b ) { return ( a + b - 1 ) / b; }
static int at_least_one( int a ) { return a > 1 ? a : 1; }

static RfPatchLayout scatter_patches( const RfTile* tile, int width, int height )
{
    RfPatchLayout l = { .tile = *tile, .grid_width = tile->width, .grid_height = tile->height, .parts = 1, .scattered = true };
    if ( tile->kind == RF_TILE_NONE )
        l.grid_width = l.grid_height = UNIT_SIDE;
    l.grids_x = up( width + l.grid_width - 1, l.grid_width );
    l.grids_y = up( height + l.grid_height - 1, l.grid_height );
    int of_patch = RF_PATCH_PIXELS / ( l.grid_width * l.grid_height );
    l.strip_rows = up( STRIP_PATCHES * of_patch, l.grids_x );
    l.strip_rows = l.strip_rows > STRIP_HEIGHT / l.grid_height ? l.strip_rows : up( STRIP_HEIGHT, l.grid_height );
    l.strip_patches = up( l.grids_x * l.strip_rows, of_patch );
    l.count = l.strip_patches * up( l.grids_y, l.strip_rows );
    return l;
}

RfPatchLayout rf_lay_out_patches( const RfTile* tile, bool scattered, int width, int height )
{
    if ( scattered && tile->kind != RF_TILE_ROOKS )
        return scatter_patches( tile, width, height );
    RfPatchLayout l = { .tile = *tile, .grid_width = tile->width, .grid_height = tile->height, .parts = 1 };
    int w = l.grid_width, h = l.grid_height;
    int grids_x = at_least_one( PLAIN_SIDE / w );
    int grids_y = at_least_one( RF_PATCH_PIXELS / ( grids_x * w * h ) );
    if ( w * h > RF_PATCH_PIXELS )
        l.parts = up( w, RF_PATCH_PIXELS / w );
    l.width = grids_x * w;
    l.height = grids_y * h;
    // room for the shift as well
    l.across = up( width + w - 1, l.width );
    l.count = l.across * up( height + h - 1, l.height ) * l.parts;
    return l;
}

static uint32_t draw( uint64_t* state )
{
    *state = rf_mix64( *state );
    return (uint32_t)( *state >> 32 );
}

static void permute( int count, uint64_t* state, uint8_t* out )
{
    for ( int i = 0; i < count; ++i )
        out[i] = (uint8_t)i;
    for ( int i = count - 1; i > 0; --i )
    {
        int k = (int)( ( (uint64_t)draw( state ) * (uint64_t)( i + 1 ) ) >> 32 );
        uint8_t swap = out[i];
        out[i] = out[k];
        out[k] = swap;
    }
}

// A Latin square: pixel (x, y) of the grid belongs to tile (row[y] + column[x])
// mod N, so every tile has one pixel in each row and column.
typedef struct Rooks
{
    uint8_t row[RF_MAX_TILE_PIXELS], column[RF_MAX_TILE_PIXELS];
} Rooks;

typedef struct Place
{
    int x0, y0;                 // of the patch on the film
    int grids_x;                // grids in a row of it
    int first_tile, tile_count; // of a grid, in this part
} Place;

static Place place_of( const RfPatchLayout* l, uint64_t pass_key, int patch )
{
    uint64_t state = rf_mix64( pass_key ^ SALT );
    int shift_x = (int)( draw( &state ) % (uint32_t)l->grid_width );
    int shift_y = (int)( draw( &state ) % (uint32_t)l->grid_height );
    int at = patch / l->parts, part = patch % l->parts;
    Place p = {
        .x0 = at % l->across * l->width - shift_x,
        .y0 = at / l->across * l->height - shift_y,
        .grids_x = l->width / l->grid_width,
    };
    int tiles = l->tile.kind == RF_TILE_ROOKS ? l->grid_width : 1;
    p.first_tile = tiles * part / l->parts;
    p.tile_count = tiles * ( part + 1 ) / l->parts - p.first_tile;
    return p;
}

// Pixel (x, y) of the patch: its tile, or −1 where it belongs to another part.
static int tile_at( const RfPatchLayout* l, const Place* p, const Rooks* rooks, int x, int y )
{
    int grid = y / l->grid_height * p->grids_x + x / l->grid_width;
    if ( l->tile.kind != RF_TILE_ROOKS )
        return grid;
    const Rooks* r = rooks + grid;
    int n = l->grid_width, t = ( r->row[y % n] + r->column[x % n] ) % n - p->first_tile;
    return t >= 0 && t < p->tile_count ? grid * p->tile_count + t : -1;
}

// The patterns of a place do not depend on the part.
static void draw_rooks( const RfPatchLayout* l, uint64_t pass_key, int at, int grids, Rooks* rooks )
{
    for ( int g = 0; g < grids; ++g )
    {
        uint64_t state = rf_mix64( rf_mix64( pass_key ^ SALT ) ^ (uint64_t)( at * grids + g ) );
        permute( l->grid_width, &state, rooks[g].row );
        permute( l->grid_width, &state, rooks[g].column );
    }
}

// The pixels of tile `slot` of a scattered patch. Without the shift of rows, whole columns of tiles could be in one patch.
static int list_tile( const RfPatchLayout* l, const RfEye* eye, uint64_t pass_key, int patch, int slot, int32_t* pixel )
{
    uint64_t state = rf_mix64( pass_key ^ SALT );
    int shift_x = (int)( draw( &state ) % (uint32_t)l->grid_width ), shift_y = (int)( draw( &state ) % (uint32_t)l->grid_height );
    int strip = patch / l->strip_patches, number = slot * l->strip_patches + patch % l->strip_patches;
    int row = number / l->grids_x, column = ( number + ROW_SHIFT * row ) % l->grids_x, count = 0;
    row += strip * l->strip_rows;
    for ( int k = 0; k < l->grid_width * l->grid_height; ++k )
    {
        int x = column * l->grid_width - shift_x + k % l->grid_width, y = row * l->grid_height - shift_y + k / l->grid_width;
        if ( x >= 0 && y >= 0 && x < eye->width && y < eye->height )
            pixel[count++] = y * eye->width + x;
    }
    return count;
}

static int list_scattered( const RfPatchLayout* l, const RfEye* eye, uint64_t pass_key, int patch, int32_t* pixel,
                           int32_t* tile_of, int* tile_count )
{
    int tiles = l->grids_x * l->strip_rows, count = 0, slot = 0;
    for ( ; slot * l->strip_patches + patch % l->strip_patches < tiles; ++slot )
    {
        int end = count + list_tile( l, eye, pass_key, patch, slot, pixel + count );
        for ( ; count < end; ++count )
            tile_of[count] = slot;
    }
    *tile_count = slot;
    return count;
}

void rf_bound_patch( const RfPatchLayout* l, const RfEye* eye, uint64_t pass_key, int patch, int* x0, int* y0, int* x1, int* y1 )
{
    *x0 = *y0 = 0;
    *x1 = eye->width;
    *y1 = eye->height;
    if ( l->scattered )
        return;
    Place p = place_of( l, pass_key, patch );
    *x1 = p.x0 + l->width < eye->width ? p.x0 + l->width : eye->width;
    *y1 = p.y0 + l->height < eye->height ? p.y0 + l->height : eye->height;
    *x0 = p.x0 > 0 ? p.x0 : 0;
    *y0 = p.y0 > 0 ? p.y0 : 0;
}

int rf_list_patch( const RfPatchLayout* l, const RfEye* eye, uint64_t pass_key, int patch, int32_t* pixel, int32_t* tile_of,
                   int* tile_count )
{
    if ( l->scattered )
        return list_scattered( l, eye, pass_key, patch, pixel, tile_of, tile_count );
    Rooks rooks[RF_PATCH_PIXELS / 4]; // rooks of two, at most
    Place p = place_of( l, pass_key, patch );
    int grids = p.grids_x * ( l->height / l->grid_height );
    if ( l->tile.kind == RF_TILE_ROOKS )
        draw_rooks( l, pass_key, patch / l->parts, grids, rooks );
    *tile_count = grids * p.tile_count;
    int count = 0, blocks_x = up( l->width, 4 );
    for ( int i = 0; i < blocks_x * up( l->height, 4 ) * 16; ++i )
    {
        int block = i / 16, within = i % 16;
        int x = block % blocks_x * 4 + within % 4, y = block / blocks_x * 4 + within / 4;
        int fx = p.x0 + x, fy = p.y0 + y;
        if ( x >= l->width || y >= l->height || fx < 0 || fy < 0 || fx >= eye->width || fy >= eye->height )
            continue;
        int tile = tile_at( l, &p, rooks, x, y );
        if ( tile < 0 )
            continue;
        tile_of[count] = tile;
        pixel[count++] = fy * eye->width + fx;
    }
    return count;
}
