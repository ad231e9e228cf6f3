#include "measure/crops.h"

#include "base/random.h"

#include <math.h>
#include <stdlib.h>

#define LEAST_SIDE 32 // of a window, pixels
#define MOST 0.6      // of the pictures: as well the whole of them
#define ACROSS 3      // pieces of a window
#define DOWN 3

_Static_assert( RF_CROPS* ACROSS* DOWN <= RF_MAX_PIECES, "pieces of all windows" );

// The next place of a sequence that fills a square evenly (Roberts, The Unreasonable Effectiveness of Quasirandom Sequences).
static void next_place( double at[2] )
{
    static const double s_step[2] = { 0.7548776662466927, 0.5698402909980532 };
    for ( int k = 0; k < 2; ++k )
        at[k] = fmod( at[k] + s_step[k], 1.0 );
}

static int whole_cells( double side, int most )
{
    int pixels = (int)( fmax( side, LEAST_SIDE ) / RF_CELL_SIDE + 0.5 ) * RF_CELL_SIDE;
    return pixels < most ? pixels : most;
}

// The same eye with the film from pixel (x, y) on.
static RfEye crop( const RfEye* eye, int x, int y, int width, int height )
{
    RfEye out = *eye;
    float* axes[3][2] = { { &out.axis_x, &out.axis_y },
                          { &out.open.axis_x, &out.open.axis_y },
                          { &out.close.axis_x, &out.close.axis_y } };
    out.width = width;
    out.height = height;
    for ( int k = 0; k < 3; ++k )
    {
        *axes[k][0] -= (float)x;
        *axes[k][1] -= (float)y;
    }
    return out;
}

static void number_slots( RfTestPieces* p )
{
    int32_t slots = 0;
    int cells = p->across * p->down;
    for ( int f = 0; f < p->frames; ++f )
    {
        p->first_slot[f] = slots;
        for ( int i = 0; i < cells; ++i )
        {
            int x = i % p->across, y = i / p->across;
            bool inside = x > 0 && y > 0 && x + 1 < p->across && y + 1 < p->down;
            p->slot[f * cells + i] = inside ? slots : -1;
            if ( inside )
                p->piece[slots++] = (uint8_t)( ( f * DOWN + y * DOWN / p->down ) * ACROSS + x * ACROSS / p->across );
        }
    }
    p->first_slot[p->frames] = slots;
}

static RfResult make_pieces( int width, int height, RfTestPieces* p, RfError* error )
{
    *p = ( RfTestPieces ){ .width = width, .height = height, .frames = RF_CROPS, .count = RF_CROPS * ACROSS * DOWN };
    p->across = rf_cells_along( width );
    p->down = rf_cells_along( height );
    p->pixels = (double)width * height;
    size_t cells = (size_t)p->across * (size_t)p->down * RF_CROPS;
    p->slot = malloc( cells * sizeof *p->slot );
    p->first_slot = malloc( ( RF_CROPS + 1 ) * sizeof *p->first_slot );
    p->piece = malloc( cells );
    if ( p->slot == NULL || p->first_slot == NULL || p->piece == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for pieces of %d frames", RF_CROPS );
    number_slots( p );
    return RF_OK;
}

RfResult rf_choose_crops( const RfEye* eyes, int frames, double pixels, uint64_t seed, RfEye** crops, RfTestPieces* pieces,
                          RfError* error )
{
    double film = (double)eyes->width * eyes->height, each = pixels * frames / RF_CROPS;
    double side = sqrt( each * eyes->width / eyes->height );
    int width = whole_cells( side, eyes->width ), height = whole_cells( each / side, eyes->height );
    *crops = NULL;
    if ( (double)width * height * RF_CROPS > MOST * film * frames )
        return RF_OK;
    RfResult result = make_pieces( width, height, pieces, error );
    if ( result != RF_OK )
        return result;
    *crops = malloc( RF_CROPS * sizeof **crops );
    if ( *crops == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for windows of %d frames", frames );
    uint64_t random = rf_mix64( seed );
    double at[2] = { (double)( random >> 32 ) * 0x1p-32, (double)( random & 0xffffffffu ) * 0x1p-32 };
    for ( int i = 0; i < RF_CROPS; ++i )
    {
        next_place( at );
        int x = (int)( at[0] * ( eyes->width - width + 1 ) ), y = (int)( at[1] * ( eyes->height - height + 1 ) );
        ( *crops )[i] = crop( eyes + i * frames / RF_CROPS, x, y, width, height );
    }
    return RF_OK;
}
