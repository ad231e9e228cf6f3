// Traces the pixels of extended tiles, which share their paths (src/reuse/estimators.md, E4), the position inside
// the pixel, and random numbers in chains. For differences they also share the light samples of first hits; values
// have their own, since a common error of a whole tile would show in no difference.
//
// Extended tiles: a film is cut into tiles, shifted in every pass, and each is extended by one column to the right
// and one row below, so that every pair of neighbouring pixels lies in at least one.
//
// Tiles of one pixel are gradient-domain path tracing: the path of a pixel is shifted to its four neighbours, by
// four extended tiles of two pixels of which the neighbour has no path.
#ifndef REFRAME_GRADIENT_SAMPLING_H
#define REFRAME_GRADIENT_SAMPLING_H

#include "base/random.h"
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

// Pixels of a whole extended tile.
static inline int rf_extended_pixels( const RfTile* tile )
{
    return tile->kind == RF_TILE_NONE ? 2 : ( tile->width + 1 ) * ( tile->height + 1 );
}

static inline int rf_tile_area( const RfExtendedTile* tile ) { return ( tile->x1 - tile->x0 ) * ( tile->y1 - tile->y0 ); }

// The tiles of a patch that have a pixel of their own on the film, shifted by `pass_key`. Returns how many.
int rf_list_extended_tiles( const RfExtendedTiles* layout, uint64_t pass_key, int patch, RfExtendedTile* tiles );

// A patch, as the films need it.
typedef struct RfGradientBatch
{
    int eye; // index in the group of the frame whose pixels these are
    int tile_count;
    RfExtendedTile tile[RF_LISTED_TILES];
    float value[RF_LANES][4];    // radiance: red, green, blue, and 1 where the camera ray missed; tile after tile, row after row
    float common[RF_LANES][3];   // radiance with the light samples that the tile has in common: for differences
    float unshared[RF_LANES][3]; // what tiles do not share; not part of `common`
} RfGradientBatch;

// A group compiled.
typedef struct RfGradientPlan
{
    RfExtendedTiles tiles;     // of its films
    RfRenderSettings settings; // as the harvest of frames and tiles has them: with whole extended tiles
    RfReusePlan reuse;
} RfGradientPlan;

void rf_compile_gradients( const RfEstimatorGroup* group, RfGradientPlan* out );

// A thread's workspace.
typedef struct RfGradientScratch RfGradientScratch;
RfGradientScratch* rf_place_gradient_scratch( const RfGradientPlan* plan, RfLayout* layout );

// Fills `batch` with patch job.job; adds the rays traced to `rays`. Returns the camera rays.
int rf_sample_patch( const RfEstimatorGroup* group, RfTraceJob job, RfGradientBatch* batch, RfGradientScratch* scratch,
                     RfRayCounts* rays );

// The camera rays of the patch just traced.
RfFirstHits rf_first_hits_of_patch( const RfGradientScratch* scratch );

#endif
