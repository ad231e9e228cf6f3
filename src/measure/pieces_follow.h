// Where the surfaces of pieces are seen in other frames.
#ifndef REFRAME_MEASURE_PIECES_FOLLOW_H
#define REFRAME_MEASURE_PIECES_FOLLOW_H

#include "measure/pieces.h"
#include "scene/lens.h"

#define RF_PIECE_POINTS 1024 // followed at once

// Points of a frame: surface points, or directions to the sky.
typedef struct RfPiecePoints
{
    int count;
    float o[3][RF_PIECE_POINTS], d[3][RF_PIECE_POINTS], x[3][RF_PIECE_POINTS];
    bool sky[RF_PIECE_POINTS];
    int piece[RF_PIECE_POINTS];
    uint32_t triangle[RF_PIECE_POINTS];
    float u[RF_PIECE_POINTS], v[RF_PIECE_POINTS];
} RfPiecePoints;

typedef struct RfPieceChooser
{
    const RfTracer* tracer;
    const RfEye* eyes;
    bool blurred;      // some of them
    RfLensSample lens; // where the points are followed from
    RfTestPieces* pieces;
    uint8_t* around; // the same with the cells beside them, whose samples a pixel filter spreads to them; NULL: none
    uint8_t* target; // by frame and cell: 1 + the piece; 0: none
    RfPiecePoints points;
} RfPieceChooser;

static inline size_t rf_film_cells( const RfTestPieces* pieces ) { return (size_t)pieces->across * (size_t)pieces->down; }

// Marks where the pieces of a frame are seen in all others, or would be if nothing were before them: as pieces there, or
// as to be traced.
void rf_follow_pieces( RfPieceChooser* chooser, int frame, bool as_pieces );

#endif
