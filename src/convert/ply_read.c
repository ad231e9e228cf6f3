// Builds a mesh from PLY: polygons are triangulated (convert/polygon.h), strips are unrolled.
#include "base/try.h"
#include "convert/model.h"

#include "base/file.h"
#include "convert/ply_file.h"
#include "convert/polygon.h"
#include "image/decode.h"
#include "scene/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct RfPlyReader
{
    RfPlyFile file;
    RfLog* log;
    RfModelMesh* mesh;
    bool has_vertices;
    size_t triangle_room;
    uint32_t *corners, *cut; // the current polygon and its triangles
    uint32_t corner_room;
    RfCutter cutter;
    uint64_t dropped, crossed; // faces and strips of fewer than three corners; self-intersecting faces
    uint64_t clamped;          // colours outside [0, 1]
} RfPlyReader;

static inline RfResult rf_ply_no_memory( const RfPlyReader* r )
{
    return rf_fail( r->file.error, RF_ERROR_MEMORY, "%s: out of memory reading it", r->file.path );
}

// Vertices of PLY: positions, normals, texture coordinates, colours.

#define MAX_VERTICES ( 1u << 30 )

// The destination of a vertex property.
typedef struct Slot
{
    float* values;
    int stride, at;
    float scale;
    bool colour, srgb;
} Slot;

static float colour_scale( RfPlyType type )
{
    switch ( type )
    {
        case RF_PLY_UINT8: return 1.0f / 255.0f;
        case RF_PLY_UINT16: return 1.0f / 65535.0f;
        default: return 1.0f;
    }
}

static int find( const RfPlyElement* element, const char* const* names )
{
    for ( ; *names != NULL; ++names )
    {
        for ( int i = 0; i < element->property_count; ++i )
        {
            if ( strcmp( element->properties[i].name, *names ) == 0 && !element->properties[i].is_list )
                return i;
        }
    }
    return -1;
}

// Allocates an array for a group of properties if all of them exist, else NULL.
static RfResult bind( RfPlyReader* r, const RfPlyElement* element, const char* const names[][4], int count, int stride,
                      bool colour, float** values, Slot* slots )
{
    int properties[4];
    for ( int k = 0; k < count; ++k )
    {
        properties[k] = find( element, names[k] );
        if ( properties[k] < 0 )
            return RF_OK;
    }
    *values = malloc( (size_t)element->count * (size_t)stride * sizeof( float ) );
    if ( *values == NULL )
        return rf_ply_no_memory( r );
    for ( int k = 0; k < count; ++k )
    {
        RfPlyType type = element->properties[properties[k]].type;
        if ( colour && type != RF_PLY_UINT8 && type != RF_PLY_UINT16 && type < RF_PLY_FLOAT32 )
            return rf_ply_fail( &r->file,
                                "property %s must be uchar, ushort or float: the white value of other types is undefined",
                                names[k][0] );
        slots[properties[k]] = ( Slot ){ *values, stride,
                                         k,       colour ? colour_scale( type ) : 1.0f,
                                         colour,  colour && type < RF_PLY_FLOAT32 && k < 3 };
    }
    return RF_OK;
}

static RfResult bind_vertices( RfPlyReader* r, const RfPlyElement* element, Slot* slots )
{
    static const char* const s_places[][4] = { { "x" }, { "y" }, { "z" } };
    static const char* const s_normals[][4] = { { "nx" }, { "ny" }, { "nz" } };
    static const char* const s_uvs[][4] = { { "s", "u", "texture_u" }, { "t", "v", "texture_v" } };
    static const char* const s_colors[][4] = { { "red" }, { "green" }, { "blue" }, { "alpha" } };
    static const char* const s_alpha[] = { "alpha", NULL };
    RfModelMesh* m = r->mesh;
    RF_TRY( bind( r, element, s_places, 3, 3, false, &m->positions, slots ) );
    if ( m->positions == NULL )
        return rf_ply_fail( &r->file, "element vertex has no x, y and z" );
    RF_TRY( bind( r, element, s_normals, 3, 3, false, &m->normals, slots ) );
    RF_TRY( bind( r, element, s_uvs, 2, 2, false, &m->uvs, slots ) );
    RF_TRY( bind( r, element, s_colors, find( element, s_alpha ) >= 0 ? 4 : 3, 4, true, &m->colors, slots ) );
    for ( uint64_t i = 0; m->colors != NULL && i < element->count; ++i )
        m->colors[4 * i + 3] = 1.0f;
    return RF_OK;
}

