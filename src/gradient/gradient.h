// Gradient-domain path reusing as an estimator: the pixels of a tile share paths, which bring similar light to
// neighbours, so the differences of neighbours have little noise. The image is reconstructed from pixels and
// differences (Bauszat, Petitjean, Eisemann, Gradient-Domain Path Reusing, 2017; Kettunen et al., Gradient-Domain
// Path Tracing, 2015). README.md has the details.
#ifndef REFRAME_GRADIENT_GRADIENT_H
#define REFRAME_GRADIENT_GRADIENT_H

#include "base/random.h"
#include "film/aov.h"
#include "reframe/render.h"
#include "reuse/reuse_plan.h"

#include <stdbool.h>
#include <stdint.h>

#define RF_MAX_TILE_SIDE 8           // pixels, not extended
#define RF_LISTED_TILES ( 1024 / 2 ) // of a patch, at most: pairs of pixels

typedef struct RfExtendedTiles
{
    int film_width, film_height;
    int width, height;            // of a tile as it is cut, pixels
    int across, down;             // tiles, with room for the shift
    int patch_across, patch_down; // tiles of a patch
    int patches_x, patches;       // in a row of them; in all
    bool pairs;                   // tiles of one pixel
    bool scattered;               // a patch has tiles from all over the film
} RfExtendedTiles;

// One extended tile on the film: pixels [x0, x1) × [y0, y1), cut to the film.
typedef struct RfExtendedTile
{
    int32_t number; // of the tile in the pass; of a pair: of the pixel with the path, y·width + x
    int32_t x0, y0, x1, y1;
    int32_t own_x1, own_y1; // its own pixels, which no other tile of the pass has, end there; of all pairs of a pixel with
                            // a path the first has it as its own, the others have none: own_x1 = x0
    int32_t source;         // of a pair: index of the pixel with the path, 0 or 1
} RfExtendedTile;

RfExtendedTiles rf_lay_out_extended_tiles( const RfTile* tile, bool scattered, int width, int height );

static inline int rf_extended_pixels( const RfTile* tile )
{
    return tile->kind == RF_TILE_NONE ? 2 : ( tile->width + 1 ) * ( tile->height + 1 );
}

static inline int rf_tile_area( const RfExtendedTile* tile ) { return ( tile->x1 - tile->x0 ) * ( tile->y1 - tile->y0 ); }

// The tiles of a patch that have a pixel of their own on the film, shifted by `pass_key`. Returns how many.
int rf_list_extended_tiles( const RfExtendedTiles* layout, uint64_t pass_key, int patch, RfExtendedTile* tiles );

enum
{
    RF_FILM_PRIMAL,                      // values
    RF_FILM_DX,                          // value of the pixel to the right minus that of the pixel
    RF_FILM_DY,                          // of the pixel below
    RF_FILM_SQUARES,                     // sums over the channels of the squares of these three
    RF_FILM_UNSHARED = RF_UNSHARED_FILM, // of the values, what tiles do not share: differences lack it
    RF_GRADIENT_FILMS,
};

size_t rf_finish_gradients_bytes( const RfRenderSettings* settings, int width, int height );

// RfEstimator.finish: the reconstruction that the settings ask for.
RfRelmse rf_finish_gradients( const RfRenderSettings* settings, const RfFilm* films, RfPicture* picture, void* scratch );

extern const RfEstimator rf_gradient_estimator;

#endif
