// Ear clipping (Meisters, Polygons Have Ears, 1975). An ear is a convex corner whose triangle holds no other corner; only those that
// are not convex can be in it, and these are found by a grid.
#include "convert/polygon.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#define MOST_CELLS 512 // in a row of the grid
#define NONE UINT32_MAX

typedef struct Place
{
    double x, y;
} Place;

// A polygon in its plane, counter-clockwise.
typedef struct Polygon
{
    const uint32_t* corners;
    Place* at;
    uint32_t *next, *before; // next: NONE where a corner is cut off
    // corners that are not convex, by cell
    uint32_t *link, *head;
    Place low, scale; // cells per unit
    uint32_t side;    // of the grid
    uint64_t* steps;
} Polygon;

// Newell's method: the normal's components are twice the projected areas. The polygon is projected along the largest.
static void project( const float* positions, uint32_t count, Polygon* p )
{
    double n[3] = { 0 };
    for ( uint32_t i = 0; i < count; ++i )
    {
        const float* a = positions + 3 * (size_t)p->corners[i];
        const float* b = positions + 3 * (size_t)p->corners[( i + 1 ) % count];
        for ( int k = 0; k < 3; ++k )
        {
            int u = ( k + 1 ) % 3, v = ( k + 2 ) % 3;
            n[k] += (double)a[u] * (double)b[v] - (double)a[v] * (double)b[u];
        }
    }
    int axis = fabs( n[0] ) > fabs( n[1] ) ? 0 : 1;
    axis = fabs( n[2] ) > fabs( n[axis] ) ? 2 : axis;
    double sign = n[axis] < 0.0 ? -1.0 : 1.0;
    for ( uint32_t i = 0; i < count; ++i )
    {
        const float* a = positions + 3 * (size_t)p->corners[i];
        p->at[i] = ( Place ){ sign * (double)a[( axis + 1 ) % 3], (double)a[( axis + 2 ) % 3] };
        p->next[i] = i + 1 < count ? i + 1 : 0;
        p->before[i] = i > 0 ? i - 1 : count - 1;
    }
}

// Twice the signed area of a triangle; negative if it has the opposite winding.
static double area( Place a, Place b, Place c ) { return ( b.x - a.x ) * ( c.y - a.y ) - ( c.x - a.x ) * ( b.y - a.y ); }

static double corner_area( const Polygon* p, uint32_t i ) { return area( p->at[p->before[i]], p->at[i], p->at[p->next[i]] ); }

static bool is_convex( const Polygon* p, uint32_t count )
{
    for ( uint32_t i = 0; i < count; ++i )
    {
        if ( corner_area( p, i ) < 0.0 )
            return false;
    }
    return true;
}

static uint32_t cell_along( double value, double low, double scale, uint32_t side )
{
    double cell = ( value - low ) * scale;
    return cell > 0.0 ? ( cell < side ? (uint32_t)cell : side - 1 ) : 0;
}

static void fill_grid( Polygon* p, uint32_t count )
{
    Place high = p->low = p->at[0];
    uint32_t blockers = 0;
    for ( uint32_t i = 0; i < count; ++i )
    {
        p->low = ( Place ){ fmin( p->low.x, p->at[i].x ), fmin( p->low.y, p->at[i].y ) };
        high = ( Place ){ fmax( high.x, p->at[i].x ), fmax( high.y, p->at[i].y ) };
        blockers += corner_area( p, i ) <= 0.0;
    }
    p->side = (uint32_t)sqrt( (double)blockers );
    p->side = p->side < 1 ? 1 : ( p->side > MOST_CELLS ? MOST_CELLS : p->side );
    p->scale = ( Place ){ high.x > p->low.x ? p->side / ( high.x - p->low.x ) : 0.0,
                          high.y > p->low.y ? p->side / ( high.y - p->low.y ) : 0.0 };
    for ( uint32_t i = 0; i < p->side * p->side; ++i )
        p->head[i] = NONE;
    for ( uint32_t i = 0; i < count; ++i )
    {
        if ( corner_area( p, i ) > 0.0 )
            continue;
        uint32_t cell = cell_along( p->at[i].y, p->low.y, p->scale.y, p->side ) * p->side +
                        cell_along( p->at[i].x, p->low.x, p->scale.x, p->side );
        p->link[i] = p->head[cell];
        p->head[cell] = i;
    }
}

static bool is_same( Place a, Place b ) { return a.x == b.x && a.y == b.y; }

// Whether a corner in this cell is inside a triangle; with `touching`, on its border.
static bool is_blocked( const Polygon* p, uint32_t cell, const uint32_t corner[3], bool touching )
{
    Place a = p->at[corner[0]], b = p->at[corner[1]], c = p->at[corner[2]];
    for ( uint32_t k = p->head[cell]; k != NONE; k = p->link[k] )
    {
        Place q = p->at[k];
        *p->steps -= *p->steps > 0;
        // both sides of an edge to a hole have the same ends
        if ( p->next[k] == NONE || is_same( q, a ) || is_same( q, b ) || is_same( q, c ) )
            continue;
        double u = area( a, b, q ), v = area( b, c, q ), w = area( c, a, q );
        if ( touching ? u >= 0.0 && v >= 0.0 && w >= 0.0 : u > 0.0 && v > 0.0 && w > 0.0 )
            return true;
    }
    return false;
}

