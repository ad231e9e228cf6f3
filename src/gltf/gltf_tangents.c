// Generates tangents for primitives without them if a normal texture needs them: MikkTSpace
// (Mikkelsen 2008, Simulation of Wrinkled Surfaces Revisited), as the specification requires.
// Corners with equal position, normal and texture coordinates on triangles of the same
// orientation in texture space share a tangent: the sum of the u directions of their
// triangles, projected onto the tangent plane and weighted by the corner's angle. In double,
// rounded once.

#include "gltf/gltf_mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NONE 0xffffffffu

// State for one primitive. Sums are kept at the first of equal vertices, per orientation.
typedef struct Spaces
{
    RfGltfPrimitive* primitive;
    const RfTextureRef* ref;
    uint32_t* first; // per vertex: the first equal vertex
    double ( *sums )[2][3];
    uint32_t* twin; // per vertex: its duplicate for triangles of the other orientation, or NONE
    int8_t* side;   // per vertex, from its first triangle: 1 unmirrored, −1 mirrored, 0 unknown yet
} Spaces;

// The coordinate set that the texture uses, before its transform.
static const float* uvs_of( const RfGltfPrimitive* primitive, const RfTextureRef* ref )
{
    return ref->uv_set == 0 ? primitive->t.uvs : primitive->t.uvs1;
}

static void free_spaces( Spaces* s )
{
    free( s->first );
    free( s->sums );
    free( s->twin );
    free( s->side );
}

static bool create_spaces( Spaces* s )
{
    size_t count = (size_t)s->primitive->t.vertex_count + 1;
    s->first = malloc( count * sizeof *s->first );
    s->sums = calloc( count, sizeof *s->sums );
    s->twin = malloc( count * sizeof *s->twin );
    s->side = calloc( count, sizeof *s->side );
    if ( s->first == NULL || s->sums == NULL || s->twin == NULL || s->side == NULL )
        return false;
    memset( s->twin, 0xff, count * sizeof *s->twin );
    return true;
}

// The attributes compared; −0 equals 0.
typedef struct Key
{
    float values[8];
} Key;

static Key key_of( const Spaces* s, uint32_t vertex )
{
    const RfGltfPrimitive* p = s->primitive;
    Key key;
    for ( size_t i = 0; i < 3; ++i )
    {
        key.values[i] = p->t.positions[3 * (size_t)vertex + i] + 0.0f;
        key.values[3 + i] = p->t.normals[3 * (size_t)vertex + i] + 0.0f;
    }
    for ( size_t i = 0; i < 2; ++i )
        key.values[6 + i] = uvs_of( p, s->ref )[2 * (size_t)vertex + i] + 0.0f;
    return key;
}

static size_t hash( const Key* key )
{
    uint64_t h = 0x9e3779b97f4a7c15u;
    for ( int i = 0; i < 8; ++i )
    {
        uint32_t bits;
        memcpy( &bits, key->values + i, sizeof bits );
        h = ( h ^ bits ) * 0xff51afd7ed558ccdu;
        h ^= h >> 32;
    }
    return (size_t)h;
}

// Fills `first`, by a hash table of twice as many slots as vertices.
static bool find_same( Spaces* s )
{
    uint32_t count = s->primitive->t.vertex_count;
    size_t size = 16;
    while ( size < 2 * (size_t)count )
        size *= 2;
    uint32_t* table = malloc( size * sizeof *table );
    if ( table == NULL )
        return false;
    memset( table, 0xff, size * sizeof *table );
    for ( uint32_t v = 0; v < count; ++v )
    {
        Key key = key_of( s, v );
        size_t at = hash( &key ) & ( size - 1 );
        for ( ; table[at] != NONE; at = ( at + 1 ) & ( size - 1 ) )
        {
            Key other = key_of( s, table[at] );
            // bits, as they were hashed: NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
            if ( memcmp( &key, &other, sizeof key ) == 0 )
                break;
        }
        if ( table[at] == NONE )
            table[at] = v;
        s->first[v] = table[at];
    }
    free( table );
    return true;
}

