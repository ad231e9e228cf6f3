// Clears and combines the traced pixels of a render of pieces, row by row of each cell.
#include "render/pieces.h"

// A row of a cell: its pixels [first, first + count) of the frame, none where it is not traced.
typedef struct Run
{
    size_t first, count;
} Run;

static Run traced_run( const RfPieces* pieces, int frame, const RfFilm* film, int y, int x )
{
    int left = film->width - x;
    bool traced = rf_is_traced( pieces, rf_frame_cells( pieces, frame ), x, y );
    return ( Run ){ (size_t)y * (size_t)film->width + (size_t)x, !traced               ? 0
                                                                 : left < RF_CELL_SIDE ? (size_t)left
                                                                                       : RF_CELL_SIDE };
}

void rf_clear_traced( const RfPieces* pieces, int frame, RfFilm* film )
{
    rf_clear_film_counts( film );
    for ( int y = 0; y < film->height; ++y )
    {
        for ( int x = 0; x < film->width; x += RF_CELL_SIDE )
        {
            Run run = traced_run( pieces, frame, film, y, x );
            rf_clear_film_pixels( film, run.first, run.count );
        }
    }
}

void rf_combine_traced( const RfPieces* pieces, int frame, const RfFilm* film, RfNormalize normalize, float* rgb, float* weight )
{
    for ( int y = 0; y < film->height; ++y )
    {
        for ( int x = 0; x < film->width; x += RF_CELL_SIDE )
        {
            Run run = traced_run( pieces, frame, film, y, x );
            rf_combine_film_pixels( film, normalize, run.first, run.count, rgb, weight );
        }
    }
}
