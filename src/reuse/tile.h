// Tiles: sets of pixels of one frame that share their paths (Bekaert, Sbert,
// Halton, Accelerating Path Tracing by Re-Using Paths, EGWR 2002;
// src/reuse/estimators.md, section 4). A film is cut into patches, whose pixels fill a
// wavefront, and a patch into tiles.
#ifndef REFRAME_REUSE_TILE_H
#define REFRAME_REUSE_TILE_H

#include "scene/eye.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum RfTileKind
{
    RF_TILE_NONE,  // nothing is shared
    RF_TILE_BLOCK, // width × height neighbours
    RF_TILE_ROOKS, // N pixels of an N × N grid, each row and column used once; N tiles make up the grid
} RfTileKind;

typedef struct RfTile
{
    RfTileKind kind;
    int width, height; // of a block, pixels; both N with rooks
} RfTile;

#define RF_MAX_TILE_PIXELS 64

static inline RfTile rf_no_tile( void ) { return ( RfTile ){ RF_TILE_NONE, 1, 1 }; }

// "1", "WxH" or "rooksN" with at most RF_MAX_TILE_PIXELS pixels; false where it
// is none of them. Tiles of one pixel are RF_TILE_NONE.
bool rf_parse_tile( const char* text, RfTile* tile );

// The name that parses to it. `text` holds 24 characters.
void rf_tile_name( const RfTile* tile, char* text );

bool rf_is_tile( const RfTile* tile );

// Pixels of a whole tile.
static inline int rf_tile_pixels( const RfTile* tile )
{
    return tile->kind == RF_TILE_BLOCK ? tile->width * tile->height : tile->width;
}

#define RF_PATCH_PIXELS 1024 // at most: they fill a wavefront

// How the patches lie on a film. Each holds whole grids: blocks, or what N
// tiles of rooks make up; where one grid is more than a wavefront, some of its tiles.
typedef struct RfPatchLayout
{
    RfTile tile;
    int width, height;           // of a patch, pixels
    int grid_width, grid_height; // all patches are shifted by less than that, anew in every pass
    int across, parts;           // patches in a row; patches that share one place
    int count;
} RfPatchLayout;

RfPatchLayout rf_lay_out_patches( const RfTile* tile, int width, int height );

// The pixels of a patch that lie on the film, in blocks of 4×4, so that a
// packet's rays keep together, and the tile of each, numbered from 0 within the
// patch (not with RF_TILE_NONE). Returns how many; `tile_count` may be larger
// than the number of tiles that have a pixel. The tiles are drawn by `pass_key`
// (base/random.h). `pixel` and `tile_of` hold RF_PATCH_PIXELS.
int rf_list_patch( const RfPatchLayout* layout, const RfEye* eye, uint64_t pass_key, int patch, int32_t* pixel, int32_t* tile_of,
                   int* tile_count );

#endif