static bool is_ear( const Polygon* p, uint32_t i, bool strict )
{
    const uint32_t corner[3] = { p->before[i], i, p->next[i] };
    Place a = p->at[corner[0]], b = p->at[i], c = p->at[corner[2]];
    double size = area( a, b, c );
    *p->steps -= *p->steps > 0;
    if ( strict ? !( size > 0.0 ) : !( size >= 0.0 ) )
        return false;
    uint32_t x0 = cell_along( fmin( fmin( a.x, b.x ), c.x ), p->low.x, p->scale.x, p->side );
    uint32_t x1 = cell_along( fmax( fmax( a.x, b.x ), c.x ), p->low.x, p->scale.x, p->side );
    uint32_t y0 = cell_along( fmin( fmin( a.y, b.y ), c.y ), p->low.y, p->scale.y, p->side );
    uint32_t y1 = cell_along( fmax( fmax( a.y, b.y ), c.y ), p->low.y, p->scale.y, p->side );
    for ( uint32_t y = y0; y <= y1; ++y )
    {
        for ( uint32_t x = x0; x <= x1; ++x )
        {
            if ( is_blocked( p, y * p->side + x, corner, strict ) )
                return false;
        }
        *p->steps -= *p->steps > x1 - x0 ? x1 - x0 : *p->steps;
    }
    return true;
}

static uint32_t* put_triangle( uint32_t* triangles, const Polygon* p, uint32_t a, uint32_t b, uint32_t c )
{
    triangles[0] = p->corners[a];
    triangles[1] = p->corners[b];
    triangles[2] = p->corners[c];
    return triangles + 3;
}

// Ears that nothing touches; where there are none, those that nothing is in, also flat ones; where there are none of these either,
// whatever corner comes next.
static RfCut clip_ears( Polygon* p, uint32_t count, uint32_t* triangles )
{
    RfCut cut = RF_CUT_WHOLE;
    uint32_t i = 0, tries = 0;
    int patience = 0;
    while ( count > 3 )
    {
        if ( *p->steps == 0 )
            return RF_CUT_GIVEN_UP;
        if ( patience < 2 && !is_ear( p, i, patience == 0 ) )
        {
            i = p->next[i];
            patience += ++tries == count;
            tries = tries == count ? 0 : tries;
            continue;
        }
        cut = patience < 2 ? cut : RF_CUT_CROSSED;
        uint32_t before = p->before[i], next = p->next[i];
        triangles = put_triangle( triangles, p, before, i, next );
        p->next[before] = next;
        p->before[next] = before;
        p->next[i] = NONE;
        i = p->next[next]; // not the next one, which makes slivers
        --count;
        tries = 0;
        patience = 0;
    }
    put_triangle( triangles, p, p->before[i], i, p->next[i] );
    return cut;
}

static bool make_room( RfCutter* cutter, uint32_t count )
{
    if ( count <= cutter->room )
        return true;
    size_t room = 2 * (size_t)count;
    free( cutter->memory );
    cutter->memory = malloc( room * ( sizeof( Place ) + 4 * sizeof( uint32_t ) ) );
    cutter->room = cutter->memory != NULL ? (uint32_t)room : 0;
    return cutter->memory != NULL;
}

RfCut rf_cut_polygon( const float* positions, const uint32_t* corners, uint32_t count, uint32_t* triangles, RfCutter* cutter )
{
    if ( !make_room( cutter, count ) )
        return RF_CUT_NO_MEMORY;
    cutter->steps += (uint64_t)count * RF_CUT_STEPS_PER_CORNER;
    uint32_t* numbers = (uint32_t*)( (Place*)cutter->memory + cutter->room );
    Polygon p = { .corners = corners,
                  .at = cutter->memory,
                  .next = numbers,
                  .before = numbers + cutter->room,
                  .link = numbers + 2 * (size_t)cutter->room,
                  .head = numbers + 3 * (size_t)cutter->room,
                  .steps = &cutter->steps };
    project( positions, count, &p );
    if ( count > 3 && !is_convex( &p, count ) )
    {
        fill_grid( &p, count );
        return clip_ears( &p, count, triangles );
    }
    for ( uint32_t i = 1; i + 1 < count; ++i )
        triangles = put_triangle( triangles, &p, 0, i, i + 1 );
    return RF_CUT_WHOLE;
}

void rf_free_cutter( RfCutter* cutter )
{
    free( cutter->memory );
    *cutter = ( RfCutter ){ 0 };
}
