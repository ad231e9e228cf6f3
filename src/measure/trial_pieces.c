// Chooses the pieces of the picture that a trial renders, by stratified sampling and traced points.
#include "measure/trial_pieces.h"

#include "base/random.h"
#include "base/try.h"
#include "film/pixel_filter.h"
#include "scene/projection.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PIECE_POINTS 1024 // followed at once

// Points of a frame: surface points, or directions to the sky.
typedef struct PiecePoints
{
    int count;
    float o[3][PIECE_POINTS], d[3][PIECE_POINTS], x[3][PIECE_POINTS];
    bool sky[PIECE_POINTS];
    int piece[PIECE_POINTS];
    uint32_t triangle[PIECE_POINTS];
    float u[PIECE_POINTS], v[PIECE_POINTS];
} PiecePoints;

typedef struct PieceChooser
{
    const RfTracer* tracer;
    const RfEye* eyes;
    bool blurred;      // some of them
    RfLensSample lens; // where the points are followed from
    RfTestPieces* pieces;
    uint8_t* around; // the same with the cells beside them, whose samples a pixel filter spreads to them; NULL: none
    uint8_t* target; // by frame and cell: 1 + the piece; 0: none
    PiecePoints points;
} PieceChooser;

static inline size_t film_cells( const RfTestPieces* pieces ) { return (size_t)pieces->across * (size_t)pieces->down; }

// Room for pieces of films; false where memory ran out.
static bool make_room( int width, int height, int frames, RfTestPieces* p )
{
    *p = ( RfTestPieces ){ .width = width, .height = height, .frames = frames, .pixels = (double)width * height };
    p->across = rf_cells_along( width );
    p->down = rf_cells_along( height );
    size_t cells = film_cells( p ) * (size_t)frames;
    p->slot = malloc( cells * sizeof *p->slot );
    p->first_slot = malloc( (size_t)( frames + 1 ) * sizeof *p->first_slot );
    p->piece = malloc( cells );
    return p->slot != NULL && p->first_slot != NULL && p->piece != NULL;
}

// By `target`, which has 1 + the piece of each frame and cell; 0: none.
static void number_slots( RfTestPieces* p, const uint8_t* target )
{
    int32_t slots = 0;
    for ( int f = 0; f < p->frames; ++f )
    {
        p->first_slot[f] = slots;
        for ( size_t i = (size_t)f * film_cells( p ); i < (size_t)( f + 1 ) * film_cells( p ); ++i )
        {
            p->slot[i] = target[i] != 0 ? slots : -1;
            if ( target[i] != 0 )
                p->piece[slots++] = (uint8_t)( target[i] - 1 );
        }
    }
    p->first_slot[p->frames] = slots;
}

static RfResult fail_memory( int frames, RfError* error )
{
    return rf_fail( error, RF_ERROR_MEMORY, "out of memory for pieces of %d frames", frames );
}

#define LEAST_CROP_SIDE 32 // of a window, pixels
#define MOST 0.6           // of the pictures: as well the whole of them
#define ACROSS 3           // pieces of a window
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
    int pixels = (int)( fmax( side, LEAST_CROP_SIDE ) / RF_CELL_SIDE + 0.5 ) * RF_CELL_SIDE;
    return pixels < most ? pixels : most;
}

RfEye rf_crop_eye( const RfEye* eye, int x, int y, int width, int height )
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

