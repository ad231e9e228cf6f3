// Primitives of meshes: triangles, and only the vertices that they use.
#include "gltf/gltf_mesh.h"
#include "gltf/gltf_material.h"

#include "scene/merge.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
    RfResult result = open_indices( gltf, primitive, &mode, &accessor );
    if ( result == RF_OK )
        result = count_triangles( gltf, where, mode, accessor != NULL ? accessor->count : vertex_count, &out->count );
    if ( result != RF_OK || survey )
        return result;

    out->indices = malloc( ( (size_t)out->count * 3 + 1 ) * sizeof *out->indices );
    if ( out->indices == NULL )
        return rf_gltf_no_memory( gltf, where );
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
    RfResult result = rf_gltf_find_attribute( gltf, primitive, name, index );
    if ( result != RF_OK || *index < 0 )
        return result;
    result = rf_gltf_open_accessor( gltf, *index, where, components, &accessor );
    if ( result != RF_OK )
        return result;
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
    RfResult result = reserve_remap( gltf, where, vertex_count );
    if ( result != RF_OK )
        return result;
    size_t corners = (size_t)out->t.count * 3;
    size_t most = corners < vertex_count ? corners : vertex_count;
    *sources = malloc( ( most + 1 ) * sizeof **sources );
    if ( *sources == NULL )
        return rf_gltf_no_memory( gltf, where );
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
    *values = malloc( ( (size_t)out->t.vertex_count * components + 1 ) * sizeof **values );
    if ( *values == NULL )
        return rf_gltf_no_memory( gltf, where );
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
    return rf_gltf_make_tangents( gltf, where, ref, out );
}

RfResult rf_gltf_read_primitive( RfGltf* gltf, const RfField* primitive, bool survey, RfGltfPrimitive* out )
{
    const char* where = primitive->path;
    *out = ( RfGltfPrimitive ){ 0 };
    int64_t mode = LIST;
    RfResult result = rf_get_integer( primitive, "mode", 0, 6, &mode );
    if ( result != RF_OK )
        return result;
    if ( mode < LIST )
    {
        rf_gltf_notice( gltf, "points and lines are not drawn: %s is left out", where );
        return RF_OK;
    }
    Attributes attributes;
    uint32_t vertex_count;
    result = open_attributes( gltf, primitive, &attributes, &vertex_count );
    if ( result != RF_OK )
        return result;
    if ( attributes.accessors[RF_POSITION] < 0 )
    {
        rf_gltf_notice( gltf, "%s has no POSITION: it is left out", where );
        return RF_OK;
    }

    result = find_material( gltf, primitive, &out->material );
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