static void get3( const float* values, uint32_t vertex, double out[3] )
{
    for ( size_t i = 0; i < 3; ++i )
        out[i] = (double)values[3 * (size_t)vertex + i];
}

static double dot( const double a[3], const double b[3] ) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static bool normalize( double v[3] )
{
    double length = sqrt( dot( v, v ) );
    if ( !( length > 0.0 && isfinite( length ) ) )
        return false;
    for ( int i = 0; i < 3; ++i )
        v[i] /= length;
    return true;
}

// Projects v onto the plane across n and normalises it.
static bool flatten( const double n[3], double v[3] )
{
    double along = dot( n, v );
    for ( int i = 0; i < 3; ++i )
        v[i] -= n[i] * along;
    return normalize( v );
}

static void make_edge( const float* positions, uint32_t from, uint32_t to, double out[3] )
{
    double a[3], b[3];
    get3( positions, from, a );
    get3( positions, to, b );
    for ( int i = 0; i < 3; ++i )
        out[i] = b[i] - a[i];
}

// The direction of u' along a triangle, and its orientation: 0 if its coordinates span no
// area. v' points down the image and the bitangent up.
static int find_direction( const Spaces* s, const uint32_t corners[3], double along[3] )
{
    double at[3][2], e1[3], e2[3];
    for ( int i = 0; i < 3; ++i )
    {
        const float* uv = uvs_of( s->primitive, s->ref ) + 2 * (size_t)corners[i];
        const float* t = s->ref->transform;
        for ( int k = 0; k < 2; ++k )
            at[i][k] = (double)t[3 * k] * (double)uv[0] + (double)t[3 * k + 1] * (double)uv[1];
    }
    double du1 = at[1][0] - at[0][0], dv1 = at[1][1] - at[0][1], du2 = at[2][0] - at[0][0], dv2 = at[2][1] - at[0][1];
    double det = du1 * dv2 - du2 * dv1;
    if ( !( fabs( det ) > 0.0 ) )
        return 0;
    make_edge( s->primitive->t.positions, corners[0], corners[1], e1 );
    make_edge( s->primitive->t.positions, corners[0], corners[2], e2 );
    for ( int i = 0; i < 3; ++i )
        along[i] = ( e1[i] * dv2 - e2[i] * dv1 ) * ( det < 0.0 ? -1.0 : 1.0 );
    return !normalize( along ) ? 0 : det < 0.0 ? 1 : -1;
}

static void add_corner( Spaces* s, const uint32_t corners[3], int corner, int side, const double along[3] )
{
    uint32_t at = corners[corner];
    const float* positions = s->primitive->t.positions;
    double n[3], t[3] = { along[0], along[1], along[2] }, a[3], b[3];
    get3( s->primitive->t.normals, at, n );
    make_edge( positions, at, corners[( corner + 1 ) % 3], a );
    make_edge( positions, at, corners[( corner + 2 ) % 3], b );
    if ( !normalize( n ) || !flatten( n, t ) || !flatten( n, a ) || !flatten( n, b ) )
        return;
    double angle = acos( fmax( -1.0, fmin( 1.0, dot( a, b ) ) ) );
    double* sum = s->sums[s->first[at]][side > 0];
    for ( int i = 0; i < 3; ++i )
        sum[i] += t[i] * angle;
}

// Sums over all corners, and finds the vertices used in both orientations.
static uint32_t add_triangles( Spaces* s )
{
    RfGltfPrimitive* p = s->primitive;
    uint32_t count = p->t.vertex_count;
    for ( size_t t = 0; t < p->t.count; ++t )
    {
        uint32_t* corners = p->t.indices + 3 * t;
        double along[3];
        int side = find_direction( s, corners, along );
        for ( int i = 0; side != 0 && i < 3; ++i )
            add_corner( s, corners, i, side, along );
        for ( int i = 0; side != 0 && i < 3; ++i )
        {
            uint32_t v = corners[i];
            s->side[v] = s->side[v] == 0 ? (int8_t)side : s->side[v];
            if ( s->side[v] != side && s->twin[v] == NONE )
                s->twin[v] = count++;
        }
    }
    return count;
}

