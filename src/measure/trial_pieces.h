// The pieces of a picture at which a trial measures: blocks of the real picture, one at a random place of each cell of a regular grid.
//
// Hits are reused in neighbouring frames. So in each frame of a test region the pieces lie where their surfaces are seen there, and from
// all frames those pixels are traced, too, whose hits land in a piece of some frame (render/pieces.h): a piece is then what it is in the
// whole render. Only where a surface comes into sight between the pixels that are looked at, or in a chain of mirrors, may a hit be missed.
#ifndef REFRAME_MEASURE_TRIAL_PIECES_H
#define REFRAME_MEASURE_TRIAL_PIECES_H

#include "render/pieces.h"
#include "scene/lens.h"
#include "scene/eye.h"

#define RF_MAX_PIECES 64
#define RF_CELL_PIXELS ( RF_CELL_SIDE * RF_CELL_SIDE )

// What is measured, in cells of 4×4 pixels (render/pieces.h). Slots number the cells of all pieces, frame after frame.
typedef struct RfTestPieces
{
    int width, height;   // of the film, pixels
    int across, down;    // cells of a film
    int frames, count;   // pieces
    uint8_t* traced;     // by frame and cell; NULL: everything is, and the pieces make up the picture
    int32_t* slot;       // by frame and cell; −1: in no piece
    int32_t* first_slot; // by frame, and the end of the last frame
    uint8_t* piece;      // by slot
    double pixels;       // traced of a frame, on average
} RfTestPieces;

// Chooses pieces such that about so many pixels of each frame are traced, or the whole pictures if that is not far from
// all; `centre` is the frame in which the pieces are blocks. `filtered`: pixels get samples from beside them, too. Fails with RF_ERROR_MEMORY. Free with
// rf_destroy_test_pieces, also after a failure.
RfResult rf_choose_pieces( const RfTracer* tracer, const RfEye* eyes, int frames, int centre, double pixels, bool filtered,
                           uint64_t seed, RfTestPieces* pieces, RfError* error );

void rf_destroy_test_pieces( RfTestPieces* pieces );

// What a render of the region's frames from `first` on traces.
RfPieces rf_pieces_from( const RfTestPieces* pieces, int first );

// The pixels of a cell that lie on the film: fills in their numbers and returns how many.
static inline int rf_cell_pixels( const RfTestPieces* pieces, int cell, int32_t pixel[RF_CELL_PIXELS] )
{
    int x0 = cell % pieces->across * RF_CELL_SIDE, y0 = cell / pieces->across * RF_CELL_SIDE, count = 0;
    for ( int y = y0; y < y0 + RF_CELL_SIDE && y < pieces->height; ++y )
    {
        for ( int x = x0; x < x0 + RF_CELL_SIDE && x < pieces->width; ++x )
            pixel[count++] = y * pieces->width + x;
    }
    return count;
}

// The slots of the cells of a frame; −1: in no piece.
static inline const int32_t* rf_frame_slots( const RfTestPieces* pieces, int frame )
{
    return pieces->slot + (size_t)frame * (size_t)pieces->across * (size_t)pieces->down;
}

// Bytes that pieces of so many frames take at most, whose films have `pixels` pixels.
size_t rf_test_pieces_bytes( int frames, size_t pixels );

// The same camera with the film from pixel (x, y) on.
RfEye rf_crop_eye( const RfEye* eye, int x, int y, int width, int height );

// Windows of the picture in which an estimator is tried that makes a picture of all that it traces, and so renders no
// pieces (render/pieces.h): cameras with a smaller film, in the resolution of the render.

#define RF_CROPS 7

// Makes RF_CROPS windows in frames spread over `frames`, which trace about `pixels` pixels for each of these frames, and the
// pieces that are measured there: all but a margin, where tiles and differences end. *crops is NULL where the windows would
// be most of the picture; else free it, and the pieces with rf_destroy_test_pieces. Fails with RF_ERROR_MEMORY.
RfResult rf_choose_crops( const RfEye* eyes, int frames, double pixels, uint64_t seed, RfEye** crops, RfTestPieces* pieces,
                          RfError* error );

#endif
