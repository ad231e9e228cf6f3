#include "measure/pieces.h"

#include "base/random.h"
#include "scene/pinhole.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LEAST_SIDE 16     // of a block, pixels
#define AROUND 14.0       // pixels that are traced around a block, in all: cells and tiles that reach beyond it
#define ALL 0.6           // of a picture: as well the whole of it
#define TRIES 3           // at pieces from which no more than
#define FEW 3             // pieces are enough
#define TOO_MUCH 1.3      // times the pixels wanted follow
#define STEP 2            // pixels between the points that are followed to other frames
#define REACH 1.0f        // pixels around where such a point is seen that belong to it
#define POINTS 1024       // followed at once
#define GRID 8            // pieces of a whole picture, across and down

// Points of a frame: surface points, or directions to the sky.
typedef struct Points
{
    int count;
    float o[3][POINTS], d[3][POINTS], x[3][POINTS];
    bool sky[POINTS];
    int piece[POINTS];
    uint32_t triangle[POINTS];
    float u[POINTS], v[POINTS];
} Points;

typedef struct Chooser
{
    const RfTracer* tracer;
    const RfEye* eyes;
    RfTestPieces* pieces;
    uint8_t* target; // by frame and cell: 1 + the piece; 0: none
    Points points;
} Chooser;

static size_t film_cells( const RfTestPieces* p ) { return (size_t)p->across * (size_t)p->down; }

static RfVec3 point_of( float ( *a )[POINTS], int i ) { return rf_vec3( a[0][i], a[1][i], a[2][i] ); }

static void put_point( float ( *a )[POINTS], int i, RfVec3 x )
{
    a[0][i] = x.x;
    a[1][i] = x.y;
    a[2][i] = x.z;
}

static void trace_points( const Chooser* c, Points* p )
{
    const float *o[3] = { p->o[0], p->o[1], p->o[2] }, *d[3] = { p->d[0], p->d[1], p->d[2] };
    rf_trace_nearest( c->tracer, p->count, o, d, false, p->triangle, p->u, p->v );
}

static RfVec3 hit_point( const Points* p, const RfTriangleRecord* r, int i )
{
    return rf_madd( rf_madd( r->p0, r->e1, p->u[i] ), r->e2, p->v[i] );
}

// Finds what the rays hit. What is seen in a flat mirror is seen as if it were behind it.
static void find_points( Chooser* c, const RfEye* eye )
{
    Points* p = &c->points;
    const RfTriangleRecord* records = rf_tracer_triangles( c->tracer );
    float far[POINTS];
    trace_points( c, p );
    for ( int i = 0; i < p->count; ++i )
    {
        RfVec3 d = point_of( p->d, i );
        far[i] = -1.0f;
        p->sky[i] = p->triangle[i] == RF_MISS;
        put_point( p->x, i, d );
        if ( p->sky[i] )
            continue;
        const RfTriangleRecord* r = records + p->triangle[i];
        RfVec3 x = hit_point( p, r, i ), ng = rf_dot( r->ng, d ) < 0.0f ? r->ng : rf_scale( r->ng, -1.0f );
        put_point( p->x, i, x );
        if ( r->mirror == RF_NO_MIRROR )
            continue;
        RfVec3 way = rf_sub( x, rf_pinhole_origin( eye ) );
        far[i] = sqrtf( rf_dot( way, way ) );
        put_point( p->o, i, rf_madd( x, ng, r->offset ) );
        put_point( p->d, i, rf_madd( d, ng, -2.0f * rf_dot( d, ng ) ) );
    }
    trace_points( c, p );
    for ( int i = 0; i < p->count; ++i )
    {
        if ( far[i] < 0.0f || p->triangle[i] == RF_MISS )
            continue;
        RfVec3 first = point_of( p->x, i ), second = hit_point( p, records + p->triangle[i], i );
        RfVec3 way = rf_sub( first, rf_pinhole_origin( eye ) ), more = rf_sub( second, first );
        float all = far[i] + sqrtf( rf_dot( more, more ) );
        put_point( p->x, i, rf_madd( rf_pinhole_origin( eye ), way, all / far[i] ) );
    }
}