// Assigns the duplicates to triangles of the second orientation. Tangents have their room.
static bool split( const Spaces* s, uint32_t count )
{
    RfGltfPrimitive* p = s->primitive;
    uint32_t* sources = realloc( p->sources, ( (size_t)count + 1 ) * sizeof *sources );
    p->sources = sources != NULL ? sources : p->sources;
    bool room = sources != NULL;
    for ( uint32_t v = 0; room && v < p->t.vertex_count; ++v )
    {
        if ( s->twin[v] != NONE )
            sources[s->twin[v]] = sources[v];
    }
    for ( int a = 0; room && a < RF_TANGENT; ++a )
    {
        const size_t n = g_rf_attributes[a].components;
        float** all = rf_attribute( &p->t, a );
        if ( *all == NULL )
            continue;
        float* grown = realloc( *all, ( count * n + 1 ) * sizeof *grown );
        *all = grown != NULL ? grown : *all;
        room = grown != NULL;
        for ( size_t v = 0; room && v < p->t.vertex_count; ++v )
        {
            if ( s->twin[v] != NONE )
                memcpy( grown + n * s->twin[v], grown + n * v, n * sizeof *grown );
        }
    }
    return room;
}

static void renumber( Spaces* s )
{
    RfGltfPrimitive* p = s->primitive;
    for ( size_t t = 0; t < p->t.count; ++t )
    {
        uint32_t* corners = p->t.indices + 3 * t;
        double along[3];
        int side = find_direction( s, corners, along );
        for ( int i = 0; side != 0 && i < 3; ++i )
            corners[i] = s->side[corners[i]] != side ? s->twin[corners[i]] : corners[i];
    }
}

// Stores the tangent; zero with sign 0 if the sum cancels or no triangle defines a direction.
// A vertex without an orientation of its own takes that of its equals.
static void store( const Spaces* s, uint32_t vertex, int side, float out[4] )
{
    double( *sums )[3] = s->sums[s->first[vertex]], t[3];
    if ( side == 0 )
        side = dot( sums[1], sums[1] ) > 0.0 ? 1 : -1;
    memcpy( t, sums[side > 0], sizeof t );
    bool usable = normalize( t );
    for ( int i = 0; i < 3; ++i )
        out[i] = usable ? (float)t[i] : 0.0f;
    out[3] = usable ? (float)side : 0.0f;
}

static RfResult make( Spaces* s, const RfGltf* gltf, const char* where )
{
    RfGltfPrimitive* p = s->primitive;
    if ( !create_spaces( s ) || !find_same( s ) )
        return rf_gltf_no_memory( gltf, where );
    uint32_t before = p->t.vertex_count, after = add_triangles( s );
    p->t.tangents = malloc( ( (size_t)after * 4 + 1 ) * sizeof *p->t.tangents );
    if ( p->t.tangents == NULL || !split( s, after ) )
        return rf_gltf_no_memory( gltf, where );
    if ( after != before )
        renumber( s );
    for ( uint32_t v = 0; v < before; ++v )
    {
        store( s, v, s->side[v], p->t.tangents + 4 * (size_t)v );
        if ( s->twin[v] != NONE )
            store( s, v, -s->side[v], p->t.tangents + 4 * (size_t)s->twin[v] );
    }
    p->t.vertex_count = after;
    return RF_OK;
}

RfResult rf_gltf_make_tangents( const RfGltf* gltf, const char* where, const RfTextureRef* ref, RfGltfPrimitive* primitive )
{
    Spaces spaces = { .primitive = primitive, .ref = ref };
    RfResult result = make( &spaces, gltf, where );
    free_spaces( &spaces );
    return result;
}
