// Primitives of meshes: triangles, only the vertices that they use, and tangents.
#include "base/try.h"
#include "gltf/gltf_document.h"

#include "scene/merge.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Tangents for primitives without them, if a normal texture needs them: MikkTSpace
// (Mikkelsen 2008, Simulation of Wrinkled Surfaces Revisited), as the specification requires.
// Corners with equal position, normal and texture coordinates on triangles of the same
// orientation in texture space share a tangent: the sum of the u directions of their
// triangles, projected onto the tangent plane and weighted by the corner's angle. In double,
// rounded once.

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
    bool room = rf_make_room( &p->sources, count, sizeof *p->sources );
    for ( uint32_t v = 0; room && v < p->t.vertex_count; ++v )
    {
        if ( s->twin[v] != NONE )
            p->sources[s->twin[v]] = p->sources[v];
    }
    for ( int a = 0; room && a < RF_TANGENT; ++a )
    {
        const size_t n = g_rf_attributes[a].components;
        float** all = rf_attribute( &p->t, a );
        if ( *all == NULL )
            continue;
        room = rf_make_room( all, count * n, sizeof **all );
        for ( size_t v = 0; room && v < p->t.vertex_count; ++v )
        {
            if ( s->twin[v] != NONE )
                memcpy( *all + n * s->twin[v], *all + n * v, n * sizeof **all );
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

// For a primitive with normals and the texture's coordinates. Vertices shared by mirrored and unmirrored triangles are duplicated.
static RfResult make_tangents( const RfGltf* gltf, const char* where, const RfTextureRef* ref, RfGltfPrimitive* primitive )
{
    Spaces spaces = { .primitive = primitive, .ref = ref };
    RfResult result = make( &spaces, gltf, where );
    free_spaces( &spaces );
    return result;
}

// Vertex indices of the triangles of a primitive: indexed or not, as a list, strip or fan.

// Of a single primitive; baking limits the sum over the scene.
#define MAX_TRIANGLES ( 1u << 28 )

enum
{
    LIST = 4,
    STRIP = 5,
    FAN = 6,
};

// A compressed mesh is a list of triangles in each mode.
static RfResult open_indices( RfGltf* gltf, const RfField* primitive, int* mode, const RfGltfAccessor** accessor )
{
    int index = -1;
    RfResult result = rf_gltf_packed_indices( gltf, primitive, accessor );
    if ( result == RF_OK && *accessor == NULL )
        index = rf_gltf_get_index( gltf, primitive, "indices", RF_GLTF_ACCESSORS );
    else
        *mode = LIST;
    if ( index < 0 )
        return rf_json_result( primitive );
    result = rf_gltf_open_accessor( gltf, index, primitive->path, 1, accessor );
    if ( result != RF_OK )
        return result;
    int type = ( *accessor )->component_type;
    if ( ( type != 5121 && type != 5123 && type != 5125 ) || ( *accessor )->normalized )
        return rf_field_fail( primitive, "indices accessors[%d] must be unsigned integers", index );
    return RF_OK;
}

static RfResult count_triangles( const RfGltf* gltf, const char* where, int mode, uint32_t corners, uint32_t* count )
{
    if ( mode == LIST && corners % 3 != 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%u corners do not make whole triangles", corners );
    *count = mode == LIST ? corners / 3 : corners >= 3 ? corners - 2 : 0;
    if ( *count > MAX_TRIANGLES )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where, "%u triangles are too many, the limit is %u: split the scene",
                             *count, MAX_TRIANGLES );
    return RF_OK;
}

// The corners of triangle t, counter-clockwise, by the specification's section on topology
// types.
static void find_corners( int mode, uint32_t t, uint32_t corners[3] )
{
    uint32_t odd = t % 2;
    switch ( mode )
    {
        case STRIP: corners[0] = t, corners[1] = t + 1 + odd, corners[2] = t + 2 - odd; break;
        case FAN: corners[0] = t + 1, corners[1] = t + 2, corners[2] = 0; break;
        default: corners[0] = 3 * t, corners[1] = 3 * t + 1, corners[2] = 3 * t + 2; break;
    }
}

// Reads triples of vertex indices, from an index accessor or implicit, by mode; of a survey, their number alone.
static RfResult read_triangles( RfGltf* gltf, const RfField* primitive, int mode, uint32_t vertex_count, bool survey,
                                RfTriangles* out )
{
    const char* where = primitive->path;
    const RfGltfAccessor* accessor;
    RF_TRY( open_indices( gltf, primitive, &mode, &accessor ) );
    RF_TRY( count_triangles( gltf, where, mode, accessor != NULL ? accessor->count : vertex_count, &out->count ) );
    if ( survey )
        return RF_OK;

    RF_TRY( rf_gltf_allocate( gltf, where, &out->indices, (size_t)out->count * 3, sizeof *out->indices ) );
    for ( uint32_t t = 0; t < out->count; ++t )
    {
        uint32_t corners[3];
        find_corners( mode, t, corners );
        for ( int i = 0; i < 3; ++i )
        {
            uint32_t vertex = accessor != NULL ? rf_gltf_read_index( accessor, corners[i] ) : corners[i];
            if ( vertex >= vertex_count )
                return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "index %u is %u, but there are %u vertices", corners[i],
                                     vertex, vertex_count );
            out->indices[3 * (size_t)t + (size_t)i] = vertex;
        }
    }
    return RF_OK;
}

static bool spread_sources( RfGltfPrimitive* p )
{
    size_t corners = 3 * (size_t)p->t.count;
    uint32_t* out = malloc( ( corners + 1 ) * sizeof *out );
    if ( out == NULL )
        return false;
    for ( size_t i = 0; i < corners; ++i )
        out[i] = p->sources[p->t.indices[i]];
    free( p->sources );
    p->sources = out;
    return true;
}

// Gives each triangle vertices of its own with its normal, which is 0 where it has no area: of primitives without normals, as the
// specification requires.
static RfResult make_flat( const RfGltf* gltf, const char* where, RfGltfPrimitive* p )
{
    size_t corners = 3 * (size_t)p->t.count;
    bool room = spread_sources( p ) && rf_spread_vertices( &p->t );
    p->t.normals = room ? malloc( ( 3 * corners + 1 ) * sizeof *p->t.normals ) : NULL;
    if ( p->t.normals == NULL )
        return rf_gltf_no_memory( gltf, where );
    for ( size_t t = 0; t < p->t.count; ++t )
    {
        float normal[3]; // zero for a degenerate triangle, which is dropped later
        rf_face_normal( p->t.positions, p->t.indices + 3 * t, 0.0, normal );
        for ( size_t c = 0; c < 3; ++c )
            memcpy( p->t.normals + 9 * t + 3 * c, normal, sizeof normal );
    }
    p->flat = true;
    return RF_OK;
}

// Reads a primitive of a mesh. Only the vertices that its triangles use are read: exporters
// let many primitives share one large vertex array.

// Accessors of the supported attributes; −1 if missing.
typedef struct Attributes
{
    int accessors[RF_ATTRIBUTE_COUNT];
} Attributes;

void rf_gltf_free_primitive( RfGltfPrimitive* primitive )
{
    rf_destroy_triangles( &primitive->t );
    free( primitive->sources );
    memset( primitive, 0, sizeof *primitive );
}

// With `components` 0 the caller checks their number.
static RfResult open_attribute( RfGltf* gltf, const RfField* primitive, const char* where, const char* name, int components,
                                int* index, uint32_t* count )
{
    const RfGltfAccessor* accessor;
    RF_TRY( rf_gltf_find_attribute( gltf, primitive, name, index ) );
    if ( *index < 0 )
        return RF_OK;
    RF_TRY( rf_gltf_open_accessor( gltf, *index, where, components, &accessor ) );
    if ( *count != 0 && *count != accessor->count )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s has %u elements, POSITION has %u", name, accessor->count, *count );
    *count = accessor->count;
    return RF_OK;
}

static RfResult check_colors( const RfGltf* gltf, const char* where, int index )
{
    if ( index < 0 )
        return RF_OK;
    const RfGltfAccessor* a = gltf->accessors + index;
    bool is_float = a->component_type == 5126;
    bool is_part = ( a->component_type == 5121 || a->component_type == 5123 ) && a->normalized;
    if ( ( a->components == 3 || a->components == 4 ) && ( is_float || is_part ) )
        return RF_OK;
    return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "COLOR_0 must be 3 or 4 floats or normalized unsigned bytes or shorts" );
}