// Marks the cells of a frame in which a point is seen, or would be if nothing were before it.
static void mark_point( const RfTestPieces* pieces, const RfEye* eye, RfVec3 x, bool sky, uint8_t value, uint8_t* cells )
{
    float at[2];
    float depth = rf_pinhole_position( eye, sky ? x : rf_sub( x, rf_pinhole_origin( eye ) ), at );
    float fx = 0.5f * (float)eye->width + at[0], fy = 0.5f * (float)eye->height - at[1];
    if ( !( depth > 0.0f ) || !( fx > -REACH && fx < (float)eye->width + REACH && fy > -REACH && fy < (float)eye->height + REACH ) )
        return;
    for ( int k = 0; k < 4; ++k )
    {
        float kx = fx + ( k % 2 == 0 ? -REACH : REACH ), ky = fy + ( k < 2 ? -REACH : REACH );
        int cx = (int)floorf( kx / RF_CELL_SIDE ), cy = (int)floorf( ky / RF_CELL_SIDE );
        if ( cx < 0 || cy < 0 || cx >= pieces->across || cy >= pieces->down )
            continue;
        uint8_t* cell = cells + (size_t)cy * (size_t)pieces->across + (size_t)cx;
        *cell = *cell == 0 ? value : *cell;
    }
}

// Marks what the points are seen as in all other frames: as part of their pieces, or as to be traced.
static void follow_points( Chooser* c, int frame, bool as_pieces )
{
    RfTestPieces* pieces = c->pieces;
    Points* p = &c->points;
    find_points( c, c->eyes + frame );
    for ( int k = 0; k < pieces->frames; ++k )
    {
        uint8_t* cells = ( as_pieces ? c->target : pieces->traced ) + (size_t)k * film_cells( pieces );
        for ( int i = 0; i < p->count && k != frame; ++i )
            mark_point( pieces, c->eyes + k, point_of( p->x, i ), p->sky[i], as_pieces ? (uint8_t)( p->piece[i] + 1 ) : 1, cells );
    }
    p->count = 0;
}

// Follows the pieces of a frame.
static void follow_frame( Chooser* c, int frame, bool as_pieces )
{
    RfTestPieces* pieces = c->pieces;
    const RfEye* eye = c->eyes + frame;
    const uint8_t* target = c->target + (size_t)frame * film_cells( pieces );
    Points* p = &c->points;
    float inverse_focal = 1.0f / eye->focal;
    int32_t pixel[RF_CELL_PIXELS];
    p->count = 0;
    for ( size_t cell = 0; cell < film_cells( pieces ); ++cell )
    {
        int count = target[cell] != 0 ? rf_cell_pixels( pieces, (int)cell, pixel ) : 0;
        for ( int k = 0; k < count; ++k )
        {
            int x = pixel[k] % eye->width, y = pixel[k] / eye->width;
            if ( x % STEP != 0 || y % STEP != 0 )
                continue;
            put_point( p->o, p->count, rf_pinhole_origin( eye ) );
            put_point( p->d, p->count, rf_pinhole_ray( eye, inverse_focal, x, y, 0.5f * STEP, 0.5f * STEP ) );
            p->piece[p->count++] = target[cell] - 1;
        }
        if ( p->count > POINTS - RF_CELL_PIXELS )
            follow_points( c, frame, as_pieces );
    }
    follow_points( c, frame, as_pieces );
}

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
static bool place_blocks( Chooser* c, int centre, double pixels, uint64_t seed )
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
    uint8_t* target = c->target + (size_t)centre * film_cells( p );
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
static void take_everything( Chooser* c )
{
    RfTestPieces* p = c->pieces;
    int columns = p->across < GRID ? p->across : GRID, rows = p->down < GRID ? p->down : GRID;
    free( p->traced );
    p->traced = NULL;
    p->count = columns * rows;
    p->pixels = (double)p->width * p->height;
    for ( size_t i = 0; i < film_cells( p ) * (size_t)p->frames; ++i )
    {
        int cell = (int)( i % film_cells( p ) ), x = cell % p->across, y = cell / p->across;
        c->target[i] = (uint8_t)( 1 + y * rows / p->down * columns + x * columns / p->across );
    }
}