static RfResult store( RfPlyReader* r, const RfPlyProperty* property, const Slot* slot, uint64_t i )
{
    double value;
    RF_TRY( rf_ply_read_value( &r->file, property->type, &value ) );
    if ( !( fabs( value ) <= 3e38 ) )
        return rf_ply_fail( &r->file, "%s of vertex %llu is not a finite number", property->name, (unsigned long long)i );
    float f = (float)value * slot->scale;
    if ( slot->colour && !( f >= 0.0f && f <= 1.0f ) ) // glTF colours are limited to 0 to 1
    {
        f = f > 1.0f ? 1.0f : 0.0f;
        r->clamped += 1;
    }
    slot->values[(size_t)i * (size_t)slot->stride + (size_t)slot->at] = slot->srgb ? rf_srgb_to_linear( f ) : f;
    return RF_OK;
}

static RfResult read_vertices( RfPlyReader* r, const RfPlyElement* element )
{
    Slot slots[RF_PLY_MAX_PROPERTIES] = { { 0 } };
    if ( r->has_vertices )
        return rf_ply_fail( &r->file, "has two elements named vertex" );
    r->has_vertices = true;
    if ( element->count > MAX_VERTICES )
        return rf_fail( r->file.error, RF_ERROR_UNSUPPORTED, "%s: has more than %u vertices: split it", r->file.path,
                        MAX_VERTICES );
    if ( element->count == 0 )
        return RF_OK;
    RF_TRY( bind_vertices( r, element, slots ) );
    r->mesh->vertex_count = (uint32_t)element->count;
    for ( uint64_t i = 0; i < element->count; ++i )
    {
        for ( int k = 0; k < element->property_count; ++k )
            RF_TRY( slots[k].values != NULL ? store( r, element->properties + k, slots + k, i )
                                            : rf_ply_skip( &r->file, element->properties + k ) );
    }
    return RF_OK;
}

// Post-processes the vertices after the last element, and warns.
static void finish_vertices( RfPlyReader* r )
{
    RfModelMesh* m = r->mesh;
    bool whole = m->normals != NULL;
    for ( uint32_t i = 0; whole && i < m->vertex_count; ++i )
    {
        float* n = m->normals + 3 * (size_t)i;
        double length = sqrt( (double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] + (double)n[2] * (double)n[2] );
        whole = length > 1e-12 && isfinite( length );
        for ( int c = 0; whole && c < 3; ++c )
            n[c] = (float)( (double)n[c] / length );
    }
    if ( m->normals != NULL && !whole )
    {
        rf_warn( r->log, "%s: a normal has length 0: all normals are left out", r->file.path );
        free( m->normals );
        m->normals = NULL;
    }
    for ( uint32_t i = 0; m->uvs != NULL && i < m->vertex_count; ++i )
        m->uvs[2 * (size_t)i + 1] = 1.0f - m->uvs[2 * (size_t)i + 1];
    if ( r->dropped > 0 )
        rf_warn( r->log, "%s: %llu faces of less than three corners are left out", r->file.path, (unsigned long long)r->dropped );
    if ( r->clamped > 0 )
        rf_warn( r->log, "%s: %llu colour values are not between 0 and 1: they are clamped", r->file.path,
                 (unsigned long long)r->clamped );
    if ( r->crossed > 0 )
        rf_warn( r->log, "%s: %llu faces intersect themselves: their triangulation may be wrong", r->file.path,
                 (unsigned long long)r->crossed );
}

// Triangulates the faces and strips of PLY.

#define MAX_TRIANGLES ( 1u << 28 )
#define MAX_CORNERS 65536 // per polygon

static bool reserve_corners( RfPlyReader* r, uint32_t count )
{
    if ( count <= r->corner_room )
        return true;
    free( r->corners );
    free( r->cut );
    r->corner_room = 2 * count;
    r->corners = malloc( (size_t)r->corner_room * sizeof *r->corners );
    r->cut = malloc( 3 * (size_t)r->corner_room * sizeof *r->cut );
    return r->corners != NULL && r->cut != NULL;
}