// All cells of the windows but those at their borders.
static RfResult cut_crops( int width, int height, RfTestPieces* p, RfError* error )
{
    bool enough = make_room( width, height, RF_CROPS, p );
    size_t cells = film_cells( p );
    uint8_t* target = calloc( cells, RF_CROPS );
    p->count = RF_CROPS * ACROSS * DOWN;
    for ( size_t i = 0; i < cells * RF_CROPS && enough && target != NULL; ++i )
    {
        int f = (int)( i / cells ), x = (int)( i % cells ) % p->across, y = (int)( i % cells ) / p->across;
        if ( x > 0 && y > 0 && x + 1 < p->across && y + 1 < p->down )
            target[i] = (uint8_t)( 1 + ( f * DOWN + y * DOWN / p->down ) * ACROSS + x * ACROSS / p->across );
    }
    enough = enough && target != NULL;
    if ( enough )
        number_slots( p, target );
    free( target );
    return enough ? RF_OK : fail_memory( RF_CROPS, error );
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
    RF_TRY( cut_crops( width, height, pieces, error ) );
    *crops = malloc( RF_CROPS * sizeof **crops );
    if ( *crops == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for windows of %d frames", frames );
    uint64_t random = rf_mix64( seed );
    double at[2] = { (double)( random >> 32 ) * 0x1p-32, (double)( random & 0xffffffffu ) * 0x1p-32 };
    for ( int i = 0; i < RF_CROPS; ++i )
    {
        next_place( at );
        int x = (int)( at[0] * ( eyes->width - width + 1 ) ), y = (int)( at[1] * ( eyes->height - height + 1 ) );
        ( *crops )[i] = rf_crop_eye( eyes + i * frames / RF_CROPS, x, y, width, height );
    }
    return RF_OK;
}

#define STEP 2     // pixels between the points that are followed to other frames
#define REACH 1.0f // pixels around where such a point is seen that belong to it
// With a lens or a shutter points are followed from so many places of these, and reach farther.
#define LENS_SAMPLES 8
#define BLURRED_REACH 3.0f

static RfVec3 point_of( float ( *a )[PIECE_POINTS], int i ) { return rf_vec3( a[0][i], a[1][i], a[2][i] ); }

static void put_point( float ( *a )[PIECE_POINTS], int i, RfVec3 x )
{
    a[0][i] = x.x;
    a[1][i] = x.y;
    a[2][i] = x.z;
}

// What moves is left out: no other frame has samples for it, but for what is behind it.
static void trace_points( const PieceChooser* c, PiecePoints* p )
{
    const float *o[3] = { p->o[0], p->o[1], p->o[2] }, *d[3] = { p->d[0], p->d[1], p->d[2] };
    rf_trace_nearest( c->tracer, p->count, o, d, false, p->triangle, p->u, p->v );
}

static RfVec3 hit_point( const PiecePoints* p, const RfTriangleRecord* r, int i )
{
    return rf_madd( rf_madd( r->p0, r->e1, p->u[i] ), r->e2, p->v[i] );
}

// Finds what the rays hit. What is seen in a flat mirror is seen as if it were behind it.
static void find_points( PieceChooser* c, const RfEye* eye )
{
    PiecePoints* p = &c->points;
    RfTriangleRecord place;
    float far[PIECE_POINTS];
    trace_points( c, p );
    for ( int i = 0; i < p->count; ++i )
    {
        RfVec3 d = point_of( p->d, i );
        far[i] = -1.0f;
        p->sky[i] = p->triangle[i] == RF_MISS;
        put_point( p->x, i, d );
        if ( p->sky[i] )
            continue;
        const RfTriangleRecord* r = rf_triangle_record( c->tracer, p->triangle[i], &place );
        RfVec3 x = hit_point( p, r, i ), ng = rf_dot( r->ng, d ) < 0.0f ? r->ng : rf_scale( r->ng, -1.0f );
        put_point( p->x, i, x );
        if ( r->mirror == RF_NO_MIRROR )
            continue;
        RfVec3 way = rf_eye_way( eye, x );
        far[i] = sqrtf( rf_dot( way, way ) );
        put_point( p->o, i, rf_madd( x, ng, r->offset ) );
        put_point( p->d, i, rf_madd( d, ng, -2.0f * rf_dot( d, ng ) ) );
    }
    trace_points( c, p );
    for ( int i = 0; i < p->count; ++i )
    {
        if ( far[i] < 0.0f || p->triangle[i] == RF_MISS )
            continue;
        RfVec3 first = point_of( p->x, i ), second = hit_point( p, rf_triangle_record( c->tracer, p->triangle[i], &place ), i );
        RfVec3 way = rf_eye_way( eye, first ), more = rf_sub( second, first );
        float all = far[i] + sqrtf( rf_dot( more, more ) );
        put_point( p->x, i, rf_madd( rf_eye_start( eye, first ), way, all / far[i] ) );
    }
}

// Marks the cells of a frame in which a point is seen, or would be if nothing were before it.
static void mark_point( const RfTestPieces* pieces, const RfEye* eye, RfVec3 x, bool sky, float reach, uint8_t value,
                        uint8_t* cells )
{
    float at[2];
    bool seen = rf_eye_position( eye, x, sky, at );
    float fx = 0.5f * (float)eye->width + at[0], fy = 0.5f * (float)eye->height - at[1];
    if ( !seen || !( fx > -reach && fx < (float)eye->width + reach && fy > -reach && fy < (float)eye->height + reach ) )
        return;
    for ( int k = 0; k < 4; ++k )
    {
        float kx = fx + ( k % 2 == 0 ? -reach : reach ), ky = fy + ( k < 2 ? -reach : reach );
        int cx = (int)floorf( kx / RF_CELL_SIDE ), cy = (int)floorf( ky / RF_CELL_SIDE );
        if ( cx < 0 || cy < 0 || cx >= pieces->across || cy >= pieces->down )
            continue;
        uint8_t* cell = cells + (size_t)cy * (size_t)pieces->across + (size_t)cx;
        *cell = *cell == 0 ? value : *cell;
    }
}

// Marks what the points are seen as in all other frames: as part of their pieces, or as to be traced.
static void follow_points( PieceChooser* c, int frame, bool as_pieces )
{
    RfTestPieces* pieces = c->pieces;
    PiecePoints* p = &c->points;
    bool blurred = c->blurred;
    RfEye own = rf_sample_eye( c->eyes + frame, c->lens );
    find_points( c, &own );
    for ( int k = 0; k < pieces->frames; ++k )
    {
        uint8_t* cells = ( as_pieces ? c->target : pieces->traced ) + (size_t)k * film_cells( pieces );
        RfEye eye = rf_sample_eye( c->eyes + k, c->lens );
        for ( int i = 0; i < p->count && k != frame; ++i )
            mark_point( pieces, &eye, point_of( p->x, i ), p->sky[i], blurred ? BLURRED_REACH : REACH,
                        as_pieces ? (uint8_t)( p->piece[i] + 1 ) : 1, cells );
    }
    p->count = 0;
}

static void follow_pinhole( PieceChooser* c, int frame, bool as_pieces )
{
    RfTestPieces* pieces = c->pieces;
    RfEye own = rf_sample_eye( c->eyes + frame, c->lens );
    const RfEye* eye = &own;
    const uint8_t* target = c->target + (size_t)frame * film_cells( pieces );
    PiecePoints* p = &c->points;
    const float inverse_focal[2] = { 1.0f / eye->focal_x, 1.0f / eye->focal };
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
            RfVec3 o, d;
            rf_eye_ray( eye, inverse_focal, x, y, 0.5f * STEP, 0.5f * STEP, &o, &d );
            put_point( p->o, p->count, o );
            put_point( p->d, p->count, d );
            p->piece[p->count++] = target[cell] - 1;
        }
        if ( p->count > PIECE_POINTS - RF_CELL_PIXELS )
            follow_points( c, frame, as_pieces );
    }
    follow_points( c, frame, as_pieces );
}

