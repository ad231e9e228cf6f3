// Finds emitting triangles that lie on each other, by halving space until few are left in a box.
#include "scene/twins.h"

#include "base/fault.h"
#include "scene/placement.h"
#include "scene/textured.h"

#include <stdlib.h>

#define FEW 8              // triangles of a box that is not halved
#define MOST_DEPTH 60      // of boxes in boxes
#define MOST_PAIRS 8       // of objects that are named
#define MOST_WORK 50000000 // comparisons and triangles put into halves: about half a second
#define LEAST 1e-3f        // of a triangle's height that reaches into the other

typedef struct Emitter
{
    RfVec3 corner[3], normal;
    float low[3], high[3];
    uint32_t triangle;
    bool taken_out;
} Emitter;

// Objects by nodes, the earlier one first.
typedef struct Pair
{
    int first, second;
    uint32_t taken_out; // triangles of the second
    bool open;          // more of them lies in one place
} Pair;

typedef struct Search
{
    const RfScene* scene;
    Emitter* emitter;
    uint64_t work;  // so far
    bool crowded;   // it was not enough
    int pair_count; // at most one more than are named
    Pair pair[MOST_PAIRS + 1];
} Search;

static bool emits( const RfMaterial* m ) { return rf_emits( m ); }

// Whether `b` is in the plane of `a`, as far as light samples, which end a little before a light, can tell.
static bool is_level( const Emitter* a, const Emitter* b )
{
    float off = 0.0f, largest = 0.0f;
    for ( int k = 0; k < 3; ++k )
    {
        off = rf_maxf( off, fabsf( rf_dot( a->normal, rf_sub( b->corner[k], a->corner[0] ) ) ) );
        largest = rf_maxf( largest, rf_maxf( rf_largest_coordinate( a->corner[k] ), rf_largest_coordinate( b->corner[k] ) ) );
    }
    return off <= rf_ray_offset( largest );
}

// Whether `b` is beyond an edge of `a`, in one plane.
static bool is_beside( const Emitter* a, const Emitter* b )
{
    bool beside = false;
    for ( int k = 0; k < 3 && !beside; ++k )
    {
        RfVec3 from = a->corner[k], inward = rf_cross( a->normal, rf_sub( a->corner[( k + 1 ) % 3], from ) );
        float reach = -INFINITY;
        for ( int i = 0; i < 3; ++i )
            reach = rf_maxf( reach, rf_dot( inward, rf_sub( b->corner[i], from ) ) );
        beside = reach <= LEAST * rf_dot( inward, rf_sub( a->corner[( k + 2 ) % 3], from ) );
    }
    return beside;
}

static const RfMaterial* material_of( const RfScene* scene, const Emitter* e )
{
    return scene->materials + scene->triangles.material[e->triangle];
}

static bool is_opaque( const RfMaterial* m )
{
    return m->kind < RF_BSDF_FIRST_SPECULAR && ( m->textured == NULL || !( m->textured->masked || m->textured->blended ) );
}

static bool face_alike( const Emitter* a, const Emitter* b ) { return rf_dot( a->normal, b->normal ) > 0.0f; }

// Whether one of them is as good as both: they have the same corners, whichever comes first, and shine to the same sides.
static bool are_twins( const RfScene* scene, const Emitter* a, const Emitter* b )
{
    const RfMaterial *of_a = material_of( scene, a ), *of_b = material_of( scene, b );
    bool same = false, alike = face_alike( a, b );
    for ( int r = 0; r < 3 && !same; ++r )
    {
        same = true;
        for ( int k = 0; k < 3; ++k )
            same = same && rf_largest_coordinate( rf_sub( a->corner[k], b->corner[( ( alike ? k : 2 * k ) + r ) % 3] ) ) == 0.0f;
    }
    return same && !RF_FAULT( twins ) && of_a->double_sided == of_b->double_sided && ( alike || of_a->double_sided ) &&
           is_opaque( of_a ) && is_opaque( of_b );
}

static void compare( Search* s, const Emitter* a, Emitter* b )
{
    bool apart = a->taken_out || b->taken_out;
    for ( int c = 0; c < 3; ++c )
        apart = apart || a->low[c] > b->high[c] || b->low[c] > a->high[c];
    if ( apart || !( is_level( a, b ) || is_level( b, a ) ) || is_beside( a, b ) || is_beside( b, a ) )
        return;
    bool twins = are_twins( s->scene, a, b );
    if ( !twins && !face_alike( a, b ) )
        return; // bodies that touch, most often: nobody sees it
    int first = rf_node_of_triangle( s->scene, a->triangle ), second = rf_node_of_triangle( s->scene, b->triangle ), i = 0;
    while ( i < s->pair_count && i < MOST_PAIRS && ( s->pair[i].first != first || s->pair[i].second != second ) )
        ++i;
    if ( i == s->pair_count )
        s->pair[s->pair_count++] = ( Pair ){ .first = first, .second = second };
    b->taken_out = twins;
    s->pair[i].taken_out += b->taken_out;
    s->pair[i].open = s->pair[i].open || !b->taken_out;
}

