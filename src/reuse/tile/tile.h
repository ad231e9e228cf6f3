// Tiles: sets of pixels of one frame that share their paths (Bekaert, Sbert,
// Halton, Accelerating Path Tracing by Re-Using Paths, EGWR 2002;
// src/reuse/estimators.md, section 4). A film is cut into patches, whose pixels fill a
// wavefront, and a patch into tiles.
#ifndef REFRAME_REUSE_TILE_TILE_H
#define REFRAME_REUSE_TILE_TILE_H

#include "reframe/render.h"
#include "scene/eye.h"

static inline RfTile rf_no_tile( void ) { return ( RfTile ){ RF_TILE_NONE, 1, 1 }; }

bool rf_is_tile( const RfTile* tile );

// Pixels of a whole tile.
static inline int rf_tile_pixels( const RfTile* tile )
{
    return tile->kind == RF_TILE_BLOCK ? tile->width * tile->height : tile->width;
}

#define RF_PATCH_PIXELS 1024 // at most: they fill a wavefront

// How patches cover a film. A patch consists of whole grids. The grid of a block is the block itself; N tiles of rooks share a
// grid of N×N pixels, and where that is more than a wavefront, a patch has some of its tiles.
typedef struct RfPatchLayout
{
    RfTile tile;
    int width, height;           // of a patch, pixels
    int grid_width, grid_height; // all patches are shifted by less than that in every pass
    int across, parts;           // patches in a row; patches that share the tiles of one grid
    int count;
    // Scattered, for lens and shutter, whose sample a patch has in common: the tiles of a patch (without tiles, blocks of 2×2)
    // come from all over a strip of the film, so that no two neighbours are in one patch.
    bool scattered;
    int grids_x, grids_y;          // then: tiles across and down the film, with room for the shift
    int strip_rows, strip_patches; // rows of tiles in a strip, and its patches
} RfPatchLayout;

RfPatchLayout rf_lay_out_patches( const RfTile* tile, bool scattered, int width, int height );

// The rectangle [x0, x1) × [y0, y1) of the film that holds a patch; empty for patches beside the film.
void rf_bound_patch( const RfPatchLayout* layout, const RfEye* eye, uint64_t pass_key, int patch, int* x0, int* y0, int* x1,
                     int* y1 );

// Lists the pixels of a patch that lie on the film, in blocks of 4×4 for coherent packets, and the tile of each, numbered
// from 0 within the patch (not with RF_TILE_NONE). Returns how many; `tile_count` may be larger than the number of tiles
// that have a pixel. `pass_key` (base/random.h) draws the tiles. `pixel` and `tile_of` hold RF_PATCH_PIXELS.
int rf_list_patch( const RfPatchLayout* layout, const RfEye* eye, uint64_t pass_key, int patch, int32_t* pixel, int32_t* tile_of,
                   int* tile_count );

#endif