// Marks where the pieces of a frame are seen in all others, or would be if nothing were before them: as pieces there, or
// as to be traced.
static void follow_pieces( PieceChooser* c, int frame, bool as_pieces )
{
    int samples = c->blurred ? LENS_SAMPLES : 1;
    for ( int i = 0; i < samples; ++i )
    {
        // a lattice; each frame has another
        float u = ( (float)i + 0.5f ) / (float)samples, shift = 0.618034f * (float)( frame % 64 );
        float v = 0.375f * (float)i + shift, t = 0.625f * (float)i + shift;
        c->lens = ( RfLensSample ){ u, v - floorf( v ), t - floorf( t ) };
        follow_pinhole( c, frame, as_pieces );
    }
}

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
static bool place_blocks( PieceChooser* c, int centre, double pixels, uint64_t seed )
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
static void take_everything( PieceChooser* c )
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

// Adds to the pieces of a frame the cells beside them: no filter reaches beyond these.
static void grow_pieces( PieceChooser* c, int frame )
{
    _Static_assert( RF_FILTER_REACH <= RF_CELL_SIDE, "filters reach no farther than one cell" );
    const RfTestPieces* p = c->pieces;
    const uint8_t* target = c->target + (size_t)frame * film_cells( p );
    uint8_t* around = c->around + (size_t)frame * film_cells( p );
    memset( around, 0, film_cells( p ) );
    for ( size_t cell = 0; cell < film_cells( p ); ++cell )
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
static double try_pieces( PieceChooser* c, int centre, double pixels, uint64_t seed )
{
    RfTestPieces* p = c->pieces;
    size_t bytes = film_cells( p ) * (size_t)p->frames;
    memset( c->target, 0, bytes );
    if ( !place_blocks( c, centre, pixels, seed ) )
    {
        take_everything( c );
        return p->pixels;
    }
    follow_pieces( c, centre, true );
    uint8_t *pieces_only = c->target, *traced = c->around != NULL ? c->around : c->target;
    for ( int f = 0; f < p->frames && c->around != NULL; ++f )
        grow_pieces( c, f );
    memcpy( p->traced, traced, bytes );
    c->target = traced;
    for ( int f = 0; f < p->frames; ++f )
        follow_pieces( c, f, false );
    c->target = pieces_only;
    count_traced( p );
    return p->pixels;
}

// Where the camera moves fast, much more is traced than the pieces themselves: then fewer pieces are taken.
static void choose( PieceChooser* c, int centre, double pixels, uint64_t seed )
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
    number_slots( c->pieces, c->target );
}

RfResult rf_choose_pieces( const RfTracer* tracer, const RfEye* eyes, int frames, int centre, double pixels, bool filtered,
                           uint64_t seed, RfTestPieces* p, RfError* error )
{
    bool enough = make_room( eyes->width, eyes->height, frames, p );
    size_t cells = film_cells( p ) * (size_t)frames;
    p->traced = calloc( cells, 1 );
    PieceChooser* c = calloc( 1, sizeof *c );
    uint8_t *target = calloc( cells, 1 ), *around = calloc( cells, 1 );
    enough = enough && p->traced != NULL && c != NULL && target != NULL && around != NULL;
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
    return enough ? RF_OK : fail_memory( frames, error );
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
