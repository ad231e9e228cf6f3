#include "measure/pieces.h"

#include "base/random.h"
#include "film/pixel_filter.h"
#include "measure/pieces_follow.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LEAST_SIDE 16 // of a block, pixels
#define AROUND 14.0   // pixels that are traced around a block, in all: cells and tiles that reach beyond it
#define ALL 0.6       // of a picture: as well the whole of it
#define TRIES 3       // at pieces from which no more than
#define FEW 3         // pieces are enough
#define TOO_MUCH 1.3  // times the pixels wanted follow
#define GRID 8        // pieces of a whole picture, across and down

static int clamp( int value, int low, int high ) { return value < low ? low : value > high ? high : value; }

static double draw( uint64_t* state )
{
    *state = rf_mix64( *state );
    return (double)( *state >> 11 ) * 0x1p-53;
}

// Where a block of `side` cells begins in part `i` of `parts` of `cells` cells.
static int place( int cells, int i, int parts, int side, double random )
{
    int first = (int)( (int64_t)cells * i / parts ), end = (int)( (int64_t)cells * ( i + 1 ) / parts );
    int room = end - first - side;
    return clamp( room > 0 ? first + (int)( random * ( room + 1 ) ) : first + room / 2, 0, cells > side ? cells - side : 0 );
}

// Marks blocks in the centre frame; false if they would be most of the picture.
static bool place_blocks( RfPieceChooser* c, int centre, double pixels, uint64_t seed )
{
    RfTestPieces* p = c->pieces;
    double side = LEAST_SIDE, each = ( side + AROUND ) * ( side + AROUND ), aspect = (double)p->width / p->height;
    if ( pixels > ALL * p->width * p->height )
        return false;
    if ( pixels > RF_MAX_PIECES * each )
        side = sqrt( pixels / RF_MAX_PIECES ) - AROUND;
    double count = fmin( fmax( pixels / ( ( side + AROUND ) * ( side + AROUND ) ), 1.0 ), RF_MAX_PIECES );
    int columns = clamp( (int)floor( sqrt( count * aspect ) + 0.5 ), 1, p->across );
    int rows = clamp( (int)floor( count / columns + 0.5 ), 1, p->down );
    columns = columns * rows > RF_MAX_PIECES ? RF_MAX_PIECES / rows : columns;
    int cells = (int)floor( side / RF_CELL_SIDE + 0.5 );
    uint8_t* target = c->target + (size_t)centre * rf_film_cells( p );
    uint64_t state = rf_mix64( seed );
    p->count = columns * rows;
    for ( int i = 0; i < p->count; ++i )
    {
        int x0 = place( p->across, i % columns, columns, cells, draw( &state ) );
        int y0 = place( p->down, i / columns, rows, cells, draw( &state ) );
        for ( int y = y0; y < y0 + cells && y < p->down; ++y )
        {
            for ( int x = x0; x < x0 + cells && x < p->across; ++x )
                target[(size_t)y * (size_t)p->across + (size_t)x] = (uint8_t)( i + 1 );
        }
    }
    return true;
}

// The whole pictures, cut into pieces by a grid.
static void take_everything( RfPieceChooser* c )
{
    RfTestPieces* p = c->pieces;
    int columns = p->across < GRID ? p->across : GRID, rows = p->down < GRID ? p->down : GRID;
    free( p->traced );
    p->traced = NULL;
    p->count = columns * rows;
    p->pixels = (double)p->width * p->height;
    for ( size_t i = 0; i < rf_film_cells( p ) * (size_t)p->frames; ++i )
    {
        int cell = (int)( i % rf_film_cells( p ) ), x = cell % p->across, y = cell / p->across;
        c->target[i] = (uint8_t)( 1 + y * rows / p->down * columns + x * columns / p->across );
    }
}

static void count_traced( RfTestPieces* p )
{
    int32_t pixel[RF_CELL_PIXELS];
    double pixels = 0.0;
    for ( size_t i = 0; i < rf_film_cells( p ) * (size_t)p->frames; ++i )
        pixels += p->traced[i] != 0 ? rf_cell_pixels( p, (int)( i % rf_film_cells( p ) ), pixel ) : 0;
    p->pixels = pixels / p->frames;
}

static void number_slots( const RfPieceChooser* c )
{
    RfTestPieces* p = c->pieces;
    int32_t slots = 0;
    for ( int f = 0; f < p->frames; ++f )
    {
        p->first_slot[f] = slots;
        for ( size_t i = (size_t)f * rf_film_cells( p ); i < (size_t)( f + 1 ) * rf_film_cells( p ); ++i )
        {
            p->slot[i] = c->target[i] != 0 ? slots : -1;
            if ( c->target[i] != 0 )
                p->piece[slots++] = (uint8_t)( c->target[i] - 1 );
        }
    }
    p->first_slot[p->frames] = slots;
}