static RfResult open_attributes( RfGltf* gltf, const RfField* primitive, Attributes* out, uint32_t* count )
{
    static const char* const s_names[] = { "POSITION", "NORMAL", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0", "TANGENT" };
    const RfGltfAccessor* packed;
    memset( out, 0xff, sizeof *out );
    *count = 0;
    rf_gltf_require( primitive, "attributes", NULL );
    const RfField attributes = rf_get_object( primitive, "attributes" );
    RfResult result = rf_json_result( primitive );
    if ( result == RF_OK ) // before its attributes are looked for, since it names the primitive in messages
        result = rf_gltf_packed_indices( gltf, primitive, &packed );
    for ( int a = 0; result == RF_OK && a < RF_ATTRIBUTE_COUNT && ( a == 0 || out->accessors[0] >= 0 ); ++a )
    {
        int components = a == RF_COLOR ? 0 : (int)g_rf_attributes[a].components;
        result = open_attribute( gltf, primitive, attributes.path, s_names[a], components, out->accessors + a, count );
        if ( result == RF_OK && a == RF_COLOR )
            result = check_colors( gltf, attributes.path, out->accessors[a] );
    }
    return result;
}

static RfResult reserve_remap( RfGltf* gltf, const char* where, uint32_t count )
{
    if ( count <= gltf->remap_size )
        return RF_OK;
    // doubling, since a file may have its meshes in increasing size
    uint32_t size = count > gltf->remap_size * 2u ? count : gltf->remap_size * 2u;
    free( gltf->remap );
    free( gltf->remap_stamp );
    gltf->remap_size = 0;
    gltf->stamp = 0;
    gltf->remap = malloc( (size_t)size * sizeof *gltf->remap );
    gltf->remap_stamp = calloc( size, sizeof *gltf->remap_stamp );
    if ( gltf->remap == NULL || gltf->remap_stamp == NULL )
        return rf_gltf_no_memory( gltf, where );
    gltf->remap_size = size;
    return RF_OK;
}

// Renumbers the indices in order of first use; `sources` maps each vertex to its index in the
// accessors. Stamps avoid clearing the table for each primitive.
static RfResult compact( RfGltf* gltf, const char* where, uint32_t vertex_count, RfGltfPrimitive* out, uint32_t** sources )
{
    RF_TRY( reserve_remap( gltf, where, vertex_count ) );
    size_t corners = (size_t)out->t.count * 3;
    size_t most = corners < vertex_count ? corners : vertex_count;
    RF_TRY( rf_gltf_allocate( gltf, where, sources, most, sizeof **sources ) );
    uint32_t stamp = ++gltf->stamp;
    for ( size_t i = 0; i < corners; ++i )
    {
        uint32_t vertex = out->t.indices[i];
        if ( gltf->remap_stamp[vertex] != stamp )
        {
            gltf->remap_stamp[vertex] = stamp;
            gltf->remap[vertex] = out->t.vertex_count;
            ( *sources )[out->t.vertex_count++] = vertex;
        }
        out->t.indices[i] = gltf->remap[vertex];
    }
    return RF_OK;
}

// Colours are RGB or RGBA in the file, and become RGBA in [0, 1].
static RfResult read_attribute( const RfGltf* gltf, const char* where, int accessor, int attribute, RfGltfPrimitive* out )
{
    size_t components = g_rf_attributes[attribute].components;
    float** values = rf_attribute( &out->t, attribute );
    if ( accessor < 0 )
        return RF_OK;
    RF_TRY( rf_gltf_allocate( gltf, where, values, (size_t)out->t.vertex_count * components, sizeof **values ) );
    RfResult result = RF_OK;
    for ( uint32_t i = 0; result == RF_OK && i < out->t.vertex_count; ++i )
    {
        float* value = *values + i * components;
        value[components - 1] = 1.0f;
        result = rf_gltf_read_floats( gltf, accessor, out->sources[i], value );
        for ( size_t c = 0; attribute == RF_COLOR && c < components; ++c )
            value[c] = rf_clampf( value[c], 0.0f, 1.0f );
    }
    return result;
}

static RfResult read_vertices( RfGltf* gltf, const char* where, const Attributes* attributes, uint32_t vertex_count,
                               RfGltfPrimitive* out )
{
    RfResult result = compact( gltf, where, vertex_count, out, &out->sources );
    for ( int a = 0; result == RF_OK && a < RF_ATTRIBUTE_COUNT; ++a )
    {
        // glTF: tangents are ignored if there are no normals
        if ( a != RF_TANGENT || attributes->accessors[RF_NORMAL] >= 0 )
            result = read_attribute( gltf, where, attributes->accessors[a], a, out );
    }
    return result;
}

static RfResult find_material( RfGltf* gltf, const RfField* primitive, uint32_t* material )
{
    int index;
    RfResult result = rf_gltf_material_of( gltf, primitive, &index );
    if ( index < 0 && result == RF_OK )
        return rf_gltf_use_default_material( gltf, material );
    *material = (uint32_t)index;
    return result;
}

// For the normal texture of the surface, else of the coat, else for anisotropy. Tangents in the file take precedence.
static RfResult add_tangents( RfGltf* gltf, const char* where, RfGltfPrimitive* out )
{
    const RfMaterial* material = gltf->scene->materials + out->material;
    const RfTextured* textured = material->textured;
    if ( out->t.tangents != NULL || textured == NULL )
        return RF_OK;
    RfTextureSlot slot = textured->refs[RF_TEXTURE_NORMAL].texture >= 0             ? RF_TEXTURE_NORMAL
                         : textured->refs[RF_TEXTURE_CLEARCOAT_NORMAL].texture >= 0 ? RF_TEXTURE_CLEARCOAT_NORMAL
                                                                                    : RF_TEXTURE_ANISOTROPY;
    const RfTextureRef* ref = textured->refs + slot; // without a texture: the first set
    const float* uvs = ref->uv_set == 0 ? out->t.uvs : out->t.uvs1;
    bool anisotropic =
        rf_has_param( rf_bsdf_model( material->kind )->params, RF_PARAM_ANISOTROPY ) && material->anisotropy > 0.0f;
    if ( anisotropic && uvs == NULL )
        rf_gltf_notice( gltf,
                        "%s has neither tangents nor texture coordinates: the anisotropy of material '%.80s' has an arbitrary "
                        "direction there",
                        where, material->name );
    if ( uvs == NULL || ( ref->texture < 0 && !anisotropic ) )
        return RF_OK;
    return make_tangents( gltf, where, ref, out );
}

RfResult rf_gltf_read_primitive( RfGltf* gltf, const RfField* primitive, bool survey, RfGltfPrimitive* out )
{
    const char* where = primitive->path;
    *out = ( RfGltfPrimitive ){ 0 };
    int64_t mode = LIST;
    RF_TRY( rf_get_integer( primitive, "mode", 0, 6, &mode ) );
    if ( mode < LIST )
    {
        rf_gltf_notice( gltf, "points and lines are not drawn: %s is left out", where );
        return RF_OK;
    }
    Attributes attributes;
    uint32_t vertex_count;
    RF_TRY( open_attributes( gltf, primitive, &attributes, &vertex_count ) );
    if ( attributes.accessors[RF_POSITION] < 0 )
    {
        rf_gltf_notice( gltf, "%s has no POSITION: it is left out", where );
        return RF_OK;
    }

    RfResult result = find_material( gltf, primitive, &out->material );
    if ( result == RF_OK )
        result = read_triangles( gltf, primitive, (int)mode, vertex_count, survey, &out->t );
    if ( result == RF_OK && out->t.count > 0 && !survey )
        result = read_vertices( gltf, where, &attributes, vertex_count, out );
    if ( result == RF_OK && out->t.count > 0 && !survey && out->t.normals == NULL )
        result = make_flat( gltf, where, out );
    if ( result == RF_OK && out->t.count > 0 && !survey )
        result = add_tangents( gltf, where, out );
    if ( result != RF_OK )
        rf_gltf_free_primitive( out );
    return result;
}
