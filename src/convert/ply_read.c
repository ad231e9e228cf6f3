#include "convert/ply_read.h"

#include "base/file.h"
#include "convert/ply_file.h"
#include "convert/polygon.h"
#include "image/decode.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_FILE_BYTES ( (uint64_t)64 << 30 )
#define MAX_VERTICES ( 1u << 30 )
#define MAX_TRIANGLES ( 1u << 28 )
#define MAX_CORNERS 65536 // of a polygon
// For cutting polygons: about a second for all of a file, and so many more for
// each corner, that no number of ordinary faces uses them up.
#define CUT_STEPS ( (uint64_t)1 << 28 )
#define CUT_STEPS_PER_CORNER 64

typedef struct Reader
{
    RfPlyFile file;
    RfLog* log;
    RfModelMesh* mesh;
    bool has_vertices;
    size_t triangle_room;
    uint32_t *corners, *cut; // of the polygon at hand
    uint32_t corner_room;
    uint64_t cut_steps; // left
    uint64_t dropped, crossed; // faces of less than three corners; that cross themselves
    uint64_t clamped; // colours
} Reader;

static RfResult no_memory( const Reader* r )
{
    return rf_fail( r->file.error, RF_ERROR_MEMORY, "%s: no memory left to read it", r->file.path );
}

// Where the values of a vertex go.
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

// An array for the properties, which must all be there; NULL where they are not.
static RfResult bind( Reader* r, const RfPlyElement* element, const char* const names[][4], int count, int stride, bool colour,
                      float** values, Slot* slots )
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
        return no_memory( r );
    for ( int k = 0; k < count; ++k )
    {
        RfPlyType type = element->properties[properties[k]].type;
        if ( colour && type != RF_PLY_UINT8 && type != RF_PLY_UINT16 && type < RF_PLY_FLOAT32 )
            return rf_ply_fail( &r->file, "property %s wants uchar, ushort or float: what is white is not known else", names[k][0] );
        slots[properties[k]] = ( Slot ){ *values, stride, k, colour ? colour_scale( type ) : 1.0f, colour,
                                        colour && type < RF_PLY_FLOAT32 && k < 3 };
    }
    return RF_OK;
}

static RfResult bind_vertices( Reader* r, const RfPlyElement* element, Slot* slots )
{
    static const char* const s_places[][4] = { { "x" }, { "y" }, { "z" } };
    static const char* const s_normals[][4] = { { "nx" }, { "ny" }, { "nz" } };
    static const char* const s_uvs[][4] = { { "s", "u", "texture_u" }, { "t", "v", "texture_v" } };
    static const char* const s_colors[][4] = { { "red" }, { "green" }, { "blue" }, { "alpha" } };
    static const char* const s_alpha[] = { "alpha", NULL };
    RfModelMesh* m = r->mesh;
    RfResult result = bind( r, element, s_places, 3, 3, false, &m->positions, slots );
    if ( result == RF_OK && m->positions == NULL )
        return rf_ply_fail( &r->file, "element vertex has no x, y and z" );
    if ( result == RF_OK )
        result = bind( r, element, s_normals, 3, 3, false, &m->normals, slots );
    if ( result == RF_OK )
        result = bind( r, element, s_uvs, 2, 2, false, &m->uvs, slots );
    int channels = find( element, s_alpha ) >= 0 ? 4 : 3;
    if ( result == RF_OK )
        result = bind( r, element, s_colors, channels, 4, true, &m->colors, slots );
    for ( uint64_t i = 0; m->colors != NULL && i < element->count; ++i )
        m->colors[4 * i + 3] = 1.0f;
    return result;
}

static RfResult store( Reader* r, const RfPlyProperty* property, const Slot* slot, uint64_t i )
{
    double value;
    RfResult result = rf_ply_read_value( &r->file, property->type, &value );
    if ( result != RF_OK )
        return result;
    if ( !( fabs( value ) <= 3e38 ) )
        return rf_ply_fail( &r->file, "%s of vertex %llu is no finite number", property->name, (unsigned long long)i );
    float f = (float)value * slot->scale;
    if ( slot->colour && !( f >= 0.0f && f <= 1.0f ) ) // glTF has none such
    {
        f = f > 1.0f ? 1.0f : 0.0f;
        r->clamped += 1;
    }
    slot->values[(size_t)i * (size_t)slot->stride + (size_t)slot->at] = slot->srgb ? rf_srgb_to_linear( f ) : f;
    return RF_OK;
}