// Adds to the pieces of a frame the cells beside them: no filter reaches beyond these.
static void grow_pieces( RfPieceChooser* c, int frame )
{
    _Static_assert( RF_FILTER_REACH <= RF_CELL_SIDE, "filters reach no farther than one cell" );
    const RfTestPieces* p = c->pieces;
    const uint8_t* target = c->target + (size_t)frame * rf_film_cells( p );
    uint8_t* around = c->around + (size_t)frame * rf_film_cells( p );
    memset( around, 0, rf_film_cells( p ) );
    for ( size_t cell = 0; cell < rf_film_cells( p ); ++cell )
    {
        int x = (int)( cell % (size_t)p->across ), y = (int)( cell / (size_t)p->across );
        for ( int k = 0; k < 9 && target[cell] != 0; ++k )
        {
            int nx = clamp( x + k % 3 - 1, 0, p->across - 1 ), ny = clamp( y + k / 3 - 1, 0, p->down - 1 );
            around[(size_t)ny * (size_t)p->across + (size_t)nx] = target[cell];
        }
    }
}

// Chooses pieces of an area from which about `pixels` pixels follow; returns how many do.
static double try_pieces( RfPieceChooser* c, int centre, double pixels, uint64_t seed )
{
    RfTestPieces* p = c->pieces;
    size_t bytes = rf_film_cells( p ) * (size_t)p->frames;
    memset( c->target, 0, bytes );
    if ( !place_blocks( c, centre, pixels, seed ) )
    {
        take_everything( c );
        return p->pixels;
    }
    rf_follow_pieces( c, centre, true );
    uint8_t *pieces_only = c->target, *traced = c->around != NULL ? c->around : c->target;
    for ( int f = 0; f < p->frames && c->around != NULL; ++f )
        grow_pieces( c, f );
    memcpy( p->traced, traced, bytes );
    c->target = traced;
    for ( int f = 0; f < p->frames; ++f )
        rf_follow_pieces( c, f, false );
    c->target = pieces_only;
    count_traced( p );
    return p->pixels;
}

// Where the camera moves fast, much more is traced than the pieces themselves: then fewer pieces are taken.
static void choose( RfPieceChooser* c, int centre, double pixels, uint64_t seed )
{
    double wanted = pixels;
    rf_set_float_mode();
    for ( int i = 0; i < TRIES; ++i )
    {
        double traced = try_pieces( c, centre, wanted, seed );
        if ( traced < TOO_MUCH * pixels || c->pieces->count <= FEW || c->pieces->traced == NULL )
            break;
        wanted *= pixels / traced;
    }
    number_slots( c );
}

RfResult rf_choose_pieces( const RfTracer* tracer, const RfEye* eyes, int frames, int centre, double pixels, bool filtered,
                           uint64_t seed, RfTestPieces* p, RfError* error )
{
    *p = ( RfTestPieces ){ .width = eyes->width, .height = eyes->height, .frames = frames };
    p->across = rf_cells_along( p->width );
    p->down = rf_cells_along( p->height );
    size_t cells = rf_film_cells( p ) * (size_t)frames;
    p->traced = calloc( cells, 1 );
    p->slot = malloc( cells * sizeof *p->slot );
    p->first_slot = malloc( (size_t)( frames + 1 ) * sizeof *p->first_slot );
    p->piece = malloc( cells );
    RfPieceChooser* c = calloc( 1, sizeof *c );
    uint8_t *target = calloc( cells, 1 ), *around = calloc( cells, 1 );
    bool enough = p->traced != NULL && p->slot != NULL && p->first_slot != NULL && p->piece != NULL && c != NULL &&
                  target != NULL && around != NULL;
    if ( enough )
    {
        c->tracer = tracer;
        c->eyes = eyes;
        c->blurred = rf_any_blurred( eyes, frames );
        c->pieces = p;
        c->target = target;
        c->around = filtered ? around : NULL;
        choose( c, centre, pixels, seed );
    }
    free( target );
    free( around );
    free( c );
    return enough ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "no memory left for pieces of %d frames", frames );
}

void rf_destroy_test_pieces( RfTestPieces* p )
{
    free( p->traced );
    free( p->slot );
    free( p->first_slot );
    free( p->piece );
    *p = ( RfTestPieces ){ 0 };
}

RfPieces rf_pieces_from( const RfTestPieces* p, int first )
{
    return ( RfPieces ){ p->across, p->down, p->traced + (size_t)first * rf_film_cells( p ) };
}

size_t rf_test_pieces_bytes( int frames, size_t pixels )
{
    // traced, slot and piece of a cell
    return (size_t)frames * ( pixels / RF_CELL_PIXELS + 1 ) * ( 2 + sizeof( int32_t ) );
}