static void count_traced( RfTestPieces* p )
{
    int32_t pixel[RF_CELL_PIXELS];
    double pixels = 0.0;
    for ( size_t i = 0; i < film_cells( p ) * (size_t)p->frames; ++i )
        pixels += p->traced[i] != 0 ? rf_cell_pixels( p, (int)( i % film_cells( p ) ), pixel ) : 0;
    p->pixels = pixels / p->frames;
}

static void number_slots( const Chooser* c )
{
    RfTestPieces* p = c->pieces;
    int32_t slots = 0;
    for ( int f = 0; f < p->frames; ++f )
    {
        p->first_slot[f] = slots;
        for ( size_t i = (size_t)f * film_cells( p ); i < (size_t)( f + 1 ) * film_cells( p ); ++i )
        {
            p->slot[i] = c->target[i] != 0 ? slots : -1;
            if ( c->target[i] != 0 )
                p->piece[slots++] = (uint8_t)( c->target[i] - 1 );
        }
    }
    p->first_slot[p->frames] = slots;
}

// Chooses pieces of an area from which about `pixels` pixels follow; returns how many do.
static double try_pieces( Chooser* c, int centre, double pixels, uint64_t seed )
{
    RfTestPieces* p = c->pieces;
    size_t bytes = film_cells( p ) * (size_t)p->frames;
    memset( c->target, 0, bytes );
    if ( !place_blocks( c, centre, pixels, seed ) )
    {
        take_everything( c );
        return p->pixels;
    }
    follow_frame( c, centre, true );
    memcpy( p->traced, c->target, bytes );
    for ( int f = 0; f < p->frames; ++f )
        follow_frame( c, f, false );
    count_traced( p );
    return p->pixels;
}

// Where the camera moves fast, much more is traced than the pieces themselves: then fewer pieces are taken.
static void choose( Chooser* c, int centre, double pixels, uint64_t seed )
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

RfResult rf_choose_pieces( const RfTracer* tracer, const RfEye* eyes, int frames, int centre, double pixels, uint64_t seed,
                           RfTestPieces* p, RfError* error )
{
    *p = ( RfTestPieces ){ .width = eyes->width, .height = eyes->height, .frames = frames };
    p->across = rf_cells_along( p->width );
    p->down = rf_cells_along( p->height );
    size_t cells = film_cells( p ) * (size_t)frames;
    p->traced = calloc( cells, 1 );
    p->slot = malloc( cells * sizeof *p->slot );
    p->first_slot = malloc( (size_t)( frames + 1 ) * sizeof *p->first_slot );
    p->piece = malloc( cells );
    Chooser* c = calloc( 1, sizeof *c );
    uint8_t* target = calloc( cells, 1 );
    bool enough =
        p->traced != NULL && p->slot != NULL && p->first_slot != NULL && p->piece != NULL && c != NULL && target != NULL;
    if ( enough )
    {
        c->tracer = tracer;
        c->eyes = eyes;
        c->pieces = p;
        c->target = target;
        choose( c, centre, pixels, seed );
    }
    free( target );
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
    return ( RfPieces ){ p->across, p->down, p->traced + (size_t)first * film_cells( p ) };
}

size_t rf_test_pieces_bytes( int frames, size_t pixels )
{
    // traced, slot and piece of a cell
    return (size_t)frames * ( pixels / RF_CELL_PIXELS + 1 ) * ( 2 + sizeof( int32_t ) );
}
