// Groups coplanar specular triangles into flat mirrors and keeps the largest.
#include "scene/mirrors.h"

#include "scene/textured.h"

#include <stdlib.h>
#include <string.h>

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

static RfVec3 corner( const float* values, const uint32_t* index, int k )
{
    const float* v = values + 3 * (size_t)index[k];
    return rf_vec3( v[0], v[1], v[2] );
}

// False if shading normals would turn the reflection. Where all three are the same, the tracer takes the triangle's own.
static bool is_flat( const RfTriangles* t, const uint32_t* index, RfVec3 n )
{
    RfVec3 first = corner( t->normals, index, 0 );
    float largest2 = 0.0f;
    bool flat = true;
    for ( int k = 0; k < 3; ++k )
    {
        RfVec3 m = corner( t->normals, index, k ), sine = rf_cross( m, n ), turn = rf_sub( m, first );
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
    RfVec3 p0 = corner( t->positions, index, 0 ), p1 = corner( t->positions, index, 1 ), p2 = corner( t->positions, index, 2 );
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
        if ( fabsf( rf_mirror_distance( mirror, corner( t->positions, index, k ) ) ) > MAX_DISTANCE * facet->largest )
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