static RfResult append( RfPlyReader* r, uint32_t triangles )
{
    RfModelMesh* m = r->mesh;
    if ( triangles > MAX_TRIANGLES - m->triangle_count )
        return rf_fail( r->file.error, RF_ERROR_UNSUPPORTED, "%s: has more than %u triangles: split it", r->file.path,
                        MAX_TRIANGLES );
    if ( m->triangle_count + (size_t)triangles > r->triangle_room )
    {
        size_t room = 2 * r->triangle_room + triangles + 256;
        if ( !rf_make_room( &m->indices, 3 * room, sizeof *m->indices ) )
            return rf_ply_no_memory( r );
        r->triangle_room = room;
    }
    memcpy( m->indices + 3 * (size_t)m->triangle_count, r->cut, (size_t)triangles * 3 * sizeof *r->cut );
    m->triangle_count += triangles;
    return RF_OK;
}

static bool is_vertex( const RfPlyReader* r, double value )
{
    return value >= 0.0 && value < (double)r->mesh->vertex_count && value == floor( value );
}

static RfResult read_polygon( RfPlyReader* r, const RfPlyProperty* property, uint64_t face )
{
    uint32_t count = 0;
    RF_TRY( rf_ply_read_count( &r->file, property, &count ) );
    if ( count > MAX_CORNERS )
        return rf_ply_fail( &r->file, "face %llu has %u corners, more than %u", (unsigned long long)face, count, MAX_CORNERS );
    if ( !reserve_corners( r, count ) )
        return rf_ply_no_memory( r );
    for ( uint32_t i = 0; i < count; ++i )
    {
        double value = 0.0;
        RF_TRY( rf_ply_read_value( &r->file, property->type, &value ) );
        if ( !is_vertex( r, value ) )
            return rf_ply_fail( &r->file, "corner %u of face %llu is vertex %.9g of %u", i, (unsigned long long)face, value,
                                r->mesh->vertex_count );
        r->corners[i] = (uint32_t)value;
    }
    if ( count < 3 )
    {
        r->dropped += 1;
        return RF_OK;
    }
    RfCut cut = rf_cut_polygon( r->mesh->positions, r->corners, count, r->cut, &r->cutter );
    if ( cut == RF_CUT_NO_MEMORY )
        return rf_ply_no_memory( r );
    if ( cut == RF_CUT_GIVEN_UP )
        return rf_fail( r->file.error, RF_ERROR_UNSUPPORTED,
                        "%s: face %llu of %u corners takes too long to triangulate: triangulate it first", r->file.path,
                        (unsigned long long)face, count );
    r->crossed += cut == RF_CUT_CROSSED;
    return append( r, count - 2 );
}

static RfResult find_corners( const RfPlyReader* r, const RfPlyElement* element, int* list )
{
    *list = -1;
    for ( int k = 0; k < element->property_count && *list < 0; ++k )
    {
        const RfPlyProperty* p = element->properties + k;
        if ( p->is_list && ( strcmp( p->name, "vertex_indices" ) == 0 || strcmp( p->name, "vertex_index" ) == 0 ) )
            *list = k;
    }
    if ( element->count > 0 && *list < 0 )
        return rf_ply_fail( &r->file, "element %s has no list vertex_indices", element->name );
    if ( element->count > 0 && !r->has_vertices )
        return rf_ply_fail( &r->file, "its %s come before its vertices",
                            strcmp( element->name, "face" ) == 0 ? "faces" : element->name );
    return RF_OK;
}

typedef RfResult ReadList( RfPlyReader* r, const RfPlyProperty* property, uint64_t item );

// Reads list number `list` of all items of an element by `read`, and skips all else; −1: skips all.
static RfResult read_items( RfPlyReader* r, const RfPlyElement* element, int list, ReadList* read )
{
    uint64_t count = element->property_count > 0 ? element->count : 0;
    for ( uint64_t i = 0; i < count; ++i )
    {
        for ( int k = 0; k < element->property_count; ++k )
            RF_TRY( k == list ? read( r, element->properties + k, i ) : rf_ply_skip( &r->file, element->properties + k ) );
    }
    return RF_OK;
}

static RfResult read_faces( RfPlyReader* r, const RfPlyElement* element )
{
    int list = -1;
    RF_TRY( find_corners( r, element, &list ) );
    return read_items( r, element, list, read_polygon );
}

// Adds a corner to a strip: `at` corners came before it since the last -1, the last two of
// which are in r->corners.
static RfResult add_corner( RfPlyReader* r, uint32_t corner, uint32_t at )
{
    uint32_t a = r->corners[0], b = r->corners[1];
    r->corners[0] = at > 0 ? b : corner;
    r->corners[1] = corner;
    if ( at < 2 || a == b || b == corner || a == corner ) // strips contain degenerate triangles to change direction
        return RF_OK;
    r->cut[0] = at % 2 == 0 ? a : b;
    r->cut[1] = at % 2 == 0 ? b : a;
    r->cut[2] = corner;
    return append( r, 1 );
}

