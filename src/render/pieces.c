// Clears and combines the traced pixels of a render of pieces, run by run.
#include "render/pieces.h"

// Calls `visit` with each run of traced pixels: the first and their count.
typedef void VisitFn( void* user, size_t first, size_t count );

static void visit_traced( const RfPieces* pieces, int frame, int width, int height, VisitFn* visit, void* user )
{
    const uint8_t* cells = rf_frame_cells( pieces, frame );
    for ( int y = 0; y < height; ++y )
    {
        for ( int x = 0; x < width; )
        {
            int end = x;
            while ( end < width && rf_is_traced( pieces, cells, end, y ) )
                end = ( end / RF_CELL_SIDE + 1 ) * RF_CELL_SIDE;
            end = end < width ? end : width;
            if ( end > x )
                visit( user, (size_t)y * (size_t)width + (size_t)x, (size_t)( end - x ) );
            x = end > x ? end : ( x / RF_CELL_SIDE + 1 ) * RF_CELL_SIDE;
        }
    }
}

static void clear( void* user, size_t first, size_t count ) { rf_clear_film_pixels( user, first, count ); }

void rf_clear_traced( const RfPieces* pieces, int frame, RfFilm* film )
{
    rf_clear_film_counts( film );
    visit_traced( pieces, frame, film->width, film->height, clear, film );
}

typedef struct Combination
{
    const RfFilm* film;
    RfNormalize normalize;
    float *rgb, *weight;
} Combination;

static void combine_run( void* user, size_t first, size_t count )
{
    const Combination* c = user;
    rf_combine_film_pixels( c->film, c->normalize, first, count, c->rgb, c->weight );
}

void rf_combine_traced( const RfPieces* pieces, int frame, const RfFilm* film, RfNormalize normalize, float* rgb, float* weight )
{
    Combination c = { .film = film, .normalize = normalize, .rgb = rgb, .weight = weight };
    visit_traced( pieces, frame, film->width, film->height, combine_run, &c );
}
