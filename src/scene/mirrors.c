// Flat mirrors, grouped of coplanar specular triangles; boxes around the mirrors and the glass of a scene.
#include "scene/mirrors.h"

#include "scene/deformation.h"
#include "scene/moments.h"
#include "scene/textured.h"

#include <math.h>
#include <stdlib.h>

// Coplanar: sine of the angle between the normals, and distance over the largest coordinate.
#define MAX_SINE 3e-5f
#define MAX_DISTANCE 3e-6f
// A smaller area is no mirror worth images of the cameras; times the square of the scene's diagonal.
#define LEAST_AREA 2e-5
#define CANDIDATES 1024

typedef struct Facet
{
    uint32_t triangle;
    int plane; // −1: none
    double area;
    RfVec3 n, p;
    float largest;
} Facet;

static bool reflects( const RfMaterial* m ) { return m->kind == RF_BSDF_GLASS && m->alpha == 0.0f && m->textured == NULL; }

// False if shading normals would turn the reflection. Where all three are the same, the tracer takes the triangle's own.
static bool is_flat( const RfTriangles* t, const uint32_t* index, RfVec3 n )
{
    RfVec3 first = rf_load_vec3( t->normals, index[0] );
    float largest2 = 0.0f;
    bool flat = true;
    for ( int k = 0; k < 3; ++k )
    {
        RfVec3 m = rf_load_vec3( t->normals, index[k] ), sine = rf_cross( m, n ), turn = rf_sub( m, first );
        if ( !( rf_dot( m, n ) > 0.999999f ) )
            return false;
        flat = flat && rf_dot( turn, turn ) == 0.0f;
        largest2 = rf_maxf( largest2, rf_dot( sine, sine ) );
    }
    return flat || largest2 <= MAX_SINE * MAX_SINE;
}

// False if the triangle has no area, or normals that are not its own.
static bool make_facet( const RfTriangles* t, uint32_t triangle, Facet* facet )
{
    const uint32_t* index = t->indices + 3 * (size_t)triangle;
    RfVec3 p0 = rf_load_vec3( t->positions, index[0] ), p1 = rf_load_vec3( t->positions, index[1] ),
           p2 = rf_load_vec3( t->positions, index[2] );
    double twice;
    RfVec3 n = rf_unit_cross( rf_sub( p1, p0 ), rf_sub( p2, p0 ), &twice );
    float largest = rf_maxf( rf_largest_coordinate( p0 ), rf_maxf( rf_largest_coordinate( p1 ), rf_largest_coordinate( p2 ) ) );
    *facet = ( Facet ){ triangle, -1, 0.5 * twice, n, p0, largest };
    return twice > 0.0 && is_flat( t, index, n );
}

static int compare_facets( const void* a, const void* b )
{
    const Facet *f = a, *g = b;
    if ( f->area != g->area )
        return f->area < g->area ? 1 : -1;
    return f->triangle < g->triangle ? -1 : 1;
}

static uint32_t list_facets( const RfScene* scene, Facet* facets )
{
    const RfTriangles* t = &scene->triangles;
    uint32_t count = 0;
    for ( uint32_t i = 0; i < t->count; ++i )
        count += reflects( scene->materials + t->material[i] ) && make_facet( t, i, facets + count );
    return count;
}

static bool lies_in( const RfTriangles* t, const Facet* facet, const RfMirror* mirror )
{
    RfVec3 sine = rf_cross( facet->n, mirror->n );
    if ( t->material[facet->triangle] != mirror->number || rf_dot( sine, sine ) > MAX_SINE * MAX_SINE ||
         rf_dot( facet->n, mirror->n ) < 0.0f )
        return false;
    const uint32_t* index = t->indices + 3 * (size_t)facet->triangle;
    for ( int k = 0; k < 3; ++k )
    {
        if ( fabsf( rf_mirror_distance( mirror, rf_load_vec3( t->positions, index[k] ) ) ) > MAX_DISTANCE * facet->largest )
            return false;
    }
    return true;
}

// Gives each facet a plane; the larger ones first, since their normals are the more accurate.
static int group_facets( const RfScene* scene, uint32_t count, Facet* facets, RfMirror* planes )
{
    const RfTriangles* t = &scene->triangles;
    int plane_count = 0, last = 0;
    for ( uint32_t i = 0; i < count; ++i )
    {
        Facet* f = facets + i;
        int found = plane_count > 0 && lies_in( t, f, planes + last ) ? last : 0;
        while ( found < plane_count && !lies_in( t, f, planes + found ) )
            ++found;
        if ( found == CANDIDATES )
            continue;
        if ( found == plane_count )
        {
            uint32_t number = t->material[f->triangle];
            planes[plane_count++] = ( RfMirror ){ f->n, rf_dot( f->n, f->p ), scene->materials[number], number, 0.0 };
        }
        planes[found].area += f->area;
        f->plane = last = found;
    }
    return plane_count;
}