// `list` ascends. Where there is nothing to gain by halving it, or no memory, all are compared.
static void search( Search* s, const uint32_t* list, uint32_t count, int depth )
{
    const Emitter* e = s->emitter;
    float low[3], high[3];
    int axis = 0;
    s->work += count;
    s->crowded = s->crowded || s->work > MOST_WORK;
    if ( s->crowded || count < 2 )
        return;
    for ( int c = 0; c < 3; ++c )
    {
        low[c] = INFINITY;
        high[c] = -INFINITY;
        for ( uint32_t i = 0; i < count; ++i )
        {
            low[c] = rf_minf( low[c], e[list[i]].low[c] );
            high[c] = rf_maxf( high[c], e[list[i]].high[c] );
        }
        axis = high[c] - low[c] > high[axis] - low[axis] ? c : axis;
    }
    float middle = 0.5f * low[axis] + 0.5f * high[axis];
    uint32_t* half = count > FEW && depth < MOST_DEPTH ? malloc( count * sizeof *half ) : NULL;
    uint64_t both = 0;
    for ( uint32_t i = 0; i < count; ++i )
        both += e[list[i]].low[axis] <= middle && e[list[i]].high[axis] >= middle;
    bool halve = half != NULL && both < count / 2;
    for ( int side = 0; side < 2 && halve; ++side )
    {
        uint32_t n = 0;
        for ( uint32_t i = 0; i < count; ++i )
        {
            half[n] = list[i];
            n += side == 0 ? e[list[i]].low[axis] <= middle : e[list[i]].high[axis] >= middle;
        }
        search( s, half, n, depth + 1 );
    }
    free( half );
    if ( halve )
        return;
    s->work += (uint64_t)count * count / 2;
    s->crowded = s->crowded || s->work > MOST_WORK;
    for ( uint32_t i = 0; i < count && !s->crowded; ++i )
    {
        for ( uint32_t k = i + 1; k < count; ++k )
            compare( s, e + list[i], s->emitter + list[k] );
    }
}

// False: it has no area.
static bool shape( const RfTriangles* triangles, uint32_t triangle, Emitter* e )
{
    double twice;
    *e = ( Emitter ){ .triangle = triangle };
    for ( int k = 0; k < 3; ++k )
        e->corner[k] = rf_corner( triangles, triangle, k );
    e->normal = rf_unit_cross( rf_sub( e->corner[1], e->corner[0] ), rf_sub( e->corner[2], e->corner[0] ), &twice );
    for ( int c = 0; c < 3; ++c )
    {
        float at[3] = { ( &e->corner[0].x )[c], ( &e->corner[1].x )[c], ( &e->corner[2].x )[c] };
        float offset = rf_ray_offset( rf_maxf( fabsf( at[0] ), rf_maxf( fabsf( at[1] ), fabsf( at[2] ) ) ) );
        e->low[c] = rf_minf( at[0], rf_minf( at[1], at[2] ) ) - offset;
        e->high[c] = rf_maxf( at[0], rf_maxf( at[1], at[2] ) ) + offset;
    }
    return twice > 0.0;
}

static void warn( const Search* s, RfLog* log )
{
    for ( int i = 0; i < s->pair_count && i < MOST_PAIRS; ++i )
    {
        const Pair* p = s->pair + i;
        const char *first = rf_object_name( s->scene, p->first ), *second = rf_object_name( s->scene, p->second ),
                   *path = s->scene->path, *more = i == MOST_PAIRS - 1 && s->pair_count > MOST_PAIRS ? "; so do others" : "";
        if ( p->open )
            rf_warn( log,
                     "%s: emitting triangles of '%.200s' and '%.200s' overlap in one plane, so their light depends on the "
                     "settings: move one%s",
                     path, first, second, more );
        else
            rf_warn( log, "%s: emitting triangles of '%.200s' lie on those of '%.200s', %u are left out: delete or move them%s",
                     path, second, first, p->taken_out, more );
    }
    if ( s->crowded )
        rf_warn(
            log,
            "%s: too many emitting triangles lie in one place to compare them all, and their light may depend on the settings",
            s->scene->path );
}

RfResult rf_take_out_twins( RfScene* scene, RfLog* log, RfError* error )
{
    const RfTriangles* t = &scene->triangles;
    uint32_t count = 0, kept = 0;
    for ( uint32_t i = 0; i < t->count; ++i )
        count += emits( scene->materials + t->material[i] );
    uint32_t* list = malloc( ( (size_t)count + 1 ) * sizeof *list );
    Search s = { .scene = scene, .emitter = malloc( ( (size_t)count + 1 ) * sizeof *s.emitter ) };
    bool enough = list != NULL && s.emitter != NULL;
    for ( uint32_t i = 0; i < t->count && enough; ++i )
    {
        list[kept] = kept;
        kept += emits( scene->materials + t->material[i] ) && shape( t, i, s.emitter + kept );
    }
    if ( enough )
        search( &s, list, kept, 0 );
    warn( &s, log );
    for ( uint32_t i = 0; i < kept; ++i )
    {
        uint32_t* corner = t->indices + 3 * (size_t)s.emitter[i].triangle;
        if ( s.emitter[i].taken_out )
            corner[1] = corner[2] = corner[0];
    }
    free( list );
    free( s.emitter );
    return enough ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its emitters", scene->path );
}