static RfResult read_strips( RfPlyReader* r, const RfPlyProperty* property, uint64_t element )
{
    uint32_t count = 0, at = 0;
    RF_TRY( rf_ply_read_count( &r->file, property, &count ) );
    for ( uint32_t i = 0; i < count; ++i )
    {
        double value = 0.0;
        RF_TRY( rf_ply_read_value( &r->file, property->type, &value ) );
        bool ends = value == -1.0;
        if ( !ends && !is_vertex( r, value ) )
            return rf_ply_fail( &r->file, "corner %u of tristrips %llu is vertex %.9g of %u, and not -1", i,
                                (unsigned long long)element, value, r->mesh->vertex_count );
        if ( !ends )
            RF_TRY( add_corner( r, (uint32_t)value, at ) );
        r->dropped += ends && at > 0 && at < 3;
        at = ends ? 0 : at + 1;
    }
    r->dropped += at > 0 && at < 3;
    return RF_OK;
}

// Reads triangle strips separated by -1; every second triangle of a strip is flipped.
static RfResult ply_read_strips( RfPlyReader* r, const RfPlyElement* element )
{
    int list = -1;
    RF_TRY( find_corners( r, element, &list ) );
    return reserve_corners( r, 3 ) ? read_items( r, element, list, read_strips ) : rf_ply_no_memory( r );
}

#define MAX_FILE_BYTES ( (uint64_t)64 << 30 )

static RfResult read_elements( RfPlyReader* r )
{
    RF_TRY( rf_ply_read_header( &r->file ) );
    for ( int e = 0; e < r->file.element_count; ++e )
    {
        const RfPlyElement* element = r->file.elements + e;
        RF_TRY( rf_ply_check_element( &r->file, element ) );
        if ( strcmp( element->name, "vertex" ) == 0 )
            RF_TRY( read_vertices( r, element ) );
        else if ( strcmp( element->name, "face" ) == 0 )
            RF_TRY( read_faces( r, element ) );
        else if ( strcmp( element->name, "tristrips" ) == 0 )
            RF_TRY( ply_read_strips( r, element ) );
        else
            RF_TRY( read_items( r, element, -1, NULL ) );
    }
    RF_TRY( rf_ply_check_end( &r->file ) );
    if ( r->mesh->triangle_count == 0 )
        return rf_fail( r->file.error, RF_ERROR_FORMAT, "%s: has no faces: points alone cannot be rendered, make a mesh of them",
                        r->file.path );
    return RF_OK;
}

static RfResult make_model( RfModel* model )
{
    model->meshes = calloc( 1, sizeof *model->meshes );
    model->nodes = calloc( 1, sizeof *model->nodes );
    model->materials = malloc( sizeof *model->materials );
    int* meshes = calloc( 1, sizeof *meshes );
    if ( model->meshes == NULL || model->nodes == NULL || model->materials == NULL || meshes == NULL )
    {
        free( meshes );
        return RF_ERROR_MEMORY;
    }
    model->mesh_count = model->node_count = model->material_count = 1;
    *model->materials = rf_default_model_material(); // glTF's own default material is a white metal
    *model->nodes = ( RfModelNode ){ .parent = -1, .matrix = rf_mat4_identity(), .mesh_count = 1, .meshes = meshes };
    return RF_OK;
}

RfResult rf_read_ply( const char* path, RfModel* model, RfLog* log, RfError* error )
{
    *model = ( RfModel ){ 0 };
    RfPlyReader* r = calloc( 1, sizeof *r ); // on the heap, since its tables are large
    uint8_t* bytes = NULL;
    if ( r == NULL || make_model( model ) != RF_OK )
    {
        free( r );
        rf_destroy_model( model );
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory reading it", path );
    }
    r->file = ( RfPlyFile ){ .path = path, .error = error };
    r->log = log;
    r->cutter.steps = RF_CUT_STEPS;
    r->mesh = model->meshes;
    RfResult result = rf_read_file( path, MAX_FILE_BYTES, &bytes, &r->file.size, error );
    r->file.bytes = bytes;
    if ( result == RF_OK )
        result = read_elements( r );
    if ( result == RF_OK )
        finish_vertices( r );
    free( bytes );
    free( r->corners );
    free( r->cut );
    rf_free_cutter( &r->cutter );
    free( r );
    if ( result != RF_OK )
        rf_destroy_model( model );
    return result;
}