// Keeps the planes that are large enough; number[] becomes their place among the mirrors, or −1.
static void choose_mirrors( const RfScene* scene, const RfMirror* planes, int plane_count, int* number, RfMirrors* mirrors )
{
    RfVec3 size = rf_sub( scene->bounds_max, scene->bounds_min );
    double least = LEAST_AREA * (double)rf_dot( size, size );
    for ( int i = 0; i < plane_count; ++i )
        number[i] = -1;
    while ( mirrors->count < RF_MAX_MIRRORS )
    {
        int best = -1;
        for ( int i = 0; i < plane_count; ++i )
        {
            if ( number[i] < 0 && planes[i].area >= least && ( best < 0 || planes[i].area > planes[best].area ) )
                best = i;
        }
        if ( best < 0 )
            return;
        number[best] = mirrors->count;
        mirrors->mirror[mirrors->count++] = planes[best];
    }
}

static void list_triangles( const Facet* facets, uint32_t count, const int* number, RfMirrors* mirrors )
{
    for ( uint32_t i = 0; i < count; ++i )
    {
        if ( facets[i].plane < 0 || number[facets[i].plane] < 0 )
            continue;
        mirrors->triangle[mirrors->triangle_count] = facets[i].triangle;
        mirrors->of_triangle[mirrors->triangle_count++] = (uint8_t)number[facets[i].plane];
    }
}

static bool fill_mirrors( const RfScene* scene, Facet* facets, RfMirrors* mirrors )
{
    uint32_t count = list_facets( scene, facets );
    if ( count == 0 )
        return true;
    RfMirror* planes = calloc( CANDIDATES, sizeof *planes );
    int* number = calloc( CANDIDATES, sizeof *number );
    mirrors->mirror = calloc( RF_MAX_MIRRORS, sizeof *mirrors->mirror );
    mirrors->triangle = calloc( count, sizeof *mirrors->triangle );
    mirrors->of_triangle = calloc( count, sizeof *mirrors->of_triangle );
    bool enough =
        planes != NULL && number != NULL && mirrors->mirror != NULL && mirrors->triangle != NULL && mirrors->of_triangle != NULL;
    if ( enough )
    {
        qsort( facets, count, sizeof *facets, compare_facets );
        int plane_count = group_facets( scene, count, facets, planes );
        choose_mirrors( scene, planes, plane_count, number, mirrors );
        list_triangles( facets, count, number, mirrors );
    }
    free( planes );
    free( number );
    return enough;
}

RfResult rf_find_mirrors( const RfScene* scene, RfMirrors* mirrors, RfError* error )
{
    *mirrors = ( RfMirrors ){ 0 };
    uint32_t most = 0;
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
        most += reflects( scene->materials + scene->triangles.material[i] );
    if ( most == 0 )
        return RF_OK;
    Facet* facets = malloc( (size_t)( most + 1 ) * sizeof *facets );
    bool enough = facets != NULL && fill_mirrors( scene, facets, mirrors );
    free( facets );
    if ( enough )
        return RF_OK;
    rf_destroy_mirrors( mirrors );
    return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the mirrors among %u triangles", most );
}

void rf_destroy_mirrors( RfMirrors* mirrors )
{
    free( mirrors->mirror );
    free( mirrors->triangle );
    free( mirrors->of_triangle );
    *mirrors = ( RfMirrors ){ 0 };
}

// Boxes around specular chains: the surfaces are split by the area that this saves.

#define MARGIN 1e-5f   // of a box, over its distance from the origin and its size
#define LEAST_LESS 0.9 // area of the halves over that of the whole, where a box is split

// A box with its triangles.
typedef struct Part
{
    uint32_t begin, end;
    RfVec3 low, high;
    bool whole; // splitting it leaves out little
} Part;

static float component( RfVec3 v, int axis ) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static double area( const Part* part )
{
    RfVec3 e = rf_sub( part->high, part->low );
    return (double)e.x * (double)e.y + (double)e.y * (double)e.z + (double)e.z * (double)e.x;
}

// At one of the moments of the shutter.
static void get_corners( const RfScene* scene, int moment, uint32_t triangle, RfVec3 corners[3] )
{
    RfTriangleAt at = rf_locate_triangle( scene, triangle );
    for ( int k = 0; k < 3; ++k )
        corners[k] = at.placement == NULL ? rf_corner( at.triangles, triangle, k ) : rf_corner_at( scene, moment, &at, k );
}

static void bound( const RfScene* scene, const uint32_t* triangle, Part* part )
{
    for ( uint32_t i = part->begin; i < part->end; ++i )
    {
        RfVec3 p[3];
        for ( int k = 0; k < 3 * rf_moment_count( scene ); ++k )
        {
            if ( k % 3 == 0 )
                get_corners( scene, k / 3, triangle[i], p );
            rf_grow_bounds( &part->low, &part->high, i == part->begin && k == 0, p[k % 3] );
        }
    }
}