static RfResult read_vertices( Reader* r, const RfPlyElement* element )
{
    Slot slots[RF_PLY_MAX_PROPERTIES] = { { 0 } };
    if ( r->has_vertices )
        return rf_ply_fail( &r->file, "has two elements of the name vertex" );
    r->has_vertices = true;
    if ( element->count > MAX_VERTICES )
        return rf_fail( r->file.error, RF_ERROR_UNSUPPORTED, "%s: has more than %u vertices: split it", r->file.path, MAX_VERTICES );
    if ( element->count == 0 )
        return RF_OK;
    RfResult result = bind_vertices( r, element, slots );
    r->mesh->vertex_count = (uint32_t)element->count;
    for ( uint64_t i = 0; result == RF_OK && i < element->count; ++i )
    {
        for ( int k = 0; result == RF_OK && k < element->property_count; ++k )
            result = slots[k].values != NULL ? store( r, element->properties + k, slots + k, i ) : rf_ply_skip( &r->file, element->properties + k );
    }
    return result;
}

static bool reserve_corners( Reader* r, uint32_t count )
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

static RfResult append( Reader* r, uint32_t triangles )
{
    RfModelMesh* m = r->mesh;
    if ( triangles > MAX_TRIANGLES - m->triangle_count )
        return rf_fail( r->file.error, RF_ERROR_UNSUPPORTED, "%s: has more than %u triangles: split it", r->file.path, MAX_TRIANGLES );
    if ( m->triangle_count + (size_t)triangles > r->triangle_room )
    {
        size_t room = 2 * r->triangle_room + triangles + 256;
        uint32_t* grown = realloc( m->indices, room * 3 * sizeof *grown );
        if ( grown == NULL )
            return no_memory( r );
        m->indices = grown;
        r->triangle_room = room;
    }
    memcpy( m->indices + 3 * (size_t)m->triangle_count, r->cut, (size_t)triangles * 3 * sizeof *r->cut );
    m->triangle_count += triangles;
    return RF_OK;
}

static RfResult read_polygon( Reader* r, const RfPlyProperty* property, uint64_t face )
{
    uint32_t count = 0;
    RfResult result = rf_ply_read_count( &r->file, property, &count );
    if ( result == RF_OK && count > MAX_CORNERS )
        return rf_ply_fail( &r->file, "face %llu has %u corners, more than %u", (unsigned long long)face, count, MAX_CORNERS );
    if ( result == RF_OK && !reserve_corners( r, count ) )
        return no_memory( r );
    for ( uint32_t i = 0; result == RF_OK && i < count; ++i )
    {
        double value = 0.0;
        result = rf_ply_read_value( &r->file, property->type, &value );
        if ( result == RF_OK && !( value >= 0.0 && value < (double)r->mesh->vertex_count && value == floor( value ) ) )
            return rf_ply_fail( &r->file, "corner %u of face %llu is vertex %.9g of %u", i, (unsigned long long)face, value, r->mesh->vertex_count );
        r->corners[i] = (uint32_t)value;
    }
    if ( result != RF_OK )
        return result;
    if ( count < 3 )
    {
        r->dropped += 1;
        return RF_OK;
    }
    r->cut_steps += (uint64_t)count * CUT_STEPS_PER_CORNER;
    RfCut cut = rf_cut_polygon( r->mesh->positions, r->corners, count, r->cut, &r->cut_steps );
    if ( cut == RF_CUT_GIVEN_UP )
        return rf_fail( r->file.error, RF_ERROR_UNSUPPORTED, "%s: face %llu of %u corners takes too long to cut: cut it into triangles first",
                        r->file.path, (unsigned long long)face, count );
    r->crossed += cut == RF_CUT_CROSSED;
    return append( r, count - 2 );
}

