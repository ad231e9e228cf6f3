// Pieces: a render that traces only some parts of its frames, for measuring. Films, film densities and MIS weights stay
// those of the whole frames, so a pixel is what it is in the whole render if all pixels are traced from which hits land in
// it: its own, and those of other frames of its groups that show the same surface.
#ifndef REFRAME_RENDER_PIECES_H
#define REFRAME_RENDER_PIECES_H

#include "film/film.h"
#include "reframe/render.h"

#include <stddef.h>

#define RF_CELL_SIDE 4 // pixels; patches and packets consist of blocks of this size, too

struct RfPieces
{
    int across, down;     // cells of a frame
    const uint8_t* cells; // a byte for each, row by row, frame after frame from the path's first: is it traced?
};

static inline int rf_cells_along( int pixels ) { return ( pixels + RF_CELL_SIDE - 1 ) / RF_CELL_SIDE; }

static inline const uint8_t* rf_frame_cells( const RfPieces* pieces, int frame )
{
    return pieces->cells + (size_t)frame * (size_t)pieces->across * (size_t)pieces->down;
}

// Is pixel (x, y) of the film traced? `cells` are those of its frame.
static inline bool rf_is_traced( const RfPieces* pieces, const uint8_t* cells, int x, int y )
{
    return cells[(size_t)( y / RF_CELL_SIDE ) * (size_t)pieces->across + (size_t)( x / RF_CELL_SIDE )] != 0;
}

// Clears a frame's film where it is traced, and its counts; what lands elsewhere adds up and is never looked at.
void rf_clear_traced( const RfPieces* pieces, int frame, RfFilm* film );

// Combines a frame's film where it is traced; the rest of rgb and weight stays as it is.
void rf_combine_traced( const RfPieces* pieces, int frame, const RfFilm* film, RfNormalize normalize, float* rgb, float* weight );

#endif