// Splits a part in the middle of its longest side. False: that leaves out little.
static bool split( const RfScene* scene, uint32_t* triangle, Part* part, Part* other )
{
    RfVec3 e = rf_sub( part->high, part->low );
    int axis = e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
    float middle = 0.5f * ( component( part->low, axis ) + component( part->high, axis ) );
    uint32_t at = part->begin;
    for ( uint32_t i = part->begin; i < part->end; ++i )
    {
        RfVec3 p[3];
        get_corners( scene, 0, triangle[i], p );
        RfVec3 sum = rf_add( p[0], rf_add( p[1], p[2] ) );
        if ( component( sum, axis ) >= 3.0f * middle )
            continue;
        uint32_t swap = triangle[i];
        triangle[i] = triangle[at];
        triangle[at++] = swap;
    }
    if ( at == part->begin || at == part->end )
        return false;
    Part low = { .begin = part->begin, .end = at }, high = { .begin = at, .end = part->end };
    bound( scene, triangle, &low );
    bound( scene, triangle, &high );
    if ( area( &low ) + area( &high ) > LEAST_LESS * area( part ) )
        return false;
    *part = low;
    *other = high;
    return true;
}

// Splits the largest part, again and again.
static int split_all( const RfScene* scene, uint32_t* triangle, Part* parts )
{
    int count = 1;
    while ( count < RF_MAX_CHAIN_BOUNDS )
    {
        int largest = -1;
        for ( int k = 0; k < count; ++k )
            largest = !parts[k].whole && ( largest < 0 || area( parts + k ) > area( parts + largest ) ) ? k : largest;
        if ( largest < 0 )
            break;
        if ( split( scene, triangle, parts + largest, parts + count ) )
            count += 1;
        else
            parts[largest].whole = true;
    }
    return count;
}

static bool is_chain( const RfMaterial* m ) { return m->kind == RF_BSDF_GLASS && !m->thin; }

RfResult rf_bound_chains( const RfScene* scene, RfChainBounds* bounds, RfError* error )
{
    *bounds = ( RfChainBounds ){ 0 };
    uint32_t found = rf_list_triangles( scene, is_chain, NULL );
    if ( found == 0 )
        return RF_OK;
    uint32_t* triangle = malloc( found * sizeof *triangle );
    if ( triangle == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the bounds of %u triangles of mirrors and glass", found );
    Part parts[RF_MAX_CHAIN_BOUNDS] = { { .begin = 0, .end = found } };
    rf_list_triangles( scene, is_chain, triangle );
    bound( scene, triangle, parts );
    bounds->count = split_all( scene, triangle, parts );
    free( triangle );
    for ( int k = 0; k < bounds->count; ++k )
    {
        bounds->low[k] = parts[k].low;
        bounds->high[k] = parts[k].high;
    }
    return RF_OK;
}

// The interval in which a ray is between two planes, cut to [*near, *far].
static inline void cut( float low, float high, float o, float inverse, float* near, float* far )
{
    float a = ( low - o ) * inverse, b = ( high - o ) * inverse;
    *near = rf_maxf( *near, rf_minf( a, b ) );
    *far = rf_minf( *far, rf_maxf( a, b ) );
}

static inline float inverse_of( float d ) { return 1.0f / ( fabsf( d ) > 1e-12f ? d : 1e-12f ); }

static void meet( RfVec3 low, RfVec3 high, int count, const float* const o[3], const float* const d[3], float* restrict meets )
{
    const float* restrict ox = o[0], * restrict oy = o[1], * restrict oz = o[2];
    const float* restrict dx = d[0], * restrict dy = d[1], * restrict dz = d[2];
    float size = rf_length( rf_sub( high, low ) );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 from = rf_vec3( ox[i], oy[i], oz[i] );
        float margin = MARGIN * ( size + fabsf( from.x - low.x ) + fabsf( from.y - low.y ) + fabsf( from.z - low.z ) +
                                  fabsf( from.x ) + fabsf( from.y ) + fabsf( from.z ) );
        float near = 0.0f, far = 1e30f;
        cut( low.x - margin, high.x + margin, from.x, inverse_of( dx[i] ), &near, &far );
        cut( low.y - margin, high.y + margin, from.y, inverse_of( dy[i] ), &near, &far );
        cut( low.z - margin, high.z + margin, from.z, inverse_of( dz[i] ), &near, &far );
        meets[i] = near <= far ? 1.0f : meets[i];
    }
}

void rf_meet_chain_bounds( const RfChainBounds* bounds, int count, const float* const o[3], const float* const d[3],
                           float* meets )
{
    for ( int i = 0; i < count; ++i )
        meets[i] = 0.0f;
    for ( int k = 0; k < bounds->count; ++k )
        meet( bounds->low[k], bounds->high[k], count, o, d, meets );
}