static RfResult read_faces( Reader* r, const RfPlyElement* element )
{
    int list = -1;
    for ( int k = 0; k < element->property_count && list < 0; ++k )
    {
        const RfPlyProperty* p = element->properties + k;
        if ( p->is_list && ( strcmp( p->name, "vertex_indices" ) == 0 || strcmp( p->name, "vertex_index" ) == 0 ) )
            list = k;
    }
    if ( element->count > 0 && list < 0 )
        return rf_ply_fail( &r->file, "element face has no list vertex_indices" );
    if ( element->count > 0 && !r->has_vertices )
        return rf_ply_fail( &r->file, "its faces come before its vertices" );
    RfResult result = RF_OK;
    for ( uint64_t i = 0; result == RF_OK && i < element->count; ++i )
    {
        for ( int k = 0; result == RF_OK && k < element->property_count; ++k )
            result = k == list ? read_polygon( r, element->properties + k, i ) : rf_ply_skip( &r->file, element->properties + k );
    }
    return result;
}

static RfResult skip_element( Reader* r, const RfPlyElement* element )
{
    RfResult result = RF_OK;
    uint64_t count = element->property_count > 0 ? element->count : 0;
    for ( uint64_t i = 0; result == RF_OK && i < count; ++i )
    {
        for ( int k = 0; result == RF_OK && k < element->property_count; ++k )
            result = rf_ply_skip( &r->file, element->properties + k );
    }
    return result;
}

static RfResult read_elements( Reader* r )
{
    RfResult result = rf_ply_read_header( &r->file );
    for ( int e = 0; result == RF_OK && e < r->file.element_count; ++e )
    {
        const RfPlyElement* element = r->file.elements + e;
        result = rf_ply_check_element( &r->file, element );
        if ( result != RF_OK )
            break;
        if ( strcmp( element->name, "vertex" ) == 0 )
            result = read_vertices( r, element );
        else if ( strcmp( element->name, "face" ) == 0 )
            result = read_faces( r, element );
        else
            result = skip_element( r, element );
    }
    if ( result == RF_OK && r->mesh->triangle_count == 0 )
        return rf_fail( r->file.error, RF_ERROR_FORMAT, "%s: has no faces: points alone are not rendered, make a mesh of them", r->file.path );
    return result;
}

// To unit length, or all are left out: the mesh is flat then. And v runs down.
static void finish_vertices( Reader* r )
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
        rf_warn( r->log, "%s: a normal has no direction: all normals are left out", r->file.path );
        free( m->normals );
        m->normals = NULL;
    }
    for ( uint32_t i = 0; m->uvs != NULL && i < m->vertex_count; ++i )
        m->uvs[2 * (size_t)i + 1] = 1.0f - m->uvs[2 * (size_t)i + 1];
    if ( r->dropped > 0 )
        rf_warn( r->log, "%s: %llu faces of less than three corners are left out", r->file.path, (unsigned long long)r->dropped );
    if ( r->clamped > 0 )
        rf_warn( r->log, "%s: %llu values of colours are not between 0 and 1: taken as the nearer of them", r->file.path,
                 (unsigned long long)r->clamped );
    if ( r->crossed > 0 )
        rf_warn( r->log, "%s: %llu faces cross themselves: they are cut as they come", r->file.path, (unsigned long long)r->crossed );
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
    *model->materials = rf_default_model_material(); // without one glTF has a white metal
    *model->nodes = ( RfModelNode ){ .parent = -1, .matrix = rf_mat4_identity(), .mesh_count = 1, .meshes = meshes };
    return RF_OK;
}

RfResult rf_read_ply( const char* path, RfModel* model, RfLog* log, RfError* error )
{
    *model = ( RfModel ){ 0 };
    Reader* r = calloc( 1, sizeof *r ); // its tables are large for a stack
    uint8_t* bytes = NULL;
    if ( r == NULL || make_model( model ) != RF_OK )
    {
        free( r );
        rf_destroy_model( model );
        return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left to read it", path );
    }
    r->file = ( RfPlyFile ){ .path = path, .error = error };
    r->log = log;
    r->cut_steps = CUT_STEPS;
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
    free( r );
    if ( result != RF_OK )
        rf_destroy_model( model );
    return result;
}
