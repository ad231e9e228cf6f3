#include "measure/pieces_follow.h"

#include "scene/projection.h"
#include "trace/trace.h"

#include <math.h>

#define STEP 2     // pixels between the points that are followed to other frames
#define REACH 1.0f // pixels around where such a point is seen that belong to it
// With a lens or a shutter points are followed from so many places of these, and reach farther.
#define LENS_SAMPLES 8
#define BLURRED_REACH 3.0f

static RfVec3 point_of( float ( *a )[RF_PIECE_POINTS], int i ) { return rf_vec3( a[0][i], a[1][i], a[2][i] ); }

static void put_point( float ( *a )[RF_PIECE_POINTS], int i, RfVec3 x )
{
    a[0][i] = x.x;
    a[1][i] = x.y;
    a[2][i] = x.z;
}

static void trace_points( const RfPieceChooser* c, RfPiecePoints* p )
{
    const float *o[3] = { p->o[0], p->o[1], p->o[2] }, *d[3] = { p->d[0], p->d[1], p->d[2] };
    rf_trace_nearest( c->tracer, p->count, o, d, false, p->triangle, p->u, p->v );
}

static RfVec3 hit_point( const RfPiecePoints* p, const RfTriangleRecord* r, int i )
{
    return rf_madd( rf_madd( r->p0, r->e1, p->u[i] ), r->e2, p->v[i] );
}

// Finds what the rays hit. What is seen in a flat mirror is seen as if it were behind it.
static void find_points( RfPieceChooser* c, const RfEye* eye )
{
    RfPiecePoints* p = &c->points;
    const RfTriangleRecord* records = rf_tracer_triangles( c->tracer );
    float far[RF_PIECE_POINTS];
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
        RfVec3 first = point_of( p->x, i ), second = hit_point( p, records + p->triangle[i], i );
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
static void follow_points( RfPieceChooser* c, int frame, bool as_pieces )
{
    RfTestPieces* pieces = c->pieces;
    RfPiecePoints* p = &c->points;
    bool blurred = c->blurred;
    RfEye own = rf_sample_eye( c->eyes + frame, c->lens );
    find_points( c, &own );
    for ( int k = 0; k < pieces->frames; ++k )
    {
        uint8_t* cells = ( as_pieces ? c->target : pieces->traced ) + (size_t)k * rf_film_cells( pieces );
        RfEye eye = rf_sample_eye( c->eyes + k, c->lens );
        for ( int i = 0; i < p->count && k != frame; ++i )
            mark_point( pieces, &eye, point_of( p->x, i ), p->sky[i], blurred ? BLURRED_REACH : REACH,
                        as_pieces ? (uint8_t)( p->piece[i] + 1 ) : 1, cells );
    }
    p->count = 0;
}

static void follow_pinhole( RfPieceChooser* c, int frame, bool as_pieces )
{
    RfTestPieces* pieces = c->pieces;
    RfEye own = rf_sample_eye( c->eyes + frame, c->lens );
    const RfEye* eye = &own;
    const uint8_t* target = c->target + (size_t)frame * rf_film_cells( pieces );
    RfPiecePoints* p = &c->points;
    const float inverse_focal[2] = { 1.0f / eye->focal_x, 1.0f / eye->focal };
    int32_t pixel[RF_CELL_PIXELS];
    p->count = 0;
    for ( size_t cell = 0; cell < rf_film_cells( pieces ); ++cell )
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
        if ( p->count > RF_PIECE_POINTS - RF_CELL_PIXELS )
            follow_points( c, frame, as_pieces );
    }
    follow_points( c, frame, as_pieces );
}

void rf_follow_pieces( RfPieceChooser* c, int frame, bool as_pieces )
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
